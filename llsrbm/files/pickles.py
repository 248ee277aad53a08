"""Pickles from anybody: numbers, text, lists, dictionaries and arrays of them; nothing is run.

What a pickle names is not looked up. A few names that arrays are made of stand for classes of this
module, which take what NumPy would take and make an array of plain numbers of it; any other name is
refused. Files of joblib, which have the bytes of arrays between the pickle's own, are read as well.
"""

import io
import math
import pickle
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, ClassVar, cast

import numpy as np
from numpy.typing import NDArray

from llsrbm.errors import FileFormatError, printable

LARGEST = 64 * 1024**2  # bytes, of a file and of what is packed in it
_DEEPEST = 20  # lists in lists
_MOST = 5_000_000  # numbers, texts and lists in all: a pickle may name the same one many times
_KINDS = "fiub"  # of numbers: float, signed and unsigned, bool
_ZLIB, _GZIP = b"\x78", b"\x1f\x8b"


class _Refused(Exception):
    """Raised where a pickle holds what is not read; says what."""


class _Numbers:
    """An element's type as NumPy pickles it: a code, and the order of its bytes by the state."""

    def __init__(self, code: Any, *_: Any) -> None:
        self.type = np.dtype(str(code)[:10]).newbyteorder("<")
        if self.type.kind not in _KINDS:
            raise _Refused(f"an array of {printable(str(code), 20)}")

    def __setstate__(self, state: Any) -> None:
        if state[1] == ">":
            self.type = self.type.newbyteorder(">")

    def array(self, raw: Any, shape: Any, *, by_column: bool) -> NDArray[Any]:
        """The array of these bytes; raises `ValueError`: the shape takes more of them, or fewer."""
        values = np.frombuffer(raw, self.type).reshape(shape, order="F" if by_column else "C")
        return values.astype(self.type.newbyteorder("="))


class _Array:
    """An array as NumPy pickles it: made empty, and filled by its state."""

    value: NDArray[Any] | None = None

    def __init__(self, *_: Any) -> None:
        pass

    def __setstate__(self, state: Any) -> None:
        _, shape, numbers, by_column, raw = state
        self.value = cast("_Numbers", numbers).array(raw, shape, by_column=bool(by_column))


class _JoblibArray:
    """An array as joblib pickles it: its bytes follow in the file."""

    shape: tuple[int, ...] = ()
    order = "C"
    dtype: _Numbers
    numpy_array_alignment_bytes: int | None = None

    def read(self, file: io.BytesIO) -> NDArray[Any]:
        """The array, from where the file is."""
        if self.numpy_array_alignment_bytes is not None:
            file.seek(file.read(1)[0], io.SEEK_CUR)
        raw = file.read(math.prod(self.shape) * self.dtype.type.itemsize)
        return self.dtype.array(raw, self.shape, by_column=self.order == "F")


def _scalar(numbers: _Numbers, raw: Any) -> Any:
    return numbers.array(raw, (), by_column=False).item()


def _from_list(values: Any) -> NDArray[Any]:
    found = np.array(_Counter().plain(values))
    if found.dtype.kind not in _KINDS:
        raise _Refused("an array of no numbers")
    return found


def _from_buffer(raw: Any, numbers: _Numbers, shape: Any, order: str) -> NDArray[Any]:
    return numbers.array(raw, shape, by_column=order == "F")


def _encoded(text: str, _encoding: str) -> bytes:
    return text.encode("latin1")  # as Python 2's bytes are


def _no_bytes() -> bytes:
    return b""


_NAMES: dict[str, Callable[..., Any]] = {
    "numpy.dtype": _Numbers,
    "numpy.ndarray": _Array,
    "numpy.array": _from_list,
    "collections.OrderedDict": dict,
    "_codecs.encode": _encoded,
    "builtins.bytes": _no_bytes,
    "__builtin__.bytes": _no_bytes,
    "joblib.numpy_pickle.NumpyArrayWrapper": _JoblibArray,
    **{
        f"numpy.{core}.{name}": found
        for core in ("core", "_core")
        for name, found in (
            ("multiarray._reconstruct", _Array),
            ("multiarray.scalar", _scalar),
            ("numeric._frombuffer", _from_buffer),
        )
    },
}


_InPython: Any = vars(pickle)["_Unpickler"]  # that in C has no methods of its instructions


class _Unpickler(_InPython):
    dispatch: ClassVar[dict[int, Any]] = dict(_InPython.dispatch)

    def __init__(self, file: io.BytesIO) -> None:
        super().__init__(file, encoding="latin1")
        self._source = file

    def find_class(self, module: str, name: str) -> Any:
        """The stand-in for a name; raises `_Refused`: nothing does."""
        found = _NAMES.get(f"{module}.{name}")
        if found is None:
            raise _Refused(f'"{printable(f"{module}.{name}", 80)}"')
        return found

    def load_build(self) -> None:
        """As of the class before, of arrays alone; one of joblib's is read from behind it."""
        if not isinstance(self.stack[-2], _Numbers | _Array | _JoblibArray):
            raise _Refused("the state of something else than an array")
        super().load_build()
        if isinstance(self.stack[-1], _JoblibArray):
            self.stack[-1] = self.stack[-1].read(self._source)

    dispatch[pickle.BUILD[0]] = load_build


def read_pickle(path: Path) -> Any:
    """The content of a pickle: dictionaries, lists, text, numbers and arrays of numbers.

    Raises `FileFormatError`: it is too large, damaged, or holds anything else.
    """
    what = "expected a pickle of numbers, text, lists, dictionaries and arrays of numbers"
    try:
        return _Counter().plain(_Unpickler(io.BytesIO(_unpacked(path))).load())
    except OSError as error:
        raise FileFormatError(f"{path}: cannot be read: {error.strerror}; {what}") from error
    except _Refused as error:
        raise FileFormatError(f"{path}: holds {error}; {what}") from error
    except Exception as error:  # a pickle's instructions fail in any way
        raise FileFormatError(f"{path}: damaged, or no pickle; {what}") from error


def _unpacked(path: Path) -> bytes:
    with path.open("rb") as file:
        data = file.read(LARGEST + 1)
    if data[:1] == _ZLIB or data[:2] == _GZIP:
        data = zlib.decompressobj(wbits=47).decompress(data, LARGEST + 1)
    if len(data) > LARGEST:
        raise _Refused(f"more than {LARGEST // 1024**2} MB")
    return data


class _Counter:
    """Counts what is taken out of a pickle."""

    def __init__(self) -> None:
        self.left = _MOST

    def plain(self, value: Any, depth: int = 0) -> Any:
        """A value without this module's classes. Raises `_Refused`: it is too large, or none."""
        self.left -= 1
        if depth > _DEEPEST or self.left < 0:
            raise _Refused("too many lists in each other, or beside each other")
        if isinstance(value, _Array):
            if value.value is None:
                raise _Refused("an array without numbers")
            return value.value
        if isinstance(value, dict):
            return {str(key): self.plain(each, depth + 1) for key, each in value.items()}
        if isinstance(value, list | tuple):
            return [self.plain(each, depth + 1) for each in value]
        if value is None or isinstance(value, str | bytes | bool | int | float | np.ndarray):
            return value
        raise _Refused(f"a {type(value).__name__}")
