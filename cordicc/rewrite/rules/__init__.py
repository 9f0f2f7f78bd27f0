"""Alternatives of the search, one rule or family of rules a file."""
