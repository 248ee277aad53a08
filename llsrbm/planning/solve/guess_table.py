"""Solutions that are at hand: what a jump begins from, where jumps around it were solved before.

A file a robot ships in `assets/guesses`, made by `python -m benchmarks.guess_tables` of a sweep's
jumps. It has their requests x (twist, forward, lateral, height), scaled to -1 ... 1 over what the
robot's file allows, and of each the solver's variables and multipliers v. Of a new request x the
nearest K give, by a linear regression that is weighted by nearness,

    v(x) = c0 + C (x_k - x)   with the least   sum_k exp(-(WIDTH d_k / d_K)^2) |v_k - v(x_k)|^2 ,

and c0 is where `Solver.follow` begins. Quaternions have no jumps of sign between neighbours: all of
them begin at 1, 0, 0, 0 and turn on without a break, past half a turn, too.

A table is for one robot as its file is, one model, jumps of the type `together` with the robot's
own weights and limits, and one version. It is refused without a word elsewhere: then a jump begins
from the analytic guess.
"""

from __future__ import annotations

import json
import logging
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from llsrbm.cache import content_key
from llsrbm.installed import assets_directory, package_version
from llsrbm.ocp.problem import Iterate
from llsrbm.planning.problem.costs import default_weights
from llsrbm.planning.problem.placement import make_task
from llsrbm.planning.problem.task import Task
from llsrbm.planning.solve.formulation import Formulation
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot
from llsrbm.robots.robot import Robot

Array = NDArray[np.float64]

REQUEST = ("twist", "forward", "lateral", "height")
"""Fields of a `Jump` by which solutions are told apart."""

SCHEMA = "llsrbm.guesses/1"

# Of inverse distances, local regressions and radial basis functions, on 60 to 80 jumps of ANYmal
# that are in no table, the latter two lose equally few, and a regression takes 0.5 ms, not 12.
NEIGHBOURS = 16
WIDTH = 1.5
RIDGE = 1e-3  # of slopes, against neighbours that lie in a plane
# What 16 bits and their interpolation leave of a solution: a table whose first one violates rows or
# misses its cost by more is of another problem.
STALE_ROWS = 0.05
STALE_COST = 0.02
# Beyond what neighbours agree by nothing is kept, which makes a file small: of a variable steps of
# this share of its largest value, of a multiplier the leading bits, and nothing of those of bounds
# that are not met.
VARIABLE_STEP = 2.0**-11
MULTIPLIER_BITS = 4
LEAST_MULTIPLIER = 2.0**-13

_log = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class GuessTable:
    """Solutions of n jumps.

    Attributes:
        requests: (n, 4) rad and m, by `REQUEST`; scale: (4,) half of each range.
        variables: (n, V); multipliers: (n, R) of the rows numbered `rows` (R,), those that are
            inequalities; solvers find the others themselves.
        all_rows: their number.
        costs: (n,).
    """

    requests: Array
    scale: Array
    variables: NDArray[np.floating[Any]]
    multipliers: NDArray[np.floating[Any]]
    rows: NDArray[np.int64]
    all_rows: int
    costs: Array

    def guess(self, jump: Jump, formulation: Formulation) -> Iterate:
        """Where to begin; see above."""
        x = np.array([getattr(jump, name) for name in REQUEST])
        near, share = self._shares(x)
        w = formulation.layout.normalised(share @ self.variables[near])
        multipliers = np.zeros(self.all_rows)
        multipliers[self.rows] = share @ self.multipliers[near]
        return Iterate(w, multipliers)

    def solution(self, number: int) -> Iterate:
        """One of those in the table."""
        multipliers = np.zeros(self.all_rows)
        multipliers[self.rows] = self.multipliers[number]
        return Iterate(self.variables[number].astype(np.float64), multipliers)

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


class Guesses:
    """The table that ships for a formulation, if there is one that fits; read when first used.

    Attributes:
        formulation: for which.
    """

    def __init__(self, formulation: Formulation) -> None:
        self.formulation = formulation

    def start(self, task: Task) -> Iterate | None:
        """Where a task begins; None: from elsewhere."""
        if not _is_usual(task) or self._table is None:
            return None
        return self._table.guess(task.jump, self.formulation)

    @cached_property
    def _table(self) -> GuessTable | None:
        path = table_path(self.formulation.robot.name)
        try:
            table = read_table(path, self.formulation)
        except FileNotFoundError:
            return None
        except _Refused as refused:
            _log.info("%s is not used: %s", path.name, refused)
            return None
        return table


def table_path(robot: str) -> Path:
    """Where a robot's table lies."""
    return assets_directory() / "guesses" / f"{robot}.npz"


