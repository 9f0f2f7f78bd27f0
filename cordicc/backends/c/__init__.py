"""The bit-accurate C99 model."""
