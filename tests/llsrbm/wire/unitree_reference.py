"""The published layouts of Unitree's messages, written out by hand, and its checksum bit by bit."""

import struct

import numpy as np

# Structure formats: B u8, H u16, h i16, i i32, I u32, f f32, x padding.
FORMATS = {
    "unitree_go.msg.dds_.LowCmd_": "<4B4IH2x" + "B3x5f3I" * 20 + "4B55Bx2I",
    "unitree_go.msg.dds_.LowState_": (
        "<4B4IH2x" + "13fB3x" + "B3x7fB3x3I" * 20 + "4BiH4B15H" + "8hI41B3xf2B2x2f4H2I"
    ),
    "unitree_hg.msg.dds_.LowCmd_": "<2B2x" + "B3x5fI" * 35 + "5I",
    "unitree_hg.msg.dds_.LowState_": "<2I2B2xI" + "13fh2x" + "B3x4f2hf7I" * 35 + "40B5I",
}
SIZES = {
    "unitree_go.msg.dds_.LowCmd_": 812,
    "unitree_go.msg.dds_.LowState_": 1180,
    "unitree_hg.msg.dds_.LowCmd_": 1004,
    "unitree_hg.msg.dds_.LowState_": 2092,
}
_POLYNOMIAL = 0x04C11DB7
_TABLE = []
for byte in range(256):
    rest = byte << 24
    for _ in range(8):
        rest = (rest << 1) ^ (_POLYNOMIAL if rest & 0x80000000 else 0)
    _TABLE.append(rest & 0xFFFFFFFF)


def checksum(packed):
    """By a table of bytes, over words but the last; of each the most significant byte first."""
    crc = 0xFFFFFFFF
    for word in struct.unpack(f"<{len(packed) // 4 - 1}I", packed[:-4]):
        for byte in word.to_bytes(4, "big"):
            crc = (crc << 8 & 0xFFFFFFFF) ^ _TABLE[crc >> 24 ^ byte]
    return crc


def flat(numbers):
    """The numbers of a message in the order of its definition, from nested tuples."""
    for value in numbers:
        if isinstance(value, tuple | list):
            yield from flat(value)
        elif isinstance(value, np.ndarray):
            yield from flat(value.tolist())
        else:
            yield value


def random_record(layout, rng):
    """A message of random numbers; the numbers of floating point are finite."""
    record = layout.blank()
    fill(record, rng)
    return record


def fill(record, rng):
    """Put random numbers everywhere."""
    for name in record.dtype.names:
        field = record[name]
        if field.dtype.names:
            fill(field, rng)
        elif field.dtype.kind == "f":
            record[name] = rng.normal(scale=10.0 ** rng.integers(-3, 4), size=field.shape)
        else:
            low, high = np.iinfo(field.dtype).min, np.iinfo(field.dtype).max
            record[name] = rng.integers(low, high, field.shape, dtype=field.dtype, endpoint=True)
