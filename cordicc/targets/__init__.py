"""Targets: the hardware a plan is made for."""
