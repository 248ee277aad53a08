"""The folder of a sweep, which is its table from the first rows on.

    DIR/sweep.json               spec, versions and robots; written first
    DIR/jumps.parquet/N.parquet  rows of consecutive jumps from number N on; whole or not there

pyarrow, pandas and duckdb read `DIR/jumps.parquet` as one table, in the order of the spec. A sweep
that was cut off goes on with the jumps that have no rows.
"""

from __future__ import annotations

import json
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self, TextIO

import numpy as np

from llsrbm.arrays import BoolArray
from llsrbm.errors import Error, InputError
from llsrbm.file_locks import lock
from llsrbm.sweep.rows import TableRow, schema, table_of

if TYPE_CHECKING:
    from llsrbm.sweep.points import Points

TABLE, STATED = "jumps.parquet", "sweep.json"
SCHEMA = "llsrbm.sweep/1"

_LOCK, _UNFINISHED = ".lock", ".unfinished"  # a name with a dot in front is no part of the table
_DIGITS = 12  # of a part's name, so that names sort as numbers
_MOST_ROWS = 10_000  # of a part
_PART_TIME = 30.0  # s of work that a process that is killed may lose


class Folder:
    """A sweep's folder, held by one process at a time.

    `done`: (jumps,) which of them have their rows; `damaged`: names of parts that could not be
    read, whose jumps are computed again.
    """

    def __init__(self, path: Path, points: Points, origin: Mapping[str, str]) -> None:
        """Open or make it; `origin`: see `llsrbm.sweep.rows.origin`.

        Raises:
            InputError: it belongs to another sweep, is no folder, or another process works in it.
            Error: it cannot be written.
        """
        self.path, self.points = path, points
        self.damaged: list[str] = []
        self.done: BoolArray = np.zeros(points.count, dtype=bool)
        self._schema = schema(points.spec)
        self._first, self._next, self._rows = 0, 0, list[TableRow]()
        self._since = time.monotonic()
        with disk_errors(path):
            begin_folder(path)
            self._lock = _locked(path)
            self._begin(origin)
            self.table.mkdir(exist_ok=True)
            self._find_parts()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        try:
            self.flush()
        finally:
            self._lock.close()

    @property
    def table(self) -> Path:
        """The folder of the table's parts."""
        return self.path / TABLE

    def append(self, jump: int, rows: list[TableRow]) -> None:
        """Keep a jump's rows, one a seed; `flush`, or some seconds, put them on the disk.

        Jumps' numbers increase from call to call, so that parts are in order. Raises `Error`: no
        room on the disk, or no right to write.
        """
        if not self._rows or jump != self._next:
            self.flush()
            self._first, self._since = jump, time.monotonic()
        self._rows += rows
        self._next = jump + 1
        if len(self._rows) >= _MOST_ROWS or time.monotonic() - self._since > _PART_TIME:
            self.flush()

    def flush(self) -> None:
        """Write the rows that are held as a part of the table."""
        import pyarrow.parquet as pq

        if not self._rows:
            return
        held, self._rows = self._rows, []
        unfinished = self.table / _UNFINISHED
        with disk_errors(self.path):
            try:
                pq.write_table(table_of(held, self._schema), unfinished, compression="zstd")
                unfinished.replace(self.table / f"{self._first:0{_DIGITS}d}.parquet")
            except BaseException:
                unfinished.unlink(missing_ok=True)
                raise
        self.done[self._first : self._next] = True

    def missing(self) -> Iterator[int]:
        """Numbers of the jumps that are not done yet, in order."""
        return (int(number) for number in np.flatnonzero(~self.done))

    def _begin(self, origin: Mapping[str, str]) -> None:
        spec = self.points.spec
        path = self.path / STATED
        stated = {
            "schema": SCHEMA,
            "title": spec.title,
            "digest": spec.digest(),
            "origin": dict(origin),
            "jumps": self.points.count,
            "rows": self.points.rows,
            "spec": spec.as_table(),
        }
        if not path.exists():
            check_empty(self.path, "sweep")
            unfinished = self.path / _UNFINISHED
            unfinished.write_text(json.dumps(stated, indent=2) + "\n", encoding="utf-8")
            unfinished.replace(path)
            return
        kept = stated_of(self.path)
        if kept["digest"] != stated["digest"]:
            raise InputError(
                f'{self.path}: is of another spec, "{kept["title"]}"; expected another folder for '
                "--out, or the spec as it was"
            )
        if other := difference(kept["origin"], origin):
            raise InputError(
                f"{self.path}: the sweep began with {other}; expected another folder for --out"
            )

    def _find_parts(self) -> None:
        """Set `done`; remove parts that cannot be read or do not fit."""
        import pyarrow as pa
        import pyarrow.parquet as pq

        for left in (self.path / _UNFINISHED, self.table / _UNFINISHED):
            left.unlink(missing_ok=True)
        for path in sorted(self.table.glob("*.parquet")):
            with suppress(pa.ArrowException, OSError, ValueError):
                jumps = pq.read_metadata(path).num_rows // self.points.spec.rows_a_jump()
                first = int(path.stem)
                self.done[first : first + jumps] = True
                continue
            self.damaged.append(path.name)
            path.unlink()


def begin_folder(path: Path) -> None:
    """Make a folder, where there is no file of that name."""
    if path.exists() and not path.is_dir():
        raise InputError(f"{path}: is a file; expected a folder")
    path.mkdir(parents=True, exist_ok=True)


def check_empty(path: Path, kind: str) -> None:
    """Refuse to begin a sweep or a data set in a folder with other things than hidden files."""
    if others := [other.name for other in path.iterdir() if not other.name.startswith(".")]:
        raise InputError(
            f"{path}: holds {others[0]}, and no {kind}; expected an empty folder, or one of this "
            f"{kind}"
        )


def stated_of(path: Path) -> dict[str, Any]:
    """The content of `sweep.json`. Raises `InputError`: there is none, or it is damaged."""
    file = path / STATED
    if not file.is_file():
        raise InputError(f"{path}: no sweep is there; expected a folder that llsrbm sweep made")
    with suppress(ValueError, OSError, AttributeError):
        stated: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
        if {"title", "digest", "origin", "rows", "spec"} <= stated.keys():
            return stated
    raise InputError(f"{file}: is damaged; expected another folder")


def difference(kept: Mapping[str, str], now: Mapping[str, str]) -> str:
    """The first version or robot that is not the same, in words; "" if all are."""
    for name, value in now.items():
        if kept.get(name) != value:
            robot = "" if name == "llsrbm" else "robot "
            return f"{robot}{name} {kept.get(name)}, here is {value}"
    return ""


@contextmanager
def disk_errors(path: Path) -> Iterator[None]:
    """Raise `Error`, one line, in place of `OSError`."""
    try:
        yield
    except OSError as error:
        raise Error(
            f"{path}: cannot be written ({error.strerror or error}); what is done is kept: run "
            "the same command again to go on"
        ) from error


def _locked(path: Path) -> TextIO:
    file = (path / _LOCK).open("w")
    if not lock(file):
        file.close()
        raise InputError(f"{path}: another process works in it; expected another folder for --out")
    return file
