"""The folder of a sweep: what is done is kept shard by shard, and merged at the end.

    DIR/sweep.json        which spec, version and robots it is of; written first
    DIR/parts/N.parquet   rows of a shard whose first jump is N, written whole or not at all
    DIR/parts/N.npz       its trajectories, if they were asked for; written before its rows
    DIR/jumps.parquet     all rows, by index; once it is there, the parts go
    DIR/trajectories.zarr likewise, see `llsrbm.sweep.trajectories`

A sweep that was cut off goes on with the jumps that no part has.
"""

from __future__ import annotations

import fcntl
import io
import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self, TextIO

import numpy as np
from numpy.typing import NDArray

from llsrbm.errors import Error, InputError
from llsrbm.sweep import rows, trajectories
from llsrbm.sweep.points import Points
from llsrbm.sweep.shard import Shard

if TYPE_CHECKING:
    import pyarrow as pa

TABLE = "jumps.parquet"
SCHEMA = "llsrbm.sweep/1"

_LOCK, _UNFINISHED = "lock", ".tmp"
_DIGITS = 12  # of a part's name, so that names sort as numbers
_GROUP = 100_000  # rows of the table that are written together: what readers read at a time


class Folder:
    """A sweep's folder, held by one process at a time.

    Attributes:
        path: where it is.
        points: the sweep's jumps.
        done: (jumps,) which of them have their rows.
        damaged: names of parts that could not be read; their jumps are computed again.
    """

    def __init__(self, path: Path, points: Points, origin: Mapping[str, str]) -> None:
        """Open or make it.

        Args:
            path: of the folder; points: the sweep.
            origin: what rows depend on beside the spec, see `llsrbm.sweep.shard.origin`.

        Raises:
            InputError: it is of another sweep, is no folder, or another process works in it.
            Error: it cannot be written.
        """
        self.path, self.points = path, points
        self.damaged: list[str] = []
        self._limits = tuple(points.spec.limits)
        with _told(path):
            if path.exists() and not path.is_dir():
                raise InputError(f"{path}: is a file; expected a folder")
            self._parts.mkdir(parents=True, exist_ok=True)
            self._lock = _locked(path)
            self._begin(origin)
            self.done = self._found()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._lock.close()

    @property
    def _parts(self) -> Path:
        return self.path / "parts"

    @property
    def table(self) -> Path:
        """Where the table is once the sweep is over."""
        return self.path / TABLE

    def write(self, shard: Shard) -> None:
        """Keep a shard: after that its jumps are done.

        Raises:
            Error: no room on the disk, or no right to write.
        """
        import pyarrow as pa
        import pyarrow.parquet as pq

        if self.done[shard.jumps].any():
            raise RuntimeError(f"jumps {shard.jumps[0]} and after came twice")
        name = f"{shard.jumps[0]:0{_DIGITS}d}"
        buffer = io.BytesIO()
        pq.write_table(pa.ipc.open_file(shard.table).read_all(), buffer, compression="zstd")
        with _told(self.path):
            if shard.trajectories:
                _write(self._parts / f"{name}.npz", trajectories.packed(shard))
            _write(self._parts / f"{name}.parquet", buffer.getvalue())
        self.done[shard.jumps] = True

    def missing(self) -> Iterator[int]:
        """Numbers of the jumps that are not done yet, in order."""
        return (int(number) for number in np.flatnonzero(~self.done))

    def finish(self) -> None:
        """Merge the parts into the table, by index, and remove them.

        Raises:
            Error: no room on the disk.
        """
        if self.table.exists():
            self._remove_parts()
            return
        with _told(self.path):
            if self.points.spec.trajectories:
                files = sorted(self._parts.glob("*.npz"))
                trajectories.merge(files, self.path / trajectories.STORE)
            self._merge()
            self._remove_parts()

    def _merge(self) -> None:
        import pyarrow.parquet as pq

        temporary = self.path / f"{TABLE}{_UNFINISHED}"
        try:
            schema = rows.schema(self._limits)
            with pq.ParquetWriter(temporary, schema, compression="zstd") as writer:
                written = 0
                for table in self._sorted():
                    first = table["index"][0].as_py() if len(table) else written
                    if first != written:
                        raise RuntimeError(f"row {written} is missing among the parts")
                    writer.write_table(table)
                    written += len(table)
            if written != self.points.rows:
                raise RuntimeError(f"{written} rows of {self.points.rows} among the parts")
            temporary.replace(self.table)
        except BaseException:
            temporary.unlink(missing_ok=True)
            raise

    def _sorted(self) -> Iterator[pa.Table]:
        """The rows of all parts by index, some at a time; parts may overlap a little."""
        import pyarrow as pa
        import pyarrow.compute as pc
        import pyarrow.parquet as pq

        held: pa.Table | None = None
        a_jump = self.points.spec.rows_a_jump()
        for path in sorted(self._parts.glob("*.parquet")):
            # No later part has rows before this one's first.
            begin = int(path.stem) * a_jump
            if held is not None and len(held) >= _GROUP:
                ready = pc.less(held["index"], begin)
                yield held.filter(ready).sort_by("index")
                held = held.filter(pc.invert(ready))
            part = pq.read_table(path, schema=rows.schema(self._limits))
            held = part if held is None else pa.concat_tables([held, part])
        if held is not None:
            yield held.sort_by("index")

    def _remove_parts(self) -> None:
        for path in self._parts.glob("*"):
            path.unlink()
        if self._parts.is_dir():
            self._parts.rmdir()

    def _begin(self, origin: Mapping[str, str]) -> None:
        """Write what the folder is of, or compare."""
        spec = self.points.spec
        path = self.path / "sweep.json"
        stated = {
            "schema": SCHEMA,
            "title": spec.title,
            "digest": spec.digest(),
            "origin": dict(origin),
            "jumps": self.points.count,
            "rows": self.points.rows,
            "spec": json.loads(spec.as_json()),
        }
        if not path.exists():
            others = [p.name for p in self.path.iterdir() if p.name not in ("parts", _LOCK)]
            if others:
                raise InputError(
                    f"{self.path}: holds {others[0]}, and no sweep; expected an empty folder, or "
                    "one of this sweep"
                )
            _write(path, (json.dumps(stated, indent=2) + "\n").encode())
            return
        try:
            kept: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
            title, digest, of = kept["title"], kept["digest"], kept["origin"]
        except (ValueError, KeyError, TypeError) as error:
            raise InputError(f"{path}: is damaged; expected another folder for --out") from error
        if digest != stated["digest"]:
            raise InputError(
                f'{self.path}: is of another spec, "{title}"; expected another folder for --out, '
                "or the spec as it was"
            )
        for name, value in origin.items():
            if of.get(name) != value:
                what = "the version of llsrbm" if name == "llsrbm" else f"the robot {name}"
                raise InputError(
                    f"{self.path}: {what} was another one when this sweep began ({of.get(name)}, "
                    f"now {value}); expected another folder for --out"
                )

    def _found(self) -> NDArray[np.bool_]:
        """Which jumps have their rows; removes what a process that died has left half done."""
        import pyarrow as pa
        import pyarrow.parquet as pq

        for path in (*self.path.glob(f"*{_UNFINISHED}"), *self._parts.glob(f"*{_UNFINISHED}")):
            path.unlink()
        if self.table.exists():
            return np.ones(self.points.count, dtype=bool)
        done = np.zeros(self.points.count, dtype=bool)
        for path in sorted(self._parts.glob("*.parquet")):
            try:
                numbers = pq.read_table(path, columns=["jump"])["jump"].to_numpy()
            except (pa.ArrowException, OSError):
                self.damaged.append(path.name)
                path.unlink()
                continue
            done[numbers] = True
        for path in self._parts.glob("*.npz"):
            if not path.with_suffix(".parquet").exists():
                path.unlink()
        return done


def _write(path: Path, content: bytes) -> None:
    """A file that is there whole or not at all; nobody else writes it, see `_locked`."""
    temporary = path.with_name(path.name + _UNFINISHED)
    try:
        temporary.write_bytes(content)
        temporary.replace(path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def _locked(path: Path) -> TextIO:
    lock = (path / _LOCK).open("w")
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        lock.close()
        raise InputError(
            f"{path}: another process works in it; expected another folder for --out"
        ) from None
    return lock


@contextmanager
def _told(path: Path) -> Iterator[None]:
    """Say in one line what a disk refuses."""
    try:
        yield
    except OSError as error:
        raise Error(
            f"{path}: cannot be written ({error.strerror or error}); what is done is kept: run "
            "the same command again to go on"
        ) from error
