"""Tables of solved jumps: where the whole body's problem begins, if there are some nearby.

A file a robot, `assets/learned/NAME.npz` or one in the cache, made by `llsrbm robot learn`. It has
requests x (twist, forward, lateral, height), scaled to -1 ... 1 over what the robot's file allows,
and of each the solution's variables and multipliers v. For a new request x the nearest K give, by a
linear regression that is weighted by nearness,

    v(x) = c0 + C (x_k - x)   with the least   sum_k exp(-(WIDTH d_k / d_K)^2) |v_k - v(x_k)|^2 ,

and c0 is where `Solver.follow` begins. Quaternions have no jumps of sign between neighbours: all of
them begin at 1, 0, 0, 0 and turn on without a break, past half a turn, too.

A table is of one robot, by its numbers, of the default model and type of jump, and of the robot's
own weights and limits. Where it should fit and does not, a warning says why, once.
"""

from __future__ import annotations

import json
import logging
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from llsrbm.cache import cache_path
from llsrbm.files.npz import write_archive
from llsrbm.installed import assets_directory
from llsrbm.ocp.horizon import Iterate
from llsrbm.planning.whole_body.grid import Grid
from llsrbm.request.jump import COMPONENTS, Jump
from llsrbm.request.messages import field_specs
from llsrbm.request.tuning import Tuning
from llsrbm.robots.numbers_key import numbers_key
from llsrbm.robots.robot import Robot

Array = NDArray[np.float64]

SCHEMA = "llsrbm.learned/1"
# Of inverse distances, local regressions and radial basis functions the latter two lose equally few
# jumps that are in no table, and a regression takes 0.5 ms, not 12.
NEIGHBOURS = 16
WIDTH = 1.5
RIDGE = 1e-3  # of slopes, against neighbours that lie in a plane
# Beyond what neighbours agree by nothing is kept, which makes a file small: of a variable steps of
# this share of its largest value, of a multiplier the leading bits, and nothing of those of bounds
# that are not met.
VARIABLE_STEP = 2.0**-11
MULTIPLIER_BITS = 4
LEAST_MULTIPLIER = 2.0**-13

_log = logging.getLogger(__name__)


class Solved(NamedTuple):
    """A jump, and the solution of its whole-body problem."""

    jump: Jump
    solution: Iterate


@dataclass(frozen=True, eq=False)
class Learned:
    """Solutions of n jumps.

    Attributes:
        requests: (n, 4) rad and m, by `COMPONENTS`; scale: (4,) half of each range.
        variables: (n, V); multipliers: (n, R), of all rows.
    """

    requests: Array
    scale: Array
    variables: Array
    multipliers: Array

    @classmethod
    def of(cls, solved: Sequence[Solved], robot: Robot) -> Learned:
        """The table of some jumps."""
        ranges = np.array([getattr(robot.file.task, name) for name in COMPONENTS])
        return cls(
            requests=np.array([[getattr(each.jump, n) for n in COMPONENTS] for each in solved]),
            scale=np.ptp(ranges, axis=1) / 2,
            variables=np.array([each.solution.variables for each in solved]),
            multipliers=np.array([each.solution.multipliers for each in solved]),
        )

    def solved(self, robot: Robot) -> list[Solved]:
        """The jumps."""
        plain = Jump(robot=str(robot.path))
        return [
            Solved(
                replace(plain, **dict(zip(COMPONENTS, request, strict=True))),
                Iterate(self.variables[number], self.multipliers[number]),
            )
            for number, request in enumerate(self.requests.tolist())
        ]

    @property
    def sizes(self) -> tuple[int, int]:
        """Numbers of variables and of rows."""
        return self.variables.shape[1], self.multipliers.shape[1]

    def guess(self, jump: Jump) -> Iterate:
        """Where a jump begins; see above."""
        near, share = self._shares(np.array([getattr(jump, name) for name in COMPONENTS]))
        return Iterate(share @ self.variables[near], share @ self.multipliers[near])

    def _shares(self, x: Array) -> tuple[NDArray[np.intp], Array]:
        """(K,) which solutions, and (K,) how much of each."""
        away = (self.requests - x) / self.scale
        distance = np.linalg.norm(away, axis=1)
        near = np.argsort(distance, kind="stable")[:NEIGHBOURS]
        furthest = max(float(distance[near[-1]]), np.finfo(float).tiny)
        weight = np.exp(-((WIDTH * distance[near] / furthest) ** 2))
        A = np.hstack([np.ones((len(near), 1)), away[near] / furthest])
        ridge = np.diag([0.0, *[RIDGE] * len(self.scale)])
        share: Array = np.linalg.solve((A.T * weight) @ A + ridge, A.T * weight)[0]
        return near, share


def fits(jump: Jump, tuning: Tuning) -> bool:
    """Whether a robot's table may have jumps like this one."""
    plain = Jump(robot=jump.robot)
    same = all(
        getattr(jump, name) == getattr(plain, name)
        for name in field_specs(Jump)
        if name not in COMPONENTS
    )
    return same and not tuning.weights and not tuning.limits


def table_for(jump: Jump, tuning: Tuning, robot: Robot, grid: Grid) -> Learned | None:
    """The table that may have jumps like this one, read when it is first wanted.

    A jump with stones begins from the same one without; where the feet land is in its own rows.
    """
    return _table(robot, grid) if fits(replace(jump, stones=()), tuning) else None


def _table(robot: Robot, grid: Grid) -> Learned | None:
    """The robot's, read when it is first wanted, and again when a file has changed."""
    there = [path for path in places(robot, grid) if path.exists()]
    return _first(tuple((path, path.stat().st_mtime_ns) for path in there), robot, grid)


@lru_cache(maxsize=4)
def _first(files: tuple[tuple[Path, int], ...], robot: Robot, grid: Grid) -> Learned | None:
    found = (read(path, robot, grid) for path, _ in files)
    return next((table for table in found if table is not None), None)


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
            "requests": table.requests,
            "scale": table.scale,
            "variables": (np.round(table.variables / step) * step).T.astype(np.float32),
            "multipliers": kept.T.astype(np.float32),
        },
    )


def read(path: Path, robot: Robot, grid: Grid) -> Learned | None:
    """Read a table; None: there is none, or it is of another type of jump.

    A warning says, once, where one is ignored: it is damaged, or of other numbers of the robot.
    """
    try:
        with np.load(path, allow_pickle=False) as file:
            meta = json.loads(str(file["meta"]))
            names = ("requests", "scale", "variables", "multipliers")
            requests, scale, *solved = (file[name].astype(np.float64) for name in names)
    except FileNotFoundError:
        return None
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
        _refuse(path, f"it is damaged ({type(error).__name__})")
        return None
    expected = _meta(robot, grid)
    if not isinstance(meta, dict) or meta.get("grid") != expected["grid"]:
        return None
    if meta != expected:
        _refuse(path, "it was learned with other numbers of the robot")
        return None
    variables, multipliers = (np.ascontiguousarray(each.T) for each in solved)
    if not len(requests) == len(variables) == len(multipliers) >= NEIGHBOURS:
        _refuse(path, f"it has {len(requests)} jumps, fewer than {NEIGHBOURS}")
        return None
    return Learned(requests, scale, variables, multipliers)


def _meta(robot: Robot, grid: Grid) -> dict[str, str]:
    """Plain data on which a table's solutions depend."""
    return {"schema": SCHEMA, "robot": numbers_key(robot), "grid": grid.name}


@lru_cache(maxsize=64)
def _refuse(path: Path, reason: str) -> None:
    _log.warning("%s, a table of solved jumps, is ignored: %s", path.name, reason)
