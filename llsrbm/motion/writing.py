"""Writing files and folders so that nobody ever sees half of one."""

from __future__ import annotations

import os
import secrets
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from llsrbm.errors import InputError


@contextmanager
def replacing(path: str | Path) -> Iterator[BinaryIO]:
    """Open a file to write; it takes the place of `path` only when the block ends well.

    A symbolic link is followed. What is not a regular file (a pipe, /dev/stdout) is written to
    directly. The new file gets the permissions that any new file would.

    Raises:
        InputError: the file cannot be written.
    """
    target = Path(path)
    try:
        target = target.resolve()
        if target.exists() and not target.is_file() and not target.is_dir():
            with target.open("wb") as file:
                yield file
            return
        if target.is_dir():
            raise IsADirectoryError(0, "it is a directory")
        temporary = target.with_name(f".{target.name}.{secrets.token_hex(6)}.tmp")
        try:
            with temporary.open("xb") as file:
                yield file
                file.flush()
                os.fsync(file.fileno())
            temporary.replace(target)
        except BaseException:
            temporary.unlink(missing_ok=True)
            raise
    except OSError as error:
        raise InputError(
            f"cannot write {path}: {error.strerror or error}; expected the path of a file in a "
            "directory that exists and may be written to"
        ) from error


@contextmanager
def staged(path: str | Path) -> Iterator[Path]:
    """A path of the same name to write a file or a folder to, with others beside it if need be.

    All of them take their places when the block ends well, what the path names last; otherwise
    nothing is left. A symbolic link is followed. What is not a regular file (a pipe, /dev/stdout)
    gets the bytes of the one file.

    Raises:
        InputError: the path cannot be written, or names a folder that was not written by this.
    """
    target = Path(path)
    try:
        target = target.resolve()
        special = target.exists() and not target.is_file() and not target.is_dir()
        if not special and not target.parent.is_dir():
            raise FileNotFoundError(0, "its folder does not exist")
        beside = None if special else target.parent
        with tempfile.TemporaryDirectory(
            prefix=f".{target.name}.", suffix=".tmp", dir=beside
        ) as folder:
            draft = Path(folder) / target.name
            yield draft
            if special:
                with target.open("wb") as file:
                    file.write(draft.read_bytes())
                return
            written = sorted(Path(folder).iterdir(), key=lambda part: part == draft)
            for part in written:
                _check_replaceable(target.with_name(part.name), part)
            for part in written:
                _take_place(part, target.with_name(part.name))
    except OSError as error:
        raise InputError(
            f"cannot write {path}: {error.strerror or error}; expected a path in a directory that "
            "exists and may be written to"
        ) from error


MARK = "meta.json"  # the file by which a folder of ours is known


def _check_replaceable(place: Path, part: Path) -> None:
    if part.is_dir() and place.is_file():
        raise NotADirectoryError(0, "it is a file, and a folder would be written")
    if part.is_file() and place.is_dir():
        raise IsADirectoryError(0, "it is a directory")
    ours = place.is_dir() and ((place / MARK).is_file() or not any(place.iterdir()))
    if part.is_dir() and place.exists() and not ours:
        raise FileExistsError(0, "it is a folder with other things in it, which would be lost")


def _take_place(part: Path, place: Path) -> None:
    if part.is_file():
        with part.open("rb") as file:
            os.fsync(file.fileno())
        part.replace(place)
        return
    if place.is_dir():
        old = part.with_name(f"{part.name}.old")
        place.replace(old)
        try:
            part.replace(place)
        except OSError:
            old.replace(place)
            raise
        shutil.rmtree(old)
    else:
        part.replace(place)
