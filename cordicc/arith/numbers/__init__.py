"""Number formats: fixed and floating point words, what they hold, how they round, and operations on them."""
