"""What every operation means, one arithmetic a file: exact, doubles, balls, intervals, roundings."""
