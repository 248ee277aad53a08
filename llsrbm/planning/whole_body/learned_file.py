"""Files of solved jumps: `assets/learned/NAME.npz`, or one in the cache, by `llsrbm robot learn`.

A table is of one robot, by its numbers, of the default model and type of jump, and of the robot's
own weights and limits. Where it should fit and does not, a warning says why, once.
"""

from __future__ import annotations

import json
import logging
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from llsrbm.cache import cache_path
from llsrbm.files.npz import write_archive
from llsrbm.installed import assets_directory
from llsrbm.planning.solve.jump_layout import layout_of
from llsrbm.planning.whole_body.grid import Grid
from llsrbm.planning.whole_body.learned import NEIGHBOURS, Learned, Outcomes
from llsrbm.request.jump import COMPONENTS, Jump
from llsrbm.request.jump_types import schedule_of
from llsrbm.request.messages import field_specs
from llsrbm.request.tuning import Tuning
from llsrbm.robots import load_robot
from llsrbm.robots.numbers_key import numbers_key
from llsrbm.robots.robot import Robot

SCHEMA = "llsrbm.learned/2"
# Beyond what neighbours agree by nothing is kept, which makes a file small: of a variable steps of
# this share of its largest value, of a multiplier the leading bits, and nothing of those of bounds
# that are not met.
VARIABLE_STEP = 2.0**-11
MULTIPLIER_BITS = 4
LEAST_MULTIPLIER = 2.0**-13
_OF_OUTCOMES = ("requests", "flight", "torque_share", "refused")

# Limits that are in the whole body's rows. Others, and weights, a plan has from its draft alone.
LIMITS = frozenset(
    (
        *("friction", "torque_share", "speed_share", "drive_strength", "battery"),
        *(f"{phase}_{end}" for phase in ("takeoff", "flight", "landing") for end in ("min", "max")),
        *("apex_min", "apex_max", "clearance", "knee_margin", "feet_apart", "stop_margin"),
    )
)

_log = logging.getLogger(__name__)
_Taken = TypeVar("_Taken")
_Stamped = tuple[tuple[Path, int], ...]  # files, and when they were last written


def leads_to(jump: Jump, tuning: Tuning) -> bool:
    """Whether jumps like this one may begin from a table of the jump's robot.

    What is stood on, a payload, and limits may be others than the table's: they are in the rows of
    the problem that is solved.
    """
    bare = replace(jump.on_ground(0.0), payload=())
    return _is_plain(bare) and not tuning.weights and LIMITS.issuperset(tuning.limits)


def knows(jump: Jump, tuning: Tuning) -> bool:
    """Whether what became of a table's jumps is known to become of jumps like this one."""
    return _is_plain(jump.on_ground(0.0)) and not tuning


def _is_plain(jump: Jump) -> bool:
    plain = Jump(robot=jump.robot)
    others = (name for name in field_specs(Jump) if name not in COMPONENTS)
    return all(getattr(jump, name) == getattr(plain, name) for name in others)


def table_for(jump: Jump, tuning: Tuning, grid: Grid) -> Learned | None:
    """The table from which jumps like this one may begin, read when it is first wanted.

    It is that of the robot as its file has it, whatever a request has it carry.
    """
    return _table(load_robot(jump.robot), grid) if leads_to(jump, tuning) else None


def outcomes_of(robot: Robot) -> Outcomes | None:
    """The outcomes of the robot's jumps of the default type; None: no table of it fits."""
    plain = Jump(robot=str(robot.path))
    grid = Grid.at(schedule_of(plain, robot), layout_of(plain, robot).intervals)
    return _first_outcomes(_there(robot, grid), robot, grid)


def _table(robot: Robot, grid: Grid) -> Learned | None:
    """The robot's, read when it is first wanted, and again when a file has changed."""
    return _first(_there(robot, grid), robot, grid)


def _there(robot: Robot, grid: Grid) -> _Stamped:
    return tuple((path, path.stat().st_mtime_ns) for path in places(robot, grid) if path.exists())


@lru_cache(maxsize=4)
def _first(files: _Stamped, robot: Robot, grid: Grid) -> Learned | None:
    found = (read(path, robot, grid) for path, _ in files)
    return next((table for table in found if table is not None), None)


