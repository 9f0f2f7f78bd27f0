"""Studies beside compiling: the trade-off of a problem, iteration tables, stages, shift sequences, their search."""
