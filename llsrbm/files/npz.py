"""npz and zip archives from anybody: read within limits of memory and time, nothing is run.

Sizes are limited before anything is unpacked, by what an array will take as numbers of eight bytes
whatever the file stores; an array's header has to agree with the bytes behind it, pickles are
refused, and each array is checked against the `Quantity` that describes it.
"""

from __future__ import annotations

import io
import math
import os
import stat
import struct
import zipfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO, Literal

import numpy as np
from numpy.typing import NDArray

from llsrbm.errors import FileFormatError, printable
from llsrbm.files.atomic import staged
from llsrbm.files.quantity import (
    CONTACT,
    HIP,
    JOINT,
    LEG,
    POSITION,
    SIZES,
    TIME,
    VELOCITY,
    WXYZ,
    Between,
    Kind,
    Quantity,
)
from llsrbm.text_files import path_of

Arrays = dict[str, NDArray[Any]]

NATIVE = "expected an npz file that the page exported, or --out or a save() wrote"

# Far above any trajectory (1 MB for two seconds at 400 Hz), far below a machine's memory.
LARGEST = 64 * 1024**2  # bytes, of a file, unpacked, and of its arrays as they are used
_NUMBER = 8  # bytes: numbers are used as float64 or int64
_LARGEST_DIRECTORY = 1024**2  # bytes at the end of an archive: some ten thousand names
_LONGEST_COMMENT = 2**16
_LONGEST_HEADER = 1000  # bytes of an array's
_LONGEST_TEXT = 1_000_000  # characters
_LONGEST_NAME = 200  # characters, of a joint
_MOST = 1000  # legs, joints, ...
_COUNTS = {size for axis in (LEG, CONTACT, JOINT, HIP, POSITION, VELOCITY) for size in SIZES[axis]}
_UNIT_QUATERNION = 1e-3  # largest deviation of a norm from 1 that still is an attitude

LARGEST_NUMBER = 1e30
"""In any unit; its products overflow nowhere, and nothing that jumps comes near it."""

# How files begin that are opened by mistake.
_OTHERS = (
    (b"PK", "a zip archive that is cut short or damaged"),
    (b"\x93NUMPY", "a single NumPy array (.npy)"),
    (b"\x80", "a Python pickle, which is never opened: it could run anything"),
    (b"{", "a JSON file; a design is planned by `llsrbm plan --design FILE`"),
    (b"time [s]", "a table; tables cannot be read back, export from the npz file again"),
)


class Archive:
    """The members of an open zip file, by name; made by `open_archive`."""

    def __init__(self, file: BinaryIO, where: str, expected: str, largest: int) -> None:
        _check_end(file, where, expected, largest)
        self._zip, self._where, self._expected = zipfile.ZipFile(file), where, expected
        self._largest = largest
        self._members: dict[str, zipfile.ZipInfo] = {}
        size = 0
        for member in self._zip.infolist():
            name = f"{where}: {printable(member.filename)}"
            size += member.file_size
            if size > largest:
                raise FileFormatError(
                    f"{where}: {size} bytes of arrays or more; at most {largest} are read"
                )
            if member.filename in self._members:
                raise FileFormatError(f"{name}: is there twice; {expected}")
            if member.flag_bits & 1:
                raise FileFormatError(f"{name}: is encrypted; {expected}")
            if member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
                raise FileFormatError(f"{name}: is packed as NumPy packs nothing; {expected}")
            self._members[member.filename] = member

    @property
    def names(self) -> Mapping[str, object]:
        """Names of the members, to look up and to go through."""
        return self._members

    @property
    def keys(self) -> frozenset[str]:
        """Keys of the arrays."""
        return frozenset(n.removesuffix(".npy") for n in self._members if n.endswith(".npy"))

    def content(self, name: str) -> bytes:
        """The bytes of one member."""
        member = self._members[name]
        with self._zip.open(member) as opened:
            # No more than it states is unpacked: `ZipFile.read` would unpack it all.
            return opened.read(member.file_size)

    def arrays(self, only: Iterable[str] | None = None) -> Arrays:
        """The arrays, or those of the keys `only` that are there; read-only."""
        wanted = sorted(self.keys if only is None else self.keys & frozenset(only))
        result: Arrays = {}
        left = self._largest
        for key in wanted:
            member, where = self._members[f"{key}.npy"], f'{self._where}: key "{printable(key)}"'
            with self._zip.open(member) as opened:
                head = opened.read(_LONGEST_HEADER + 16)
                shape, dtype, order, begin = _header(head, member.file_size, where)
                left -= math.prod(shape) * max(dtype.itemsize, _NUMBER)
                if left < 0:
                    raise FileFormatError(
                        f"{where}: {printable(str(shape))} of {dtype} is too large; at most "
                        f"{self._largest} bytes of numbers are read in all"
                    )
                content = head + opened.read(max(member.file_size - len(head), 0))
            result[key] = np.ndarray(shape, dtype, content, begin, order=order)
        return result

    def inner(self, name: str) -> Archive:
        """An archive within this one."""
        content = self.content(name)
        where = f"{self._where}: {printable(name)}"
        return Archive(io.BytesIO(content), where, self._expected, self._largest)


