"""Micro-rotations and what is proven of them: shift sequences, loops, range reduction, convergence."""
