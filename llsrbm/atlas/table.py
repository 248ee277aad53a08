"""A sweep's table as an atlas, and as a small file of what an atlas needs.

A table may have millions of rows of a hundred columns: only the columns of `NEEDED` are read, some
rows at a time, and what is kept of a jump are some twenty numbers.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from llsrbm.atlas.jumps import AMOUNTS, DRIVES, FALLS, NOTHING, Atlas, Jumps
from llsrbm.errors import Error, InputError
from llsrbm.sweep.rows import LIMIT, PLANNED, STATUSES

if TYPE_CHECKING:
    import pyarrow as pa
    import pyarrow.parquet as pq

Array = NDArray[np.float64]

TABLE = "jumps.parquet"

_TEXTS = ("robot", "model", "type")
_FIGURES = ("flight_s", "torque_share")  # the same in all rows of a jump
_OUTCOMES = ("status", "stopped_by", "landed", "strict")
NEEDED = ("jump", *_TEXTS, *AMOUNTS, *DRIVES, "robot_hash", *_OUTCOMES, *_FIGURES)
"""Columns from which an atlas is made, beside limits that the sweep varies."""

_TITLE = b"title"  # of a small file's metadata
_BATCH = 50_000  # rows that are read at a time
_MOST = 1_000_000  # rows of a table: reading them takes 7 s and most of a gigabyte
_DECIMALS = 9  # to which values of an axis are compared: a grid's differ in their last bits
_HALF = 0.5  # of a jump's seeds: if fewer land, the jump cannot be done


def read_atlas(path: Path) -> Atlas:
    """The atlas of a sweep's folder, or of a table.

    Raises:
        InputError: there is none, or it is no sweep's table; one line.
    """
    with _opened(path) as (table, file):
        limits = _checked(table, file)
        title = _title(table, file)
        groups = _groups(_columns(file, limits))
    if not groups:
        raise InputError(f"{table}: has no jumps; expected a sweep with one at least")
    return Atlas(title, groups)


def write_small(path: Path, target: Path) -> None:
    """Write what an atlas needs of a sweep's table as a file of its own.

    Raises:
        InputError: there is no table, or it is no sweep's.
        Error: the file cannot be written.
    """
    import pyarrow.parquet as pq

    with _opened(path) as (table, file):
        names = [*NEEDED, *_checked(table, file)]
        small = file.read(columns=names).select(names)
        small = small.replace_schema_metadata({_TITLE: _title(table, file).encode()})
    for name in _FIGURES:
        small = small.set_column(names.index(name), name, small[name].cast("float32"))
    try:
        pq.write_table(small, target, compression="zstd", compression_level=19)
    except OSError as error:
        raise Error(f"{target}: cannot be written ({error.strerror or error})") from error


@contextmanager
def _opened(path: Path) -> Iterator[tuple[Path, pq.ParquetFile]]:
    """The table of a folder, or that at a path, and where it is."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    table = path / TABLE if path.is_dir() else path
    if not table.is_file():
        raise InputError(
            f"{path}: no {TABLE} there; expected the folder of a sweep that is over, or a table"
        )
    try:
        with pq.ParquetFile(table) as file:
            yield table, file
    except (pa.ArrowException, OSError) as error:
        told = " ".join(str(error).split())
        raise InputError(f"{table}: cannot be read as a sweep's table ({told:.200})") from error


def _checked(path: Path, file: pq.ParquetFile) -> tuple[str, ...]:
    """Names of the limits that vary, if it is a sweep's table."""
    names = file.schema_arrow.names
    missing = [name for name in NEEDED if name not in names]
    if missing:
        raise InputError(
            f'{path}: has no column "{missing[0]}"; expected a table of `llsrbm sweep`'
        )
    if file.metadata.num_rows > _MOST:
        raise InputError(
            f"{path}: {file.metadata.num_rows} rows are too many for an atlas; expected at most "
            f"{_MOST}"
        )
    return tuple(name for name in names if name.startswith(LIMIT))


def _title(path: Path, file: pq.ParquetFile) -> str:
    """The sweep's; of a table that says none, its folder's name."""
    stated = (file.schema_arrow.metadata or {}).get(_TITLE)
    if stated is not None:
        return str(stated.decode())
    try:
        return str(json.loads((path.parent / "sweep.json").read_text(encoding="utf-8"))["title"])
    except (OSError, ValueError, KeyError, TypeError):
        return path.parent.name if path.name == TABLE else path.stem


def _columns(file: pq.ParquetFile, limits: tuple[str, ...]) -> dict[str, NDArray[Any]]:
    """Column name -> (R,); texts as codes and (R,) objects of the few that there are."""
    parts: dict[str, list[NDArray[Any]]] = {}
    for batch in _batches(file, (*NEEDED, *limits)):
        for name, values in batch.items():
            parts.setdefault(name, []).append(values)
    return {name: np.concatenate(values) for name, values in parts.items()}


