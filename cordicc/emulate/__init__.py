"""Running plans, bit-true: functional, or clock by clock; files of samples; what is seen of errors."""
