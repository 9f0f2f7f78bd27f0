"""The same arithmetic compiled by numba, with the same bits; imported only where numba is installed."""
