"""Circuits of integers: what the units are in hardware, run in NumPy and written as hardware text."""
