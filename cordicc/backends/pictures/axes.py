"""What the axes of charts share: the steps from one mark to the next."""

ROUND_STEPS = tuple(base * 10**power for power in range(18) for base in (1, 2, 5))
"""1, 2, 5, 10, 20, ... in ascending order."""