@contextmanager
def open_archive(
    path: str | Path, expected: str = NATIVE, largest: int = LARGEST
) -> Iterator[Archive]:
    """Open a zip or npz file of at most `largest` bytes, also those of its members together.

    `expected`: what the file should be, for messages. Raises `FileFormatError`: unreadable, no
    archive, damaged, too large or too long a list of members; also for whatever reading its members
    raises within the block.
    """
    path = path_of(path)
    try:
        kind = path.stat().st_mode  # before it is opened: a pipe would be waited for
        if not stat.S_ISREG(kind):
            what = "it is a folder" if stat.S_ISDIR(kind) else "not a regular file"
            raise FileFormatError(f"{path}: cannot be read: {what}; {expected}")
        with path.open("rb") as file:
            yield Archive(file, str(path), expected, largest)
    except FileFormatError:
        raise
    except OSError as error:
        reason = error.strerror or str(error)
        raise FileFormatError(f"{path}: cannot be read: {reason}; {expected}") from error
    except Exception as error:  # no list names what damage raises in zipfile and zlib
        reason = printable(" ".join(str(error).split()), 120) or type(error).__name__
        where = printable(str(path), 300)
        raise FileFormatError(f"{where}: damaged or another file: {reason}; {expected}") from error


def keys(path: str | Path) -> frozenset[str]:
    """Keys of the arrays in an npz file, which are not read; none where it is no such file."""
    try:
        with open_archive(path) as archive:
            return archive.keys
    except FileFormatError:
        return frozenset()


def read_archive(
    path: str | Path,
    *,
    only: Iterable[str] | None = None,
    expected: str = NATIVE,
    largest: int = LARGEST,
) -> Arrays:
    """Arrays of an npz file, or those of the keys `only` that are there; see `open_archive`."""
    with open_archive(path, expected, largest) as archive:
        return archive.arrays(only)


def write_archive(path: str | Path, arrays: Mapping[str, Any]) -> None:
    """Write an npz file at exactly that path, atomically, without pickle; raises `InputError`."""
    with staged(path) as draft, draft.open("wb") as file:
        np.savez_compressed(file, allow_pickle=False, **arrays)


def _check_end(file: BinaryIO, where: str, expected: str, largest: int) -> None:
    """Refuse what is no zip archive, and directories so long that listing them takes minutes."""
    size = file.seek(0, os.SEEK_END)
    if size > largest:
        raise FileFormatError(f"{where}: {size} bytes; at most {largest} are read")
    file.seek(0)
    head = file.read(8)
    file.seek(max(0, size - _LONGEST_COMMENT - 22))
    tail = file.read()
    end = tail.rfind(b"PK\5\6")  # as zipfile looks for it
    if not head.startswith(b"PK") or end < 0 or end + 22 > len(tail):
        others = (text for begin, text in _OTHERS if head.startswith(begin))
        seems = next(others, "an empty file" if not head else "one of an unknown kind")
        raise FileFormatError(f"{where}: not an npz file but {seems}; {expected}")
    count, directory = struct.unpack("<HL", tail[end + 10 : end + 16])
    if (
        directory > _LARGEST_DIRECTORY
        or count == 0xFFFF
        or b"PK\6\7" in tail[max(0, end - 20) : end]
    ):
        raise FileFormatError(f"{where}: an archive of too many files; {expected}")


def _header(
    head: bytes, size: int, where: str
) -> tuple[tuple[int, ...], np.dtype[Any], Literal["C", "F"], int]:
    """Shape, type, order and first byte of the array in a .npy file of `size` bytes.

    `head`: its beginning. The header has to agree with the bytes behind it.
    """
    stream = io.BytesIO(head)
    try:
        version = np.lib.format.read_magic(stream)
        if version == (1, 0):
            read = np.lib.format.read_array_header_1_0(stream, max_header_size=_LONGEST_HEADER)
        else:
            read = np.lib.format.read_array_header_2_0(stream, max_header_size=_LONGEST_HEADER)
    except Exception as error:  # Python's parser raises anything, `MemoryError` among it
        raise FileFormatError(f"{where}: damaged: expected a NumPy array") from error
    shape, in_columns, dtype = read
    if dtype.hasobject:
        raise FileFormatError(
            f"{where}: a pickle of Python objects, which is never opened; expected plain numbers "
            "or text"
        )
    if dtype.kind not in "biufcSU":
        raise FileFormatError(f"{where}: expected plain numbers or text, got {dtype!s:.60}")
    begin = stream.tell()
    there = size - begin
    entries = math.prod(max(1, n) for n in shape)  # an axis of no length hides the others
    fits = math.prod(shape) * dtype.itemsize == there and entries <= 2 * LARGEST
    if not fits or len(shape) > 8 or min(shape, default=0) < 0 or (not dtype.itemsize and shape):
        raise FileFormatError(
            f"{where}: damaged: {there} bytes, expected {printable(str(shape))} of {dtype}"
        )
    return shape, dtype, "F" if in_columns else "C", begin


