"""Robots as input: Denavit-Hartenberg tables."""
