"""What a plan takes on a chip: yosys and nextpnr run on its Verilog, and what they say read back."""
