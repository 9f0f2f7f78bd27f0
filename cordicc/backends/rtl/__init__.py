"""Verilog of a plan: modules of its units, the plan itself, and what tests them."""
