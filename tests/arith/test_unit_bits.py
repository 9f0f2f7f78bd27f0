"""The bits of every unit operation on random words, as they were when the kernels were plain."""

import hashlib

import pytest

from tests.support.unit_words import OPERATIONS, UNITS, operands, results

DIGESTS = {
    "24-stage": "31956aded395ca3f",
    "single": "fcf374d2b562de5c",
    "root-free": "0ebdabd5cacea6fd",
    "widest": "d115b4bf34929fc1",
    "widest root-free": "17acb96fc83890d1",
    "narrow": "d305fc810fe57bbc",
    "narrowest": "f6c9aabcdb6c3957",
    "odd": "b31d38d4e2c118c3",
}


@pytest.mark.parametrize("name", UNITS)
def test_every_operation_keeps_its_bits(name: str) -> None:
    unit = UNITS[name]
    values = operands(0, 4000, unit.operand_bits)
    digest = hashlib.sha256()
    for operation, params in OPERATIONS:
        for bits in results(unit, operation, params, values):
            digest.update(bits.tobytes())
    assert digest.hexdigest()[:16] == DIGESTS[name]