@lru_cache(maxsize=16)
def _first_outcomes(files: _Stamped, robot: Robot, grid: Grid) -> Outcomes | None:
    found = (read_outcomes(path, robot, grid) for path, _ in files)
    return next((outcomes for outcomes in found if outcomes is not None), None)


def places(robot: Robot, grid: Grid) -> tuple[Path, Path]:
    """Where a robot's table may lie: of those that ship, and of one's own.

    The names hold all that they depend on but the problem's rows, whose number is compared: one of
    another problem takes more iterations, or leads nowhere and is not followed.
    """
    key = f"{SCHEMA} {numbers_key(robot)} {grid.name}".encode()
    return shipped(robot), cache_path(f"learned-{robot.name}", key, ".npz")


def shipped(robot: Robot) -> Path:
    """Where a robot's table lies in the project."""
    return assets_directory() / "learned" / f"{robot.name}.npz"


def write(path: Path, table: Learned, robot: Robot, grid: Grid) -> None:
    """Write a table's file.

    Raises:
        InputError: it cannot be written.
    """
    largest = np.abs(table.variables).max(axis=0)
    step = 2.0 ** np.ceil(np.log2(np.maximum(largest, np.finfo(np.float16).tiny))) * VARIABLE_STEP
    mantissa, exponent = np.frexp(table.multipliers)
    steps = 2.0**MULTIPLIER_BITS
    kept = np.ldexp(np.round(mantissa * steps) / steps, exponent)
    kept[np.abs(kept) < LEAST_MULTIPLIER] = 0.0
    # What is alike lies together: by variables, not by jumps.
    write_archive(
        path,
        {
            "meta": np.array(json.dumps(_meta(robot, grid))),
            "scale": table.scale,
            **{name: getattr(table.outcomes, name) for name in _OF_OUTCOMES},
            "stopped_by": np.array(table.outcomes.stopped_by, dtype=str),
            "variables": (np.round(table.variables / step) * step).T.astype(np.float32),
            "multipliers": kept.T.astype(np.float32),
        },
    )


def read(path: Path, robot: Robot, grid: Grid) -> Learned | None:
    """Read a table; None: there is none, or it is of another type of jump.

    A warning says, once, where one is ignored: it is damaged, or of other numbers of the robot.
    """
    return _read(path, robot, grid, _learned)


def read_outcomes(path: Path, robot: Robot, grid: Grid) -> Outcomes | None:
    """Read of a table what became of its jumps; the rest as `read`."""
    return _read(path, robot, grid, _outcomes)


def _read(
    path: Path, robot: Robot, grid: Grid, take: Callable[[Mapping[str, NDArray[Any]]], _Taken]
) -> _Taken | None:
    expected = _meta(robot, grid)
    try:
        with np.load(path, allow_pickle=False) as file:
            meta = json.loads(str(file["meta"]))
            if not isinstance(meta, dict) or meta.get("grid") != expected["grid"]:
                return None
            if meta != expected:
                _refuse(path, "it was learned with other numbers of the robot")
                return None
            jumps = len(file["requests"])
            if jumps < NEIGHBOURS:
                _refuse(path, f"it has {jumps} jumps, fewer than {NEIGHBOURS}")
                return None
            return take(file)
    except FileNotFoundError:
        return None
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
        _refuse(path, f"it is damaged ({type(error).__name__})")
        return None


def _outcomes(file: Mapping[str, NDArray[Any]]) -> Outcomes:
    columns = {name: file[name].astype(np.float64) for name in _OF_OUTCOMES}
    return Outcomes(**columns, stopped_by=tuple(file["stopped_by"].tolist()))


def _learned(file: Mapping[str, NDArray[Any]]) -> Learned:
    scale, variables, multipliers = (
        file[name].astype(np.float64) for name in ("scale", "variables", "multipliers")
    )
    found = Learned(
        _outcomes(file),
        scale,
        np.ascontiguousarray(variables.T),
        np.ascontiguousarray(multipliers.T),
    )
    if not len(found.outcomes.requests) == len(found.variables) == len(found.multipliers):
        raise ValueError("solutions of other jumps")
    return found


def _meta(robot: Robot, grid: Grid) -> dict[str, str]:
    """Plain data on which a table's solutions depend."""
    return {"schema": SCHEMA, "robot": numbers_key(robot), "grid": grid.name}


@lru_cache(maxsize=64)
def _refuse(path: Path, reason: str) -> None:
    _log.warning("%s, a table of solved jumps, is ignored: %s", path.name, reason)
