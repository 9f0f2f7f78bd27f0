"""Plans in words and formulas: summary, explanation, differences, what was recognised."""