def text(arrays: Arrays, key: str, path: str | Path) -> str:
    """The scalar text at `key`; raises `FileFormatError`."""
    value = _entry(arrays, key, path)
    if value.shape != () or value.dtype.kind != "U":
        raise FileFormatError(f'{path}: key "{key}": expected one text, got {_shape_of(value)}')
    return _texts(value, _LONGEST_TEXT, f'{path}: key "{key}"')[0]


def checked(
    arrays: Arrays, layout: Mapping[str, Quantity], path: str | Path, most_times: int | None = None
) -> Arrays:
    """The arrays named in `layout`, as float64, int64 or text; other keys are left out.

    `most_times`: the largest number of instants, counted before anything is converted. Raises
    `FileFormatError`: a key is missing, has another shape or kind, or numbers that are not finite
    or beyond anything that moves, attitudes that are no unit quaternions, unknown codes.
    """
    sizes: dict[str, tuple[int, str]] = {}
    result: Arrays = {}
    for key, quantity in layout.items():
        value = _entry(arrays, key, path)
        where = f'{path}: key "{key}"'
        _check_shape(value, quantity, key, sizes, where)
        times = value.shape[0] if quantity.axes[:1] == (TIME,) else 0
        if most_times is not None and times > most_times:
            raise FileFormatError(f"{where}: expected 2 to {most_times} frames, got {times}")
        result[key] = _of_kind(value, quantity, where)
        _check_values(result[key], quantity, where)
    return result


def _of_kind(value: NDArray[Any], quantity: Quantity, where: str) -> NDArray[Any]:
    if quantity.kind is Kind.TEXT:
        if value.dtype.kind != "U":
            raise FileFormatError(f"{where}: expected text, got {value.dtype}")
        names = _texts(value, _LONGEST_NAME, where)
        if len(set(names)) < len(names) or not all(n and n.isprintable() for n in names):
            raise FileFormatError(f"{where}: expected names, each of them once")
        return np.array(names)
    whole = quantity.kind is Kind.WHOLE
    if value.dtype.kind not in ("iu" if whole else "fiu"):
        wanted = "integers" if whole else "real numbers"
        raise FileFormatError(f"{where}: expected {wanted}, got {value.dtype}")
    with np.errstate(invalid="ignore"):  # of signalling NaNs
        numbers = value.astype(np.int64 if whole else np.float64)
    usable = np.abs(numbers) <= LARGEST_NUMBER  # NaN is not
    if not usable.all():
        first = tuple(int(i) for i in np.argwhere(~usable)[0])
        wanted = f"at most {LARGEST_NUMBER:g}" if np.isfinite(numbers[first]) else "finite numbers"
        raise FileFormatError(f"{where}: expected {wanted}, got {value[first]} at {first}")
    return numbers


def _check_values(numbers: NDArray[Any], quantity: Quantity, where: str) -> None:
    if quantity.axes[-1:] == (WXYZ,):
        check_attitudes(numbers, where)
    if quantity.between is Between.POSE:
        check_attitudes(numbers[:, 3:7], where)
    if quantity.codes and not np.isin(numbers, range(len(quantity.codes))).all():
        meanings = (f"{number} ({meaning})" for number, meaning in enumerate(quantity.codes))
        raise FileFormatError(f"{where}: expected {', '.join(meanings)}")


def check_attitudes(quat: Any, where: str) -> None:
    """Raise `FileFormatError` unless (..., 4) are unit quaternions."""
    if (np.abs(np.linalg.norm(quat, axis=-1) - 1) > _UNIT_QUATERNION).any():
        raise FileFormatError(f"{where}: expected unit quaternions w, x, y, z")


def _texts(value: NDArray[Any], longest: int, where: str) -> list[str]:
    """The entries of an array of text, which may hold numbers that are no letters."""
    letters = value.dtype.itemsize // 4
    if letters > longest:
        raise FileFormatError(f"{where}: texts of {letters} letters; at most {longest} are read")
    raw = value.astype(value.dtype.newbyteorder("<")).tobytes()
    size = value.dtype.itemsize
    try:
        return [
            raw[entry * size : (entry + 1) * size].decode("utf-32-le").rstrip("\0")
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
    value: NDArray[Any], quantity: Quantity, key: str, sizes: dict[str, tuple[int, str]], where: str
) -> None:
    wanted = ", ".join(str(size) for size in quantity.shape)
    fits = value.ndim == len(quantity.shape)
    for got, size in zip(value.shape, quantity.shape, strict=False):
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
    count = max((n for n, size in zip(value.shape, quantity.shape) if size in _COUNTS), default=1)
    if not value.size or count > _MOST:
        raise FileFormatError(
            f"{where}: expected shape ({wanted}) with at least 1 of each, and at most {_MOST} of "
            f"all but times, got {_shape_of(value)}"
        )


def _shape_of(value: NDArray[Any]) -> str:
    return f"({', '.join(str(size) for size in value.shape)}) of {value.dtype}"