def make_table(
    solved: Sequence[tuple[Jump, Iterate, float]], formulation: Formulation
) -> GuessTable:
    """A table of jumps, their solutions and their costs."""
    robot = formulation.robot
    ranges = np.array([getattr(robot.file.task, name) for name in REQUEST])
    problem = formulation.problem(make_task(solved[0][0], robot))
    rows = np.flatnonzero(problem.lower < problem.upper)
    return GuessTable(
        requests=np.array([[getattr(jump, n) for n in REQUEST] for jump, _, _ in solved]),
        scale=np.ptp(ranges, axis=1) / 2,
        variables=np.array([solution.variables for _, solution, _ in solved]),
        multipliers=np.array([solution.multipliers[rows] for _, solution, _ in solved]),
        rows=rows,
        all_rows=len(problem.lower),
        costs=np.array([cost for _, _, cost in solved]),
    )


def write_table(path: Path, table: GuessTable, formulation: Formulation) -> None:
    """Write a table's file.

    Raises:
        InputError: it cannot be written.
    """
    from llsrbm.files.npz import write_archive

    largest = np.abs(table.variables).max(axis=0)
    step = 2.0 ** np.ceil(np.log2(np.maximum(largest, np.finfo(np.float16).tiny))) * VARIABLE_STEP
    variables = np.round(table.variables / step) * step
    mantissa, exponent = np.frexp(table.multipliers)
    steps = 2.0**MULTIPLIER_BITS
    kept = np.ldexp(np.round(mantissa * steps) / steps, exponent)
    kept[np.abs(kept) < LEAST_MULTIPLIER] = 0.0
    # What is alike lies together: by variables, not by jumps.
    write_archive(
        path,
        {
            "meta": np.array(json.dumps(_of(formulation))),
            "requests": table.requests,
            "costs": table.costs,
            "scale": table.scale,
            "rows": table.rows.astype(np.int32),
            "all_rows": np.array(table.all_rows),
            "variables": variables.T.astype(np.float16),
            "multipliers": kept.T.astype(np.float16),
        },
    )


def read_table(path: Path, formulation: Formulation) -> GuessTable:
    """Read a table that is for this formulation.

    Raises:
        FileNotFoundError: there is none.
        _Refused: it is of another robot, model, layout or version, or damaged.
    """
    if formulation.solver.name != "fatrop":
        raise _Refused(f"{formulation.solver.name} takes none")
    if not _is_as_its_file(formulation.robot):
        raise _Refused("the robot is not as its file says")
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = dict(file)
        meta = json.loads(str(arrays["meta"]))
        table = GuessTable(
            requests=arrays["requests"],
            scale=arrays["scale"],
            variables=np.ascontiguousarray(arrays["variables"].T, dtype=np.float32),
            multipliers=np.ascontiguousarray(arrays["multipliers"].T, dtype=np.float32),
            rows=arrays["rows"].astype(np.int64),
            all_rows=int(arrays["all_rows"]),
            costs=arrays["costs"],
        )
    except FileNotFoundError:
        raise
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
        raise _Refused(f"damaged ({type(error).__name__})") from error
    expected = _of(formulation)
    for name, value in expected.items():
        if meta.get(name) != value:
            raise _Refused(f"the {name.replace('_', ' ')} differs")
    _check(table, formulation)
    return table


class _Refused(Exception):
    """Why a table is not used."""


def _of(formulation: Formulation) -> dict[str, Any]:
    """What a table's solutions depend on, as plain data."""
    robot = formulation.robot
    return {
        "schema": SCHEMA,
        "version": package_version(),
        "robot": content_key(robot.path, robot.urdf_path).hex(),
        "model": formulation.model.name,
        "layout": repr(formulation.layout),
        "sizes": list(formulation.solver.sizes),
        "weights": default_weights(),
    }


def _check(table: GuessTable, formulation: Formulation) -> None:
    """Whether the table's first solution is one of today's problem.

    A constraint or a cost may have changed since, and nothing of what is compared says so.
    """
    count = len(table.requests)
    variables, rows = formulation.solver.sizes
    shapes = table.variables.shape, table.multipliers.shape, table.all_rows
    if shapes != ((count, variables), (count, len(table.rows)), rows) or count < NEIGHBOURS:
        raise _Refused("damaged (sizes)")
    request = dict(zip(REQUEST, table.requests[0].tolist(), strict=True))
    jump = Jump(robot=str(formulation.robot.path), model=formulation.model.name, **request)
    problem = formulation.problem(make_task(jump, formulation.robot))
    w = table.solution(0).variables
    cost = float(formulation.solver.function("nlp_f")(w, problem.parameters))
    if formulation.solver.miss(problem, w) > STALE_ROWS or abs(
        cost - table.costs[0]
    ) > STALE_COST * abs(table.costs[0]):
        raise _Refused("its solutions are of another problem")


def _is_as_its_file(robot: Robot) -> bool:
    """Not one with other drives, or one that was read before its file changed."""
    return robot is load_robot(str(robot.path))


def _is_usual(task: Task) -> bool:
    """Whether a task asks for nothing that a table's jumps do not."""
    jump = task.jump
    plain = Jump(robot=jump.robot, model=jump.model)
    same = all(getattr(jump, n) == v for n, v in plain.as_dict().items() if n not in REQUEST)
    tuned = task.tuning.weights or task.tuning.limits
    return same and not tuned and task.motion is None and task.correction is None
