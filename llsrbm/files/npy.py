"""One array of an npz archive from its bytes: nothing is evaluated, nothing claimed is believed.

NumPy's own reader parses an array's header as a Python expression and allocates what it asks for.
Files come from strangers, so here a header has to be exactly what NumPy writes for plain numbers
and text, and the sizes that it states have to be those of the bytes behind it.
"""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from llsrbm.errors import FileFormatError, printable

_MAGIC = b"\x93NUMPY"
_LENGTH_BYTES = {b"\x01\x00": 2, b"\x02\x00": 4, b"\x03\x00": 4}  # version -> of the header's size
_LONGEST_HEADER = 1000
_HEADER = re.compile(
    rb"\{'descr': '([<>|=]?)([a-zA-Z])(\d{0,9})', 'fortran_order': (True|False), "
    rb"'shape': \(((?:\d{1,12}, )*\d{1,12},?)?\), \} *\n"
)
_ITEM_BYTES = {"b": (1,), "i": (1, 2, 4, 8), "u": (1, 2, 4, 8), "f": (2, 4, 8), "c": (8, 16)}
_LARGEST = 2**40  # bytes and entries; an axis of length 0 hides the others from the file's size


def array_of(content: bytes, where: str) -> NDArray[Any]:
    """The array in the content of a .npy file, read-only and without a copy.

    Raises:
        FileFormatError: no array of plain numbers or text, or not as large as it says; `where` says
            of which file.
    """
    shape, dtype, order, offset = _described(content, where)
    size = math.prod(shape) * dtype.itemsize
    if size != len(content) - offset:
        raise FileFormatError(
            f"{where}: damaged: {len(content) - offset} bytes, expected {size} for "
            f"{printable(str(shape))} of {dtype}"
        )
    return np.ndarray(shape, dtype, buffer=content, offset=offset, order=order)


def _described(content: bytes, where: str) -> tuple[tuple[int, ...], np.dtype[Any], Any, int]:
    """Shape, type, order ("C" or "F") and where the numbers begin."""
    length_bytes = _LENGTH_BYTES.get(content[6:8])
    if not content.startswith(_MAGIC) or length_bytes is None:
        raise FileFormatError(f"{where}: damaged: expected a NumPy array")
    start = 8 + length_bytes
    end = start + int.from_bytes(content[8:start], "little")
    header = content[start:end] if end - start <= _LONGEST_HEADER else b""
    found = _HEADER.fullmatch(header)
    kind = found[2].decode() if found else ""
    if kind == "O":
        raise FileFormatError(
            f"{where}: a pickle of Python objects, which is never opened; expected plain numbers "
            "or text"
        )
    if found is None or kind not in (*_ITEM_BYTES, "S", "U"):
        raise FileFormatError(
            f"{where}: expected a NumPy array of plain numbers or text, got one described as "
            f"{printable(header.decode('latin-1')) or 'something longer'}"
        )
    letters = int(found[3] or 0)
    shape = tuple(int(size) for size in (found[5] or b"").replace(b",", b" ").split())
    known = letters <= len(content) if kind in "SU" else letters in _ITEM_BYTES[kind]
    if not known or len(shape) > 8 or math.prod(max(1, n) for n in shape) > _LARGEST:
        raise FileFormatError(f"{where}: damaged: an array of {kind}{letters} with axes {shape}")
    dtype = np.dtype(f"{found[1].decode()}{kind}{letters}")
    if dtype.itemsize == 0 and shape:
        raise FileFormatError(f"{where}: damaged: entries of no size")
    return shape, dtype, "F" if found[4] == b"True" else "C", end
