"""A sweep's table as an atlas.

A table may have millions of rows of a hundred columns: only the columns of `NEEDED` are read, some
rows at a time, and some twenty numbers a jump are kept.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from llsrbm.arrays import Array, IntArray
from llsrbm.atlas.jumps import AMOUNTS, DRIVES, FALLS, NOTHING, Atlas, Jumps
from llsrbm.errors import InputError, require
from llsrbm.request.jump import Jump
from llsrbm.sweep.folder import STATED, TABLE
from llsrbm.sweep.rows import LIMIT, PLANNED, STATUSES

if TYPE_CHECKING:
    import pyarrow as pa

_Columns = dict[str, NDArray[Any]]

_ARMS = "arms"  # A column that tables from before robots had arms do not have
_TEXTS = ("robot", "model", "type", "robot_hash", "status", "stopped_by")
_GROUPED = ("robot", "model", "type")
_FIGURES = ("flight_s", "torque_share")  # the same in all rows of a jump
NEEDED = ("jump", *_TEXTS, *AMOUNTS, *DRIVES, "landed", "strict", *_FIGURES)
"""Columns from which an atlas is made, beside limits that the sweep varies."""

_BATCH = 50_000  # rows that are read at a time
_MOST = 1_000_000  # rows of a table: reading them takes 7 s and most of a gigabyte
_DECIMALS = 9  # to which values of an axis are compared: a grid's differ in their last bits
_HALF = 0.5  # of a jump's seeds: if fewer land, the jump cannot be done


def read_atlas(path: Path) -> Atlas:
    """The atlas of a sweep's folder, or of its table. Raises `InputError`: there is none, or it is
    no sweep's table; one line.
    """
    title, columns = _read(path)
    groups = _groups(columns)
    if not groups:
        raise InputError(f"{path}: has no jumps; expected a sweep with one at least")
    return Atlas(title, groups)


def _read(path: Path) -> tuple[str, _Columns]:
    """Title, and column name -> (R,): texts as objects, "" for null; flags as numbers."""
    table = path / TABLE if (path / TABLE).exists() else path
    if not table.exists() or (table.is_dir() and table.name != TABLE):
        raise InputError(f"{path}: no {TABLE} there; expected the folder of a sweep, or a table")
    require("tables of sweeps need pyarrow", "sweep", "pyarrow")
    import pyarrow as pa
    import pyarrow.dataset

    try:
        dataset = pyarrow.dataset.dataset(table, format="parquet")
        names = _checked(table, dataset.schema.names, dataset.count_rows())
        parts = [
            {name: _array(batch.column(name)) for name in names}
            for batch in dataset.to_batches(columns=list(names), batch_size=_BATCH)
        ]
    except (pa.ArrowException, OSError, ValueError) as error:
        raise _unreadable(table, error) from error
    columns = {name: np.concatenate([part[name] for part in parts]) for name in names if parts}
    stated = (dataset.schema.metadata or {}).get(b"title")
    return _title(table) if stated is None else stated.decode(), columns


def _unreadable(path: Path, error: Exception) -> InputError:
    return InputError(
        f"{path}: cannot be read as a sweep's table ({' '.join(str(error).split()):.200})"
    )


def _checked(path: Path, names: Iterable[str], rows: int) -> tuple[str, ...]:
    """The columns to be read, with limits that vary and arms, if it is a sweep's table."""
    names = tuple(names)
    more = tuple(name for name in names if name.startswith(LIMIT) or name == _ARMS)
    missing = [name for name in NEEDED if name not in names]
    if missing:
        raise InputError(
            f'{path}: has no column "{missing[0]}"; expected a table of `llsrbm sweep`'
        )
    if rows > _MOST:
        raise InputError(f"{path}: {rows} rows are too many for an atlas; expected at most {_MOST}")
    return (*NEEDED, *more)


def _title(table: Path) -> str:
    """The sweep's; of a table without one, its folder's name."""
    try:
        return str(json.loads((table.parent / STATED).read_text(encoding="utf-8"))["title"])
    except (OSError, ValueError, KeyError, TypeError):
        return table.parent.name if table.name == TABLE else table.stem


