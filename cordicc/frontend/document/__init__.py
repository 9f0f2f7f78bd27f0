"""YAML with positions, and its errors."""
