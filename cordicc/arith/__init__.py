"""CORDIC arithmetic, bit by bit: number formats, shift sequences, micro-rotations, units and their bounds."""
