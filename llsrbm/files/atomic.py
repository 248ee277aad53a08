"""Writing files and folders so that nobody ever sees half of one.

A file or folder that is being written stands in a hidden folder `.llsrbm-....tmp` beside its place
until it is complete. A process that is killed in between leaves that folder behind, and under the
name the file that was there before. A folder takes the place of another in two steps, between which
the name is free for some microseconds.
"""

import json
import os
import shutil
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from llsrbm.errors import InputError
from llsrbm.text_files import path_of

MARK = "meta.json"  # the file by which a folder of ours is known: JSON with "package_version"

_PREFIX = ".llsrbm-"  # of hidden folders
_OTHERS = "it is a folder with other things in it, which would be lost"
_LARGEST_MARK = 10_000_000  # bytes


@contextmanager
def staged(path: str | Path) -> Iterator[Path]:
    """A path of the same name to write a file or a folder to, with others beside it if need be.

    All of them take their places when the block ends well, what the path names last; otherwise
    nothing is left. They get the permissions of any new file. A symbolic link is followed. A pipe
    or a device (/dev/stdout) gets the bytes of the one file. Raises `InputError`: the path cannot
    be written, or names a folder that was not written by this.
    """
    target = path_of(path)
    if target.parent.name.startswith(_PREFIX):  # stands in a folder that is to take its place
        yield target
        return
    draft = None
    try:
        target, special = _place(target)
        with tempfile.TemporaryDirectory(
            prefix=_PREFIX,  # not the target's name, which may be as long as names can be
            suffix=".tmp",
            dir=None if special else target.parent,
            ignore_cleanup_errors=True,
        ) as folder:
            draft = Path(folder) / target.name
            yield draft
            if special:
                _send(draft, target)
            else:
                _take_places(Path(folder), target)
    except OSError as error:
        of_another = error.filename and draft and not str(error.filename).startswith(str(draft))
        raise _cannot_write(path, error, f" ({error.filename})" if of_another else "") from error


def check_place(path: str | Path) -> None:
    """Raise `InputError`, as `staged` would in the end, where no file can be written: to be called
    before what takes its time to find.
    """
    try:
        target, special = _place(path_of(path))
        if target.is_dir():
            raise IsADirectoryError(0, "it is a directory")
        if not special:
            with tempfile.TemporaryFile(dir=target.parent):
                pass
    except OSError as error:
        raise _cannot_write(path, error) from error


def _place(target: Path) -> tuple[Path, bool]:
    """Where the path leads, and whether bytes have to be sent there; `OSError`: nowhere."""
    special = _is_special(target)
    target = target if special else target.resolve()
    if not special and not target.parent.is_dir():
        raise FileNotFoundError(0, f"no such directory as {target.parent}")
    if not target.name:
        raise IsADirectoryError(0, "it is a directory")
    if not special and target.is_dir() and not _is_ours(target):
        raise FileExistsError(0, _OTHERS)  # before anybody works for minutes
    return target, special


def _cannot_write(path: str | Path, error: OSError, what: str = "") -> InputError:
    return InputError(
        f"cannot write {path}: {error.strerror or error}{what}; expected a path in a directory "
        "that exists and may be written to"
    )


def _is_special(target: Path) -> bool:
    """True if bytes have to be sent there, as nothing can take its place."""
    try:
        kind = target.stat().st_mode
    except ValueError as error:  # a name that no file can have
        raise OSError(0, str(error)) from error
    except FileNotFoundError:
        return False
    # /dev/stdout may be a regular file, to which the shell goes on writing.
    place = target.absolute()
    device = place.is_relative_to("/dev/fd") or str(place) in ("/dev/stdout", "/dev/stderr")
    return device or not (stat.S_ISREG(kind) or stat.S_ISDIR(kind))


def _send(draft: Path, target: Path) -> None:
    if not draft.is_file():
        raise NotADirectoryError(0, "a folder would be written, which needs a name of its own")
    # Appended, because a redirected /dev/stdout may hold what others wrote before.
    with draft.open("rb") as written, target.open("ab") as file:
        shutil.copyfileobj(written, file)


def _take_places(folder: Path, target: Path) -> None:
    parts = sorted(folder.iterdir(), key=lambda part: part.name == target.name)
    for part in parts:
        place = target.with_name(part.name)
        if part.is_file() and place.is_dir():
            raise IsADirectoryError(0, "it is a directory")
        if part.is_dir() and place.is_file():
            raise NotADirectoryError(0, "it is a file, and a folder would be written")
        if part.is_dir() and not _is_ours(place):
            raise FileExistsError(0, _OTHERS)
        for file in [part] if part.is_file() else [p for p in part.rglob("*") if p.is_file()]:
            with file.open("r+b") as opened:  # Windows flushes what is open for writing
                os.fsync(opened.fileno())
    aside = Path(tempfile.mkdtemp(dir=folder))
    for part in parts:
        place = target.with_name(part.name)
        if part.is_dir() and place.exists():
            old = place.replace(aside / part.name)
            if not _is_ours(old):  # somebody has put another there since it was checked
                old.replace(place)
                raise FileExistsError(0, _OTHERS)
        part.replace(place)


def _is_ours(folder: Path) -> bool:
    """True if a folder is absent, empty or marked as an export's."""
    mark = folder / MARK
    try:
        if not any(folder.iterdir()):
            return True
        if not mark.is_file() or mark.stat().st_size > _LARGEST_MARK:
            return False
        content = json.loads(mark.read_text(encoding="utf-8"))
    except FileNotFoundError:
        return not folder.exists()
    except (ValueError, RecursionError):
        return False
    return isinstance(content, dict) and "package_version" in content
