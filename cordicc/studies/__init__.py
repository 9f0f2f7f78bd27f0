"""Studies beside compiling: the trade-off of a problem, iterations, stages, shift sequences, their search."""
