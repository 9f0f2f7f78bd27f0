"""The scheduling problem as data, and the algorithms that solve it."""
