"""Certain rewriting, one pass a file, in the order of `order`."""
