"""What every operation means, one arithmetic a file, each a table by the operations of `cordicc.ir.ops`.

`exact` folds constants; `reference` is the yardstick, on rounded numbers of quadruple precision, for most
samples by way of `balls` with proven radii; `intervals` are numbers between floats and `enclosures` the
operations on them; `doubles` looks at many samples quickly; `roundings` tells how far rounding moves results.
"""