def _batches(file: pq.ParquetFile, names: tuple[str, ...]) -> Iterator[dict[str, NDArray[Any]]]:
    for batch in file.iter_batches(batch_size=_BATCH, columns=list(names)):
        yield {name: _array(batch.column(name)) for name in names}


def _array(column: pa.Array) -> NDArray[Any]:
    """Texts as objects, "" for null; flags as numbers, NaN for null."""
    import pyarrow as pa

    if pa.types.is_string(column.type):
        # The same few texts again and again: one object each.
        coded = column.fill_null("").dictionary_encode()
        texts = np.array(coded.dictionary.to_pylist(), dtype=object)
        return texts[coded.indices.to_numpy()]
    if pa.types.is_boolean(column.type):
        column = column.cast(pa.int8()).cast(pa.float64())
    return np.asarray(column.to_numpy(zero_copy_only=False))


def _groups(columns: dict[str, NDArray[Any]]) -> tuple[Jumps, ...]:
    if not columns:
        return ()
    order = np.argsort(columns["jump"], kind="stable")
    columns = {name: values[order] for name, values in columns.items()}
    first = np.flatnonzero(np.diff(columns["jump"], prepend=columns["jump"][0] - 1))
    one = _reduced(columns, first)
    keys = list(zip(*(columns[name][first] for name in _TEXTS), strict=True))
    hashes = columns["robot_hash"][first]
    groups = []
    for key in dict.fromkeys(keys):
        mask = np.fromiter((each == key for each in keys), dtype=bool, count=len(keys))
        robot, model, kind = map(str, key)
        groups.append(_masked(one, mask, robot, model, kind, str(hashes[mask][0])))
    return tuple(groups)


def _reduced(columns: dict[str, NDArray[Any]], first: NDArray[np.int64]) -> Jumps:
    """One jump a jump, whatever its seeds; of several robots yet."""
    counts = np.diff(first, append=len(columns["jump"]))
    statuses = columns["status"]
    unknown = set(statuses.tolist()) - set(STATUSES)
    if unknown:
        raise InputError(f"a row has the status {min(unknown)!r:.40}; expected a sweep's table")
    planned = np.minimum.reduceat((statuses == PLANNED).astype(float), first)
    landed, strict = (_share(columns[name], first, counts) for name in ("landed", "strict"))
    stops, stop = _stops(columns, first, planned, landed)
    asked = {name: columns[name][first].astype(float) for name in (*AMOUNTS, *DRIVES)}
    asked |= {n: v[first].astype(float) for n, v in columns.items() if n.startswith(LIMIT)}
    flight, torque = (
        np.where(planned > 0, columns[name][first].astype(float), np.nan) for name in _FIGURES
    )
    return Jumps(
        *("", "", ""),
        numbers=columns["jump"][first].astype(np.int64),
        asked={name: np.round(values, _DECIMALS) for name, values in asked.items()},
        planned=planned,
        landed=landed,
        strict=strict,
        flight=flight,
        torque_share=torque,
        stops=stops,
        stop=stop,
        robot_hash="",
    )


def _share(flags: NDArray[Any], first: NDArray[np.int64], counts: NDArray[np.int64]) -> Array:
    """(J,) of a jump's seeds; NaN of jumps of which a seed was not simulated."""
    shares: Array = np.add.reduceat(flags.astype(float), first) / counts
    return shares


def _stops(
    columns: dict[str, NDArray[Any]], first: NDArray[np.int64], planned: Array, landed: Array
) -> tuple[tuple[str, ...], NDArray[np.int64]]:
    """Names of what stops jumps, the most frequent first, and (J,) places therein."""
    told, statuses = columns["stopped_by"][first], columns["status"][first]
    named = np.where(told == "", statuses, told)  # refused, failed, or not planned for no reason
    # NaN, which is not simulated, is not below.
    falls = (planned > 0) & (landed < _HALF)
    names = np.where(falls, FALLS, np.where(planned > 0, NOTHING, named)).astype(str)
    found, places, counts = np.unique(names, return_inverse=True, return_counts=True)
    order = sorted(range(len(found)), key=lambda k: (found[k] != NOTHING, -counts[k], found[k]))
    rank = np.empty(len(found), dtype=np.int64)
    rank[order] = np.arange(len(found))
    return tuple(str(found[k]) for k in order), rank[places]


def _masked(
    one: Jumps, mask: NDArray[np.bool_], robot: str, model: str, kind: str, robot_hash: str
) -> Jumps:
    arrays = {
        field.name: getattr(one, field.name)[mask]
        for field in fields(Jumps)
        if isinstance(getattr(one, field.name), np.ndarray)
    }
    asked = {name: values[mask] for name, values in one.asked.items()}
    return replace(
        one, robot=robot, model=model, type=kind, robot_hash=robot_hash, asked=asked, **arrays
    )
