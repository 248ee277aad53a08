"""Writing files and folders so that nobody ever sees half of one.

What is written stands in a hidden folder `.llsrbm-....tmp` beside its place until it is complete. A
process that is killed in between leaves that folder behind, and under the name what was there
before. A folder takes the place of another in two steps, between which the name is free for some
microseconds.
"""

from __future__ import annotations

import json
import os
import shutil
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from errno import EEXIST, ENOTEMPTY
from pathlib import Path

from llsrbm.errors import InputError

MARK = "meta.json"  # the file by which a folder of ours is known: JSON with "package_version"

_PREFIX = ".llsrbm-"  # of hidden folders
_ATTEMPTS = 20  # to take a folder's place while others do the same
_LARGEST_MARK = 10_000_000  # bytes


@contextmanager
def staged(path: str | Path) -> Iterator[Path]:
    """A path of the same name to write a file or a folder to, with others beside it if need be.

    All of them take their places when the block ends well, what the path names last; otherwise
    nothing is left. They get the permissions that any new file or folder would. A symbolic link is
    followed. What is not a regular file (a pipe, /dev/stdout) gets the bytes of the one file.

    Raises:
        InputError: the path cannot be written, or names a folder that was not written by this.
    """
    target = Path(path)
    draft = None
    if target.parent.name.startswith(_PREFIX):  # stands in a folder that is to take its place
        yield target
        return
    try:
        special = _is_special(target)
        target = target if special else _place(target)
        with tempfile.TemporaryDirectory(
            prefix=_PREFIX,  # not the target's name, which may be as long as names can be
            suffix=".tmp",
            dir=None if special else target.parent,
            ignore_cleanup_errors=True,
        ) as folder:
            draft = Path(folder) / target.name
            yield draft
            if special:
                _copy_into(target, draft)
            else:
                _take_places(Path(folder), target)
    except OSError as error:
        of_another = error.filename and draft and not str(error.filename).startswith(str(draft))
        what = f" ({error.filename})" if of_another else ""
        raise InputError(
            f"cannot write {path}: {error.strerror or error}{what}; expected a path in a directory "
            "that exists and may be written to"
        ) from error


def _is_special(target: Path) -> bool:
    """Whether bytes have to be sent there, as nothing can take its place."""
    try:
        kind = target.stat().st_mode
    except ValueError as error:  # a name that no file can have
        raise OSError(0, str(error)) from error
    except FileNotFoundError:
        return False
    # /dev/stdout may be a regular file, to which the shell goes on writing.
    device = target.absolute().is_relative_to("/dev/fd") or str(target.absolute()) in (
        "/dev/stdout",
        "/dev/stderr",
    )
    return device or not (stat.S_ISREG(kind) or stat.S_ISDIR(kind))


def _place(target: Path) -> Path:
    """Where links lead, if something may be written there."""
    target = target.resolve()
    if not target.parent.is_dir():
        raise FileNotFoundError(0, f"no such directory as {target.parent}")
    if not target.name:
        raise IsADirectoryError(0, "it is a directory")
    return target


def _copy_into(target: Path, draft: Path) -> None:
    if not draft.is_file():
        raise NotADirectoryError(0, "a folder would be written, which needs a name of its own")
    # Appended, because a redirected /dev/stdout may hold what others wrote before.
    with draft.open("rb") as written, target.open("ab") as file:
        shutil.copyfileobj(written, file)


def _take_places(folder: Path, target: Path) -> None:
    written = sorted(folder.iterdir(), key=lambda part: part.name == target.name)
    for part in written:
        _check_replaceable(target.with_name(part.name), part)
        for file in [part] if part.is_file() else [p for p in part.rglob("*") if p.is_file()]:
            with file.open("rb") as opened:
                os.fsync(opened.fileno())
    for part in written:
        if part.is_file():
            part.replace(target.with_name(part.name))
        else:
            _swap_folder(part, target.with_name(part.name))


def _check_replaceable(place: Path, part: Path) -> None:
    if part.is_dir() and place.is_file():
        raise NotADirectoryError(0, "it is a file, and a folder would be written")
    if part.is_file() and place.is_dir():
        raise IsADirectoryError(0, "it is a directory")
    if part.is_dir() and place.is_dir() and not _is_ours(place):
        raise FileExistsError(0, "it is a folder with other things in it, which would be lost")


def _is_ours(place: Path) -> bool:
    """Whether a folder is empty or was written by an export; also if it has just gone away."""
    while True:  # each further round is one in which somebody else put theirs there
        try:
            # Held open, so that no other folder can get its inode number meanwhile.
            folder = os.open(place, os.O_RDONLY | os.O_DIRECTORY)
        except FileNotFoundError:  # moved aside by somebody who is about to put theirs there
            return True
        try:
            if not os.listdir(folder) or _is_marked(folder):  # noqa: PTH208 (of an open folder)
                return True
            with suppress(FileNotFoundError):
                if place.stat().st_ino == os.fstat(folder).st_ino:
                    return False
        finally:
            os.close(folder)


def _is_marked(folder: int) -> bool:
    """Whether a folder, given by its descriptor, holds the mark of an export."""
    try:
        found = os.stat(MARK, dir_fd=folder)
        if not stat.S_ISREG(found.st_mode) or found.st_size > _LARGEST_MARK:
            return False
        with os.fdopen(os.open(MARK, os.O_RDONLY, dir_fd=folder), encoding="utf-8") as mark:
            said = json.load(mark)
    except (FileNotFoundError, ValueError, RecursionError):
        return False
    return isinstance(said, dict) and "package_version" in said


def _swap_folder(part: Path, place: Path) -> None:
    """Put a folder in the place of another, which is moved aside and removed."""
    aside = Path(tempfile.mkdtemp(dir=part.parent))
    for attempt in range(_ATTEMPTS):
        old = aside / str(attempt)
        with suppress(FileNotFoundError):
            place.replace(old)
        try:
            part.replace(place)
        except OSError as error:
            others = error.errno in (ENOTEMPTY, EEXIST)  # somebody's took the place meanwhile
            if not others and old.exists():
                old.replace(place)
            if not others or attempt == _ATTEMPTS - 1:
                raise
        else:
            return
