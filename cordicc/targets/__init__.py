"""Targets: the hardware that a plan is made for, one YAML file each, their reading and their sizes."""
