"""Messages as bytes, against layouts and checksums written out independently."""

import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from llsrbm.errors import Error
from llsrbm.wire.layout import Layout
from llsrbm.wire.unitree_layouts import FAMILIES
from tests.llsrbm.wire.unitree_reference import (
    FORMATS,
    SIZES,
    checksum,
    fill,
    flat,
    random_record,
)

LAYOUTS = [layout for family in FAMILIES.values() for layout in family]
each_layout = pytest.mark.parametrize("layout", LAYOUTS, ids=lambda layout: layout.type_name)
COUNT = 500  # of each of four types


@each_layout
def test_messages_are_packed_as_published(layout):
    rng = np.random.default_rng(11)
    form = struct.Struct(FORMATS[layout.type_name])
    assert layout.dtype.itemsize == form.size == SIZES[layout.type_name]
    records = np.zeros(COUNT, layout.dtype)
    fill(records, rng)
    for record, numbers in zip(records, records.tolist(), strict=True):
        assert record.tobytes() == form.pack(*flat(numbers))


@each_layout
def test_checksums_are_those_of_a_table_of_bytes(layout):
    rng = np.random.default_rng(12)
    for _ in range(100):
        record = random_record(layout, rng)
        assert Layout.checksum(record) == checksum(record.tobytes())


def test_the_checksums_table_is_the_known_one():
    """The check value of CRC-32/MPEG-2: 0x0376E6E7 of the digits 1 to 9."""
    digits = b"123456789"
    crc = 0xFFFFFFFF
    for byte in digits:
        for bit in range(8):
            top = (crc >> 31) ^ (byte >> (7 - bit) & 1)
            crc = (crc << 1 & 0xFFFFFFFF) ^ (0x04C11DB7 if top else 0)
    assert crc == 0x0376E6E7
    words = np.zeros((), [("words", "<u4", 3)])
    words["words"][:2] = int.from_bytes(b"1234", "big"), int.from_bytes(b"5678", "big")
    assert checksum(words.tobytes()) == Layout.checksum(words)


@given(st.binary(min_size=803, max_size=803), st.integers(0, 799), st.integers(0, 7))
def test_a_flipped_bit_changes_the_checksum(data, byte, bit):
    layout = FAMILIES["unitree_go"].command
    packed = np.frombuffer(data.ljust(layout.dtype.itemsize, b"\0"), np.uint8).copy()
    before = Layout.checksum(packed.view(layout.dtype).reshape(()))
    packed[byte] ^= 1 << bit
    assert Layout.checksum(packed.view(layout.dtype).reshape(())) != before


@each_layout
def test_the_wire_and_back(layout):
    rng = np.random.default_rng(13)
    record = random_record(layout, rng)
    wire = layout.to_wire(record)
    assert len(wire) % 4 == 0
    assert layout.from_wire(wire) == record
    assert layout.from_wire(wire + b"\0\0\0\0") == record  # padding of the transport


@each_layout
def test_the_wire_is_that_of_the_dds_package(layout):
    pytest.importorskip("cyclonedds", reason="needs the extra llsrbm[wire]")
    from llsrbm.wire.dds import _structure

    rng = np.random.default_rng(14)
    package = _structure(layout.type_name, layout.dtype)
    assert package.__idl_typename__ == layout.type_name
    for _ in range(5):
        record = random_record(layout, rng)
        sample = package.deserialize(layout.to_wire(record))
        assert sample.crc == int(record["crc"])
        assert sample.serialize(use_version_2=False) == layout.to_wire(record)


@given(st.binary(max_size=900))
def test_other_bytes_are_refused_in_one_line(data):
    layout = FAMILIES["unitree_go"].command
    if data[:2] == b"\0\1" and len(data) >= 812:
        layout.from_wire(data)
        return
    with pytest.raises(Error, match=r"LowCmd_: expected 812 bytes of plain little-endian CDR"):
        layout.from_wire(data)
