"""The bits of every unit operation on random words, as they were when the kernels were plain."""

import hashlib

import pytest

from tests.support.unit_words import OPERATIONS, UNITS, operands, results

DIGESTS = {
    "24-stage": "31956aded395ca3f",
    "single": "fcf374d2b562de5c",
    "root-free": "77387bc3a906c89f",
    "widest": "0bef508a3e630f10",
    "widest root-free": "6e9f113869f5e68b",
    "narrow": "9d4ec7ef776ef524",
    "narrowest": "fb0b89742bfab760",
    "odd": "5b6aef0553472e59",
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