def _array(column: pa.Array) -> NDArray[Any]:
    import pyarrow as pa

    if pa.types.is_string(column.type):
        # The same few texts again and again: one object each.
        coded = column.fill_null("").dictionary_encode()
        texts = np.array(coded.dictionary.to_pylist(), dtype=object)
        return texts[coded.indices.to_numpy()]
    if pa.types.is_boolean(column.type):
        column = column.cast(pa.int8()).cast(pa.float64())
    return np.asarray(column.to_numpy(zero_copy_only=False))


def _groups(columns: _Columns) -> tuple[Jumps, ...]:
    if not len(columns.get("jump", ())):
        return ()
    order = np.argsort(columns["jump"], kind="stable")
    columns = {name: values[order] for name, values in columns.items()}
    first = np.flatnonzero(np.diff(columns["jump"], prepend=columns["jump"][0] - 1))
    requested, stops, arrays = _reduced(columns, first)
    keys = list(zip(*(columns[name][first] for name in _GROUPED), strict=True))
    hashes = columns["robot_hash"][first]
    arms = str(columns[_ARMS][0]) if _ARMS in columns else ""  # the same in all of a sweep
    groups = []
    for key in dict.fromkeys(keys):
        mask = np.fromiter((each == key for each in keys), dtype=bool, count=len(keys))
        robot, model, kind = map(str, key)
        groups.append(
            Jumps(
                robot,
                model,
                kind,
                requested={name: values[mask] for name, values in requested.items()},
                stops=stops,
                robot_hash=str(hashes[mask][0]),
                arms=arms or Jump.arms,
                **{name: values[mask] for name, values in arrays.items()},
            )
        )
    return tuple(groups)


def _reduced(
    columns: _Columns, first: IntArray
) -> tuple[dict[str, Array], tuple[str, ...], _Columns]:
    """Requests, limiting constraints and the arrays of `Jumps`: one jump a jump, of all groups."""
    counts = np.diff(first, append=len(columns["jump"]))
    statuses = columns["status"]
    unknown = set(statuses.tolist()) - set(STATUSES)
    if unknown:
        raise InputError(f"a row has the status {min(unknown)!r:.40}; expected a sweep's table")
    planned = np.minimum.reduceat((statuses == PLANNED).astype(float), first)
    # Shares of a jump's seeds; NaN of jumps of which a seed was not simulated.
    landed, strict = (
        np.add.reduceat(columns[name].astype(float), first) / counts
        for name in ("landed", "strict")
    )
    stops, stop = _stops(columns, first, planned, landed)
    requested = {name: columns[name][first].astype(float) for name in (*AMOUNTS, *DRIVES)}
    requested |= {n: v[first].astype(float) for n, v in columns.items() if n.startswith(LIMIT)}
    flight, torque = (
        np.where(planned > 0, columns[name][first].astype(float), np.nan) for name in _FIGURES
    )
    arrays = {
        "numbers": columns["jump"][first].astype(np.int64),
        "planned": planned,
        "landed": landed,
        "strict": strict,
        "flight": flight,
        "torque_share": torque,
        "stop": stop,
    }
    return {n: np.round(values, _DECIMALS) for n, values in requested.items()}, stops, arrays


def _stops(
    columns: _Columns, first: IntArray, planned: Array, landed: Array
) -> tuple[tuple[str, ...], IntArray]:
    """Names of the causes that stop jumps, the most frequent first, and (J,) places therein."""
    causes, statuses = columns["stopped_by"][first], columns["status"][first]
    # Refused, timed out, failed, or not planned for no known reason.
    named = np.where(causes == "", statuses, causes)
    # NaN, which is not simulated, is not below.
    falls = (planned > 0) & (landed < _HALF)
    names = np.where(falls, FALLS, np.where(planned > 0, NOTHING, named)).astype(str)
    found, places, counts = np.unique(names, return_inverse=True, return_counts=True)
    order = sorted(range(len(found)), key=lambda k: (found[k] != NOTHING, -counts[k], found[k]))
    rank = np.empty(len(found), dtype=np.int64)
    rank[order] = np.arange(len(found))
    return tuple(str(found[k]) for k in order), rank[places]
