"""Numbers: formats, shift sequences, micro-rotations, the arithmetic units, and intervals."""
