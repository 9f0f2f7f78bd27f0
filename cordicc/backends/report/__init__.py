"""The report, one HTML page, and its fragment for notebooks."""
