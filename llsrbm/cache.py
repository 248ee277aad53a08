"""The user's cache: things computed once a machine (leg fits, meshes, solvers).

An entry lies at `<cache directory>/<kind>/<hash of its key><suffix>`. Another input is another
file, so nothing is ever invalidated. The entries last used are kept, of each kind and robot some.
"""

import hashlib
import io
import logging
import os
import tempfile
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import platformdirs
from numpy.typing import NDArray

ENVIRONMENT_VARIABLE = "LLSRBM_CACHE"

# Entries of one kind that are kept: a few versions of the project and of a robot file side by side.
KEPT = 4

_LONGEST_WRITE = 3600.0  # s

_log = logging.getLogger(__name__)
_DIGEST_SIZE = hashlib.sha256().digest_size


def cache_directory() -> Path:
    """Directory of all entries: `LLSRBM_CACHE` if set, else the platform's for the user."""
    override = os.environ.get(ENVIRONMENT_VARIABLE)
    return Path(override) if override else Path(platformdirs.user_cache_dir("llsrbm"))


def content_key(*parts: bytes | str | Path) -> bytes:
    """One key out of several parts; a `Path` stands for its file's content. Raises `OSError`: a
    file cannot be read.
    """
    digest = hashlib.sha256()
    for part in parts:
        content = part.read_bytes() if isinstance(part, Path) else part
        content = content.encode() if isinstance(content, str) else content
        # The length keeps ("ab", "c") and ("a", "bc") apart.
        digest.update(len(content).to_bytes(8, "little"))
        digest.update(content)
    return digest.digest()


def cache_path(kind: str, key: bytes, suffix: str) -> Path:
    """Path of an entry, which need not exist yet; `suffix` with its dot (".npz")."""
    return cache_directory() / kind / (hashlib.sha256(key).hexdigest()[:32] + suffix)


def write_atomically(path: Path, data: bytes) -> None:
    """Write a file so that a reader sees either none of it or all of it; makes its directory.
    Raises `OSError`: the file cannot be written.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=path.name, suffix=".tmp")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
        Path(temporary).replace(path)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise


def read_checked(path: Path) -> bytes | None:
    """Content written by `write_checked`; None if there is none, or, with a warning, damaged."""
    try:
        stored = path.read_bytes()
    except FileNotFoundError:
        return None
    except OSError as error:
        _log.warning("cache entry %s cannot be read (%s); it is computed anew", path, error)
        return None
    digest, data = stored[:_DIGEST_SIZE], stored[_DIGEST_SIZE:]
    if hashlib.sha256(data).digest() != digest:
        _log.warning("cache entry %s is damaged; it is computed anew", path)
        return None
    mark_used(path)
    return data


def mark_used(path: Path) -> None:
    """Have other entries of the kind removed before this one; no matter if it is read-only."""
    with suppress(OSError):
        os.utime(path)


def write_checked(path: Path, data: bytes) -> None:
    """Store an entry with a checksum; a cache that cannot be written is only a warning."""
    try:
        write_atomically(path, hashlib.sha256(data).digest() + data)
    except OSError as error:
        _log.warning("cache entry %s cannot be written (%s); it is not kept", path, error)
    else:
        forget_old(path)


def read_arrays(path: Path) -> dict[str, NDArray[Any]] | None:
    """Arrays written by `write_arrays`, or None as of `read_checked`."""
    data = read_checked(path)
    if data is None:
        return None
    with np.load(io.BytesIO(data), allow_pickle=False) as stored:
        return dict(stored)


def write_arrays(path: Path, arrays: Mapping[str, Any]) -> None:
    """Store arrays as `write_checked` does."""
    buffer = io.BytesIO()
    np.savez(buffer, **arrays)
    write_checked(path, buffer.getvalue())


def forget_old(path: Path) -> None:
    """Remove the entries of a new one's kind that were not used for longest, of those one may; and
    what a process that was killed had begun to write.
    """
    for begun in path.parent.glob("*.tmp"):
        with suppress(OSError):
            if time.time() - begun.stat().st_mtime > _LONGEST_WRITE:
                begun.unlink()
    used: dict[Path, float] = {}
    for entry in path.parent.glob(f"*{path.suffix}"):
        with suppress(FileNotFoundError):  # another process has just removed it
            used[entry] = entry.stat().st_mtime
    for entry in sorted(used, key=used.__getitem__)[:-KEPT]:
        with suppress(OSError):
            entry.unlink(missing_ok=True)


def cached_bytes(kind: str, key: bytes, suffix: str, compute: Callable[[], bytes]) -> bytes:
    """The entry `key`, computed and stored if it is missing or damaged."""
    path = cache_path(kind, key, suffix)
    data = read_checked(path)
    if data is None:
        data = compute()
        write_checked(path, data)
    return data
