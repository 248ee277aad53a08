"""npz archives: reading what a stranger wrote, and checking it against the table of quantities."""

from __future__ import annotations

import os
import stat
import struct
import zipfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from llsrbm.errors import FileFormatError, printable
from llsrbm.files.mistaken import LOOKED_AT, NATIVE, seems
from llsrbm.files.npy import array_of
from llsrbm.files.writing import staged
from llsrbm.motion.quantity import (
    CONTACT,
    HIP,
    JOINT,
    LEG,
    POSITION,
    SIZES,
    VELOCITY,
    Kind,
    Quantity,
)

Arrays = dict[str, NDArray[Any]]

# Far above any trajectory (1 MB for two seconds at 400 Hz), far below a machine's memory.
LARGEST = 256 * 1024**2  # bytes, of the file and unpacked
_LARGEST_DIRECTORY = 64 * 1024  # bytes, at the end of an archive; a native file's has 2 kB
_LONGEST_TEXT = 1_000_000  # characters
_LONGEST_NAME = 200  # characters, of a joint
_MOST = 1000  # legs, joints, ...
_COUNTS = {size for axis in (LEG, CONTACT, JOINT, HIP, POSITION, VELOCITY) for size in SIZES[axis]}

LARGEST_NUMBER = 1e30
"""In any unit; its products overflow nowhere, and nothing that jumps comes near it."""


def keys(path: str | Path) -> frozenset[str]:
    """Of the arrays in an npz file, without reading them; none where it is no such file."""
    try:
        with Path(path).open("rb") as file:
            _check_end(file, path, LARGEST, NATIVE)
            with refusing_damage(path, NATIVE), zipfile.ZipFile(file) as archive:
                names = archive.namelist()
    except (OSError, ValueError, FileFormatError):
        return frozenset()
    return frozenset(name.removesuffix(".npy") for name in names)


def read_archive(
    path: str | Path,
    *,
    only: Iterable[str] | None = None,
    expected: str = NATIVE,
    largest: int = LARGEST,
) -> Arrays:
    """Arrays of an npz file; pickled objects are refused, not run.

    Args:
        path: of the file.
        only: keys that are read if they are there; None: all.
        expected: what the file should be, for messages.
        largest: bytes, of the file and of the arrays together.

    Raises:
        FileFormatError: unreadable, not npz, damaged, too large or holding pickled objects.
    """
    try:
        # Before it is opened: a pipe would be waited for.
        kind = Path(path).stat().st_mode
        if stat.S_ISDIR(kind):
            raise FileFormatError(f"{path}: cannot be read: it is a folder; {expected}")
        if not stat.S_ISREG(kind):
            raise FileFormatError(f"{path}: cannot be read: not a regular file; {expected}")
        with Path(path).open("rb") as file:
            return read_open_archive(file, path, only=only, expected=expected, largest=largest)
    except OSError as error:
        reason = error.strerror or str(error)
        raise FileFormatError(f"{path}: cannot be read: {reason}; {expected}") from error
    except ValueError as error:  # a path that no file can have
        raise FileFormatError(f"{path!r}: cannot be read: {error}; {expected}") from error


def read_open_archive(
    file: BinaryIO,
    path: str | Path,
    *,
    only: Iterable[str] | None = None,
    expected: str = NATIVE,
    largest: int = LARGEST,
) -> Arrays:
    """The same of an open file; `path` is for messages."""
    _check_end(file, path, largest, expected)
    wanted = None if only is None else frozenset(only)
    members = _members(file, path, wanted, largest, expected)
    return {
        key: array_of(content, f'{path}: key "{printable(key)}"')
        for key, content in members.items()
    }


@contextmanager
def refusing_damage(path: str | Path, expected: str) -> Iterator[None]:
    """What reading a damaged archive raises, as `FileFormatError`."""
    try:
        yield
    except (FileFormatError, OSError):
        raise
    except Exception as error:  # no list says what damage raises in zipfile and zlib
        reason = printable(" ".join(str(error).split()), 120) or type(error).__name__
        raise FileFormatError(f"{path}: damaged or another file: {reason}; {expected}") from error


def _check_end(file: BinaryIO, path: str | Path, largest: int, expected: str) -> None:
    """Refuse what is no zip archive, and directories so long that listing them would take all day.

    At the end of an archive that NumPy wrote stands where its directory is, without a comment.
    """
    size = file.seek(0, os.SEEK_END)
    if size > largest:
        raise FileFormatError(f"{path}: {size} bytes; at most {largest} are read")
    file.seek(max(0, size - 42))
    end = file.read().rjust(42, b"\0")
    file.seek(0)
    head = file.read(LOOKED_AT)
    if not head.startswith(b"PK") or end[20:24] != b"PK\5\6" or end[40:] != b"\0\0":
        raise FileFormatError(f"{path}: not an npz file, it seems to be {seems(head)}; {expected}")
    (directory,) = struct.unpack("<L", end[32:36])
    if directory > _LARGEST_DIRECTORY or end.startswith(b"PK\6\7"):  # 64 bits: larger still
        raise FileFormatError(f"{path}: an archive of too many files; {expected}")


