"""The bits of every unit operation on random words, as they were when they were last changed on purpose."""

import hashlib

import pytest

from tests.support.unit_words import OPERATIONS, UNITS, operands, results

DIGESTS = {
    "24-stage": "723cfb73235e932b",
    "single": "9b45d054b75c4524",
    "root-free": "ca8a32e22d2bc4ce",
    "widest": "4f9de27960df813c",
    "widest root-free": "975e62156e0c44d9",
    "narrow": "96085475fb194ea1",
    "narrowest": "58406a88a1077eba",
    "odd": "00fd939caf12db4e",
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
