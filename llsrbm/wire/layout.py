"""`Layout`: a message of plain numbers, as a C structure and on a DDS wire.

Makers compute checksums over the C structure, in which every number lies at a multiple of its size
and a structure's size is a multiple of its largest number's. On the wire (CDR) numbers lie at such
places, too, but structures have no end of their own. Bytes are moved from one to the other at a
stroke: a serialiser that goes from field to field in Python takes a third of a robot's tick.
"""

import zlib
from collections.abc import Iterator
from typing import Any

import numpy as np

from llsrbm.errors import Error

Record = np.ndarray[Any, np.dtype[np.void]]  # (), one message; fields by name

_HEADER = bytes([0, 1, 0, 0])  # encapsulation: plain CDR, version 1, little endian
_REVERSED_BITS = bytes(int(f"{byte:08b}"[::-1], 2) for byte in range(256))
_ALL_ONES = 0xFFFFFFFF


class Layout:
    """One message type.

    Attributes:
        type_name: of the interface definition, such as "unitree_go.msg.dds_.LowCmd_".
        dtype: fields in their order, little endian, laid out as C does.
    """

    def __init__(self, type_name: str, fields: list[Any]) -> None:
        self.type_name = type_name
        self.dtype = np.dtype(fields, align=True)
        in_c: list[int] = []
        on_wire: list[int] = []
        at = 0
        for place, size in _numbers(self.dtype, 0):
            at = -(-at // size) * size
            in_c += range(place, place + size)
            on_wire += range(at, at + size)
            at += size
        self._in_c, self._on_wire, self._wire_size = np.array(in_c), np.array(on_wire), at

    def blank(self) -> Record:
        """A message of zeros."""
        return np.zeros((), self.dtype)

    def to_wire(self, record: Record) -> bytes:
        """The message as DDS sends it, with its encapsulation."""
        wire = np.zeros(self._wire_size, np.uint8)
        wire[self._on_wire] = np.frombuffer(record.tobytes(), np.uint8)[self._in_c]
        return _HEADER + wire.tobytes()

    def from_wire(self, data: bytes) -> Record:
        """The message that DDS has received. Raises `Error`: it is not one of this type."""
        wire = np.frombuffer(data, np.uint8)
        if data[:2] != _HEADER[:2] or len(wire) < 4 + self._wire_size:
            raise Error(
                f"{self.type_name}: expected {4 + self._wire_size} bytes of plain little-endian "
                f"CDR, got {len(wire)}, beginning {data[:4].hex()}"
            )
        packed = np.zeros(self.dtype.itemsize, np.uint8)
        packed[self._in_c] = wire[4:][self._on_wire]
        return packed.view(self.dtype).reshape(())

    @staticmethod
    def checksum(record: Record) -> int:
        """Checksum of the C structure without its last word, where Unitree's robots expect it.

        CRC-32 of polynomial 04C11DB7 and start FFFFFFFF, not reflected, no final inversion, over
        words of which the most significant byte comes first. zlib's is the reflected one, with it.
        """
        words = np.frombuffer(record.tobytes(), "<u4")[:-1]
        reflected = zlib.crc32(words.byteswap().tobytes().translate(_REVERSED_BITS)) ^ _ALL_ONES
        return int(f"{reflected:032b}"[::-1], 2)


def _numbers(dtype: np.dtype[Any], start: int) -> Iterator[tuple[int, int]]:
    """Place and size, bytes, of every single number of a structure that begins at `start`."""
    if dtype.subdtype is not None:
        one, shape = dtype.subdtype
        for k in range(int(np.prod(shape))):
            yield from _numbers(one, start + k * one.itemsize)
    elif dtype.fields is None:
        yield start, dtype.itemsize
    else:
        for name in dtype.names or ():
            yield from _numbers(dtype[name], start + dtype.fields[name][1])