def _members(
    file: BinaryIO, path: str | Path, only: frozenset[str] | None, largest: int, expected: str
) -> dict[str, bytes]:
    """Name -> content of every .npy file in an archive; nothing is unpacked to disk."""
    contents = {}
    with refusing_damage(path, expected), zipfile.ZipFile(file) as archive:
        arrays = {
            member.filename.removesuffix(".npy"): member
            for member in _checked_members(archive.infolist(), path, largest, expected)
        }
        for key, member in arrays.items():
            if only is None or key in only:
                with archive.open(member) as opened:
                    # No more than it says is unpacked: `archive.read` would unpack it all.
                    contents[key] = opened.read(member.file_size)
    return contents


def _checked_members(
    listed: list[zipfile.ZipInfo], path: str | Path, largest: int, expected: str
) -> list[zipfile.ZipInfo]:
    """Those that are arrays."""
    size = sum(member.file_size for member in listed)
    if size > largest:
        raise FileFormatError(f"{path}: {size} bytes of arrays; at most {largest} are read")
    names = [member.filename for member in listed]
    for member in listed:
        where = f"{path}: {printable(member.filename)}"
        if names.count(member.filename) > 1:
            raise FileFormatError(f"{where}: is there twice; {expected}")
        if member.flag_bits & 1:
            raise FileFormatError(f"{where}: is encrypted; {expected}")
        if member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            raise FileFormatError(f"{where}: is packed as NumPy packs nothing; {expected}")
    return [member for member in listed if member.filename.endswith(".npy")]


def write_archive(path: str | Path, arrays: Mapping[str, Any]) -> None:
    """Write an npz file at exactly that path, atomically and without pickle.

    Raises:
        InputError: the file cannot be written.
    """
    with staged(path) as draft, draft.open("wb") as file:
        np.savez_compressed(file, allow_pickle=False, **arrays)


def text(arrays: Arrays, key: str, path: str | Path) -> str:
    """The scalar text at `key`.

    Raises:
        FileFormatError: missing, or something else.
    """
    value = _entry(arrays, key, path)
    if value.shape != () or value.dtype.kind != "U":
        raise FileFormatError(f'{path}: key "{key}": expected one text, got {_shape_of(value)}')
    return _texts(value, _LONGEST_TEXT, f'{path}: key "{key}"')[0]


def checked(arrays: Arrays, layout: Mapping[str, Quantity], path: str | Path) -> Arrays:
    """The arrays named in `layout`, as float64, int64 or text; other keys are left out.

    Raises:
        FileFormatError: a key is missing, has another shape or kind, or numbers that are not finite
            or beyond anything that moves.
    """
    sizes: dict[str, tuple[int, str]] = {}
    result: Arrays = {}
    for key, entry in layout.items():
        value = _entry(arrays, key, path)
        where = f'{path}: key "{key}"'
        _check_shape(value, entry, key, sizes, where)
        result[key] = _of_kind(value, entry, where)
    return result


def _of_kind(value: NDArray[Any], entry: Quantity, where: str) -> NDArray[Any]:
    if entry.kind is Kind.TEXT:
        if value.dtype.kind != "U":
            raise FileFormatError(f"{where}: expected text, got {value.dtype}")
        names = _texts(value, _LONGEST_NAME, where)
        if len(set(names)) < len(names) or not all(n and n.isprintable() for n in names):
            raise FileFormatError(f"{where}: expected names, each of them once")
        return np.array(names)
    if value.dtype.kind not in ("iu" if entry.kind is Kind.WHOLE else "fiu"):
        wanted = "integers" if entry.kind is Kind.WHOLE else "real numbers"
        raise FileFormatError(f"{where}: expected {wanted}, got {value.dtype}")
    with np.errstate(invalid="ignore"):  # of signalling NaNs
        numbers = value.astype(np.int64 if entry.kind is Kind.WHOLE else np.float64)
    usable = np.isfinite(numbers) & (np.abs(numbers) <= LARGEST_NUMBER)
    if not usable.all():
        first = tuple(int(i) for i in np.argwhere(~usable)[0])
        wanted = (
            "finite numbers" if not np.isfinite(numbers[first]) else f"at most {LARGEST_NUMBER:g}"
        )
        raise FileFormatError(f"{where}: expected {wanted}, got {value[first]} at {first}")
    return numbers


def _texts(value: NDArray[Any], longest: int, where: str) -> list[str]:
    """The entries of an array of text, which may hold numbers that are no letters."""
    letters = value.dtype.itemsize // 4
    if letters > longest:
        raise FileFormatError(f"{where}: texts of {letters} letters; at most {longest} are read")
    codec = "utf-32-le" if value.dtype.newbyteorder("<") == value.dtype else "utf-32-be"
    raw, size = value.tobytes(), value.dtype.itemsize
    try:
        return [
            raw[entry * size : (entry + 1) * size].decode(codec).rstrip("\0")
            for entry in range(value.size)
        ]
    except UnicodeDecodeError as error:
        raise FileFormatError(f"{where}: holds what is no text") from error


def _entry(arrays: Arrays, key: str, path: str | Path) -> NDArray[Any]:
    if key not in arrays:
        held = printable(", ".join(sorted(arrays)), 400) or "none"
        raise FileFormatError(f'{path}: key "{key}" is missing; the file holds {held}; {NATIVE}')
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
    count = max((n for n, size in zip(value.shape, entry.shape) if size in _COUNTS), default=1)
    if not value.size or count > _MOST:
        raise FileFormatError(
            f"{where}: expected shape ({wanted}) with at least 1 of each, and at most {_MOST} of "
            f"all but times, got {_shape_of(value)}"
        )


def _shape_of(value: NDArray[Any]) -> str:
    return f"({', '.join(str(size) for size in value.shape)}) of {value.dtype}"
