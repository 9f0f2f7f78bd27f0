"""Proven bounds of the errors of outputs."""
