"""Studies beside compiling: the trade-off of a problem, iteration tables, shift sequences, their search."""
