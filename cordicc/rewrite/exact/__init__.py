"""Exact algebra over a tower of square roots, and the values with what is known of them."""
