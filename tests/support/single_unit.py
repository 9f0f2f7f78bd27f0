"""A unit between IEEE single words: operands decoded exactly, results rounded as a target does it."""

import numpy as np

from cordicc.arith.numbers.formats import SINGLE
from cordicc.arith.unit.cau import Cau


class SingleUnit:
    def __init__(self, **fields):
        self.cau = Cau(**fields)

    def rotate(self, m, *operands):
        return tuple(SINGLE.encode(result) for result in self.cau.rotate(m, *_values(operands)))

    def vector(self, m, sign, *operands):
        norm, angle = self.cau.vector(m, sign, *_values(operands))
        return SINGLE.encode(norm), (SINGLE.encode_angle if m == 1 else SINGLE.encode)(angle)

    def lightcone(self, *operands):
        return tuple(SINGLE.encode(result) for result in self.cau.lightcone(*_values(operands)))

    def implicit(self, m, branch, *operands):
        angle, rest = self.cau.implicit(m, branch, *_values(operands))
        return (SINGLE.encode_angle if m == 1 else SINGLE.encode)(angle), SINGLE.encode(rest)


def _values(operands):
    return [SINGLE.decode(np.atleast_1d(operand)) for operand in operands]
