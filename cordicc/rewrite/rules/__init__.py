"""Rules that add alternatives to what is there: one or a family a file, their list in `catalogue`."""
