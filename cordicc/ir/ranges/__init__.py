"""Ranges of values: forward, by contraction with what is known, and by subdivision."""
