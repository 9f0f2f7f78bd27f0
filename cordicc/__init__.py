"""cordicc: a compiler from kinematic equations to CORDIC hardware plans."""

__version__ = "0.1.0"
