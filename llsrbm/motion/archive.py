"""npz archives: reading what a stranger wrote, and checking it against the table of quantities."""

from __future__ import annotations

import lzma
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from llsrbm.errors import FileFormatError
from llsrbm.motion.quantity import Kind, Quantity
from llsrbm.motion.writing import replacing

Arrays = dict[str, NDArray[Any]]

LARGEST = 2 * 1024**3  # bytes, unpacked: far above any trajectory, far below a machine's memory

# What zipfile, zlib and NumPy raise on damaged input, as far as fuzzing has shown.
_DAMAGE = (
    ValueError,  # not npz, object arrays (pickle), wrong header
    EOFError,
    KeyError,
    TypeError,
    OverflowError,
    MemoryError,
    NotImplementedError,  # a compression method that is not there
    RuntimeError,  # an encrypted member
    SyntaxError,
    zipfile.BadZipFile,
    zlib.error,
    lzma.LZMAError,
)


def read_archive(path: str | Path, largest: int = LARGEST) -> Arrays:
    """Every array of an npz file; pickled objects are refused, not run.

    Args:
        path: of the file.
        largest: bytes of arrays, unpacked; a file that has more is refused unread.

    Raises:
        FileFormatError: unreadable, not npz, damaged, too large or holding pickled objects.
    """
    expected = "expected an npz file written by llsrbm"
    try:
        with Path(path).open("rb") as file:
            if not zipfile.is_zipfile(file):
                raise FileFormatError(f"{path}: not an npz file, or cut short; {expected}")
            file.seek(0)
            with zipfile.ZipFile(file) as members:
                size = sum(member.file_size for member in members.infolist())
            if size > largest:
                raise FileFormatError(f"{path}: {size} bytes of arrays; at most {largest} are read")
            file.seek(0)
            with np.load(file, allow_pickle=False) as archive:
                return {key: np.asarray(archive[key]) for key in archive.files}
    except OSError as error:
        reason = error.strerror or str(error)
        raise FileFormatError(f"{path}: cannot be read: {reason}; {expected}") from error
    except _DAMAGE as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise FileFormatError(f"{path}: damaged or not llsrbm's: {reason}; {expected}") from error


def write_archive(path: str | Path, arrays: Mapping[str, Any]) -> None:
    """Write an npz file at exactly that path, atomically and without pickle.

    Raises:
        InputError: the file cannot be written.
    """
    with replacing(path) as file:
        np.savez_compressed(file, allow_pickle=False, **arrays)


def text(arrays: Arrays, key: str, path: str | Path) -> str:
    """The scalar text at `key`.

    Raises:
        FileFormatError: missing, or something else.
    """
    value = _entry(arrays, key, path)
    if value.shape != () or value.dtype.kind != "U":
        raise FileFormatError(f'{path}: key "{key}": expected one text, got {_shape_of(value)}')
    return str(value[()])


def checked(arrays: Arrays, layout: Mapping[str, Quantity], path: str | Path) -> Arrays:
    """The arrays named in `layout`, as float64, int64 or text; other keys are left out.

    Raises:
        FileFormatError: a key is missing, has another shape or kind, or is not finite.
    """
    sizes: dict[str, tuple[int, str]] = {}
    result: Arrays = {}
    for key, entry in layout.items():
        value = _entry(arrays, key, path)
        where = f'{path}: key "{key}"'
        _check_shape(value, entry, key, sizes, where)
        if entry.kind is Kind.TEXT:
            if value.dtype.kind != "U":
                raise FileFormatError(f"{where}: expected text, got {value.dtype}")
            result[key] = value
            continue
        if value.dtype.kind not in ("iu" if entry.kind is Kind.WHOLE else "fiu"):
            wanted = "integers" if entry.kind is Kind.WHOLE else "real numbers"
            raise FileFormatError(f"{where}: expected {wanted}, got {value.dtype}")
        result[key] = value.astype(np.int64 if entry.kind is Kind.WHOLE else np.float64)
        if not np.isfinite(result[key]).all():
            first = tuple(int(i) for i in np.argwhere(~np.isfinite(result[key]))[0])
            raise FileFormatError(
                f"{where}: expected finite numbers, got {value[first]} at {first}"
            )
    return result


def _entry(arrays: Arrays, key: str, path: str | Path) -> NDArray[Any]:
    if key not in arrays:
        held = ", ".join(sorted(arrays)) or "none"
        raise FileFormatError(f'{path}: key "{key}" is missing; the file holds {held}')
    return arrays[key]


def _check_shape(
    value: NDArray[Any], entry: Quantity, key: str, sizes: dict[str, tuple[int, str]], where: str
) -> None:
    wanted = ", ".join(str(size) for size in entry.shape)
    fits = value.ndim == len(entry.shape)
    for got, size in zip(value.shape, entry.shape, strict=False):
        if isinstance(size, int):
            fits = fits and got == size
            continue
        known, source = sizes.setdefault(size, (got, key)) if fits else sizes.get(size, (got, key))
        if known != got:
            raise FileFormatError(
                f'{where}: expected shape ({wanted}) with {size} = {known} as in "{source}", '
                f"got {_shape_of(value)}"
            )
    if not fits:
        raise FileFormatError(f"{where}: expected shape ({wanted}), got {_shape_of(value)}")


def _shape_of(value: NDArray[Any]) -> str:
    return f"({', '.join(str(size) for size in value.shape)}) of {value.dtype}"
