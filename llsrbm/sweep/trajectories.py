"""Planned motions of a sweep as zarr, through xarray: one group a robot, model and number of knots.

    xarray.open_zarr("DIR/trajectories.zarr", group="anymal/llsrbm-plus/49")

A group's dimensions are jump, knot, leg, contact, joint and axis; the coordinate `jump` is the
number of the jump, as in the table's column of that name. Only jumps that were planned are there.
Quantities are those of a plan, with their units as attributes. The format is zarr's version 2, of
which names of joints are a part, too.
"""

from __future__ import annotations

import io
import re
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from llsrbm.motion.plan import Plan
    from llsrbm.sweep.points import Point
    from llsrbm.sweep.shard import Shard

STORE = "trajectories.zarr"

# Quantity -> its dimensions after jump, and its unit.
QUANTITIES: dict[str, tuple[tuple[str, ...], str]] = {
    "time": (("knot",), "s"),
    "phase": (("knot",), ""),
    "com": (("knot", "xyz"), "m"),
    "com_velocity": (("knot", "xyz"), "m/s"),
    "base_position": (("knot", "xyz"), "m"),
    "base_quat": (("knot", "wxyz"), ""),
    "angular_velocity": (("knot", "xyz"), "rad/s"),
    "angular_momentum": (("knot", "xyz"), "kg m2/s"),
    "foot_position": (("knot", "leg", "xyz"), "m"),
    "contact_force": (("knot", "contact", "xyz"), "N"),
    "joint_position": (("knot", "joint"), "rad"),
    "joint_velocity": (("knot", "joint"), "rad/s"),
    "joint_torque": (("knot", "joint"), "Nm"),
}
_FORMAT = 2
_CHUNK = 64  # jumps: what is read at a time is a megabyte
_TOGETHER = 16 * _CHUNK  # jumps of a group that are held before they are written
_NUMBER, _BETWEEN = "jump", "|"
_LABELS = {"joint": "joint_names", "leg": "leg_names"}
"""Dimension -> where a plan has what its places are called."""


def arrays_of(plans: Sequence[tuple[Point, Plan]]) -> dict[str, dict[str, Any]]:
    """Group -> quantity -> (jumps, ...) array, of plans in the order of their jumps."""
    groups: dict[str, list[tuple[Point, Plan]]] = {}
    for point, plan in plans:
        robot = re.sub(r"[^\w.-]+", "_", point.jump.robot).strip("_")
        group = f"{robot}/{point.jump.model}/{len(plan.time)}"
        groups.setdefault(group, []).append((point, plan))
    return {group: _stacked(members) for group, members in groups.items()}


def _stacked(members: list[tuple[Point, Plan]]) -> dict[str, Any]:
    arrays: dict[str, Any] = {_NUMBER: np.array([point.number for point, _ in members])}
    for name in QUANTITIES:
        values = [getattr(plan, name) for _, plan in members]
        if all(value is not None for value in values):
            arrays[name] = np.stack(values)
    for dimension, name in _LABELS.items():
        arrays[dimension] = np.array(getattr(members[0][1], name))
    return arrays


def packed(shard: Shard) -> bytes:
    """A shard's trajectories as the content of an npz file."""
    buffer = io.BytesIO()
    named = {
        f"{group}{_BETWEEN}{name}": array
        for group, arrays in shard.trajectories.items()
        for name, array in arrays.items()
    }
    np.savez_compressed(buffer, **named)
    return buffer.getvalue()


def merge(parts: Sequence[Path], store: Path) -> None:
    """Write the trajectories of all parts into a zarr store, by jump.

    The store appears whole or not at all.

    Args:
        parts: files of `packed`, in the order of their first jumps.
        store: its folder; one that is there is replaced.

    Raises:
        OSError: it cannot be written.
    """
    temporary = store.with_name(store.name + ".new")
    shutil.rmtree(temporary, ignore_errors=True)
    temporary.mkdir(parents=True)  # also of a sweep without any plan
    begun: set[str] = set()
    held: dict[str, dict[str, Any]] = {}
    for part in parts:
        # No later part has jumps before this one's first.
        _write(held, temporary, begun, before=int(part.stem))
        for group, arrays in _unpacked(part).items():
            mine = held.get(group)
            held[group] = arrays if mine is None else _joined([mine, arrays])
    _write(held, temporary, begun, before=None)
    shutil.rmtree(store, ignore_errors=True)
    temporary.replace(store)


def _unpacked(part: Path) -> dict[str, dict[str, Any]]:
    groups: dict[str, dict[str, Any]] = {}
    with np.load(part, allow_pickle=False) as file:
        for key in file.files:
            group, name = key.split(_BETWEEN)
            groups.setdefault(group, {})[name] = file[key]
    return groups


def _joined(several: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Arrays of several shards of a group; a quantity that one lacks is left out."""
    return {
        name: array if name in _LABELS else np.concatenate([arrays[name] for arrays in several])
        for name, array in several[0].items()
        if all(name in arrays for arrays in several)
    }


def _write(
    held: dict[str, dict[str, Any]], store: Path, begun: set[str], before: int | None
) -> None:
    """Append what is held, by jump, of groups that hold enough, and forget it.

    Args:
        held: group -> arrays.
        store: the zarr store.
        begun: groups that it has.
        before: only jumps before this one; None: all of all groups.
    """
    for group, arrays in held.items():
        jumps = arrays[_NUMBER]
        if before is not None and len(jumps) < _TOGETHER:
            continue
        order = np.argsort(jumps)
        ready = order if before is None else order[jumps[order] < before]
        kept = order[len(ready) :]
        if len(ready):
            _append(_picked(arrays, ready), store, group, begun)
        held[group] = _picked(arrays, kept)


def _picked(arrays: dict[str, Any], rows: Any) -> dict[str, Any]:
    return {name: a if name in _LABELS else a[rows] for name, a in arrays.items()}


def _append(arrays: dict[str, Any], store: Path, group: str, begun: set[str]) -> None:
    dataset = _dataset(arrays)
    if group in begun:  # what has no jumps is there already
        dataset = dataset.drop_vars([*_LABELS])
        dataset.to_zarr(store, group=group, zarr_format=_FORMAT, append_dim="jump")
        return
    chunks = {
        name: {"chunks": (_CHUNK, *variable.shape[1:])}
        for name, variable in dataset.variables.items()
        if variable.dims[0] == "jump"
    }
    dataset.to_zarr(store, group=group, zarr_format=_FORMAT, mode="w", encoding=chunks)
    begun.add(group)


def _dataset(arrays: dict[str, Any]) -> Any:
    import xarray

    variables = {
        name: (("jump", *dimensions), arrays[name], {"units": unit})
        for name, (dimensions, unit) in QUANTITIES.items()
        if name in arrays
    }
    coordinates = {_NUMBER: arrays[_NUMBER], **{name: arrays[name] for name in _LABELS}}
    return xarray.Dataset(variables, coords=coordinates)
