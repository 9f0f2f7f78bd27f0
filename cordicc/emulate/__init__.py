"""Emulation of a plan: `functional` for what it computes, `cycle` for how, clock by clock."""
