"""Tables of solutions: where a jump begins, if jumps around it were solved before.

A file a robot in `assets/guesses`, made by `python -m benchmarks.guess_tables` of a sweep's jumps;
none ships at present. It has their requests x (twist, forward, lateral, height), scaled to -1 ... 1
over what the robot's file allows, and of each the solver's variables and multipliers v. For a new
request x the nearest K give, by a linear regression that is weighted by nearness,

    v(x) = c0 + C (x_k - x)   with the least   sum_k exp(-(WIDTH d_k / d_K)^2) |v_k - v(x_k)|^2 ,

and c0 is where `Solver.follow` begins. Quaternions have no jumps of sign between neighbours: all of
them begin at 1, 0, 0, 0 and turn on without a break, past half a turn, too.

A table is for one robot, by its numbers, one model and layout, and jumps of one type, their whole
turns and hops included, with the robot's own weights and limits. Where it should fit and does not,
a warning says why, once, and jumps begin from the analytic guess.
"""

from __future__ import annotations

import json
import logging
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from llsrbm.cache import content_key
from llsrbm.files.npz import write_archive
from llsrbm.installed import assets_directory
from llsrbm.ocp.horizon import Iterate
from llsrbm.planning.problem.costs import default_weights
from llsrbm.planning.problem.placement import make_task
from llsrbm.planning.problem.task import Task
from llsrbm.planning.solve.formulation import Formulation
from llsrbm.request.jump import Jump
from llsrbm.request.jump_types import schedule_of
from llsrbm.robots import load_robot
from llsrbm.robots.robot import Robot

Array = NDArray[np.float64]

REQUEST = ("twist", "forward", "lateral", "height")
"""Fields of a `Jump` that differ among a table's solutions."""

SCHEMA = "llsrbm.guesses/3"
# Of a robot, on which its solutions depend.
NUMBERS = (
    *("limits", "reach", "timing", "foot", "task", "planning"),
    *("mass", "com", "inertia", "feet", "base_position", "hips", "mirrors", "joint_names"),
    *("armature", "joint_friction", "joint_damping"),
)
DIGITS = 6  # after the point, of a robot's numbers; computed ones differ from machine to machine

# Of inverse distances, local regressions and radial basis functions, on 60 to 80 jumps of ANYmal
# that are in no table, the latter two lose equally few, and a regression takes 0.5 ms, not 12.
NEIGHBOURS = 16
WIDTH = 1.5
# Of whole turns, in shares of half the ranges: from further off than this, 5 cm forward, it takes
# fewer iterations from the analytic guess.
TURNING_NEAR = 0.1
RIDGE = 1e-3  # of slopes, against neighbours that lie in a plane
# What 16 bits and their interpolation leave of a solution: a table whose first one violates rows or
# misses its cost by more is of another problem.
STALE_ROWS = 0.05
STALE_TURNING = 0.2  # likewise of whole turns, whose momentum is corrected by the rounded solution
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
        kind: fields of a `Jump` that all have in common and that are not its defaults.
    """

    requests: Array
    scale: Array
    variables: NDArray[np.floating[Any]]
    multipliers: NDArray[np.floating[Any]]
    rows: NDArray[np.int64]
    all_rows: int
    costs: Array
    kind: Mapping[str, Any]

    def has(self, jump: Jump) -> bool:
        """True if a jump differs from those in the table in its `REQUEST` alone."""
        plain = Jump(robot=jump.robot, model=jump.model, **self.kind)
        names = [name for name in plain.as_dict() if name not in REQUEST]
        return all(getattr(jump, name) == getattr(plain, name) for name in names)

    def request(self, number: int) -> dict[str, Any]:
        """That of a solution, by `REQUEST`."""
        return dict(zip(REQUEST, self.requests[number].tolist(), strict=True))

    def nearest(self, jump: Jump) -> int:
        """The number of the solution whose request is nearest."""
        return int(np.linalg.norm(self._away(jump), axis=1).argmin())

    def distance(self, jump: Jump, number: int) -> float:
        """From a solution's request to a jump's, in shares of half the ranges."""
        return float(np.linalg.norm(self._away(jump)[number]))

    def guess(self, jump: Jump, formulation: Formulation) -> Iterate:
        """Where to begin; see above."""
        near, share = self._shares(jump)
        w = formulation.layout.normalised(share @ self.variables[near])
        multipliers = np.zeros(self.all_rows)
        multipliers[self.rows] = share @ self.multipliers[near]
        return Iterate(w, multipliers)

    def solution(self, number: int) -> Iterate:
        """One of those in the table."""
        multipliers = np.zeros(self.all_rows)
        multipliers[self.rows] = self.multipliers[number]
        return Iterate(self.variables[number].astype(np.float64), multipliers)

    def _away(self, jump: Jump) -> Array:
        """(n, 4) requests less a jump's, scaled."""
        x = np.array([getattr(jump, name) for name in REQUEST])
        away: Array = (self.requests - x) / self.scale
        return away

    def _shares(self, jump: Jump) -> tuple[NDArray[np.intp], Array]:
        """(K,) which solutions, and (K,) how much of each."""
        away = self._away(jump)
        distance = np.linalg.norm(away, axis=1)
        near = np.argsort(distance, kind="stable")[:NEIGHBOURS]
        furthest = max(float(distance[near[-1]]), np.finfo(float).tiny)
        weight = np.exp(-((WIDTH * distance[near] / furthest) ** 2))
        A = np.hstack([np.ones((len(near), 1)), away[near] / furthest])
        ridge = np.diag([0.0, *[RIDGE] * len(self.scale)])
        share: Array = np.linalg.solve((A.T * weight) @ A + ridge, A.T * weight)[0]
        return near, share


class Guesses:
    """The table that lies there for a formulation, if there is one that fits; read when first used.

    Attributes:
        formulation: for which.
    """

    def __init__(self, formulation: Formulation) -> None:
        self.formulation = formulation

    def start(self, task: Task) -> tuple[Jump, Iterate] | None:
        """Where a task begins, and of which jump that is a solution; None: from elsewhere.

        Of whole turns the nearest solution, if it is near: between those there is too much to
        interpolate.
        """
        table, jump = self._table, task.jump
        if not _is_usual(task) or table is None or not table.has(jump):
            return None
        if not jump.turns:
            return jump, table.guess(jump, self.formulation)
        number = table.nearest(jump)
        if table.distance(jump, number) > TURNING_NEAR:
            return None
        return replace(jump, **table.request(number)), table.solution(number)

    @cached_property
    def _table(self) -> GuessTable | None:
        path = table_path(self.formulation)
        try:
            return read_table(path, self.formulation)
        except FileNotFoundError:
            return None
        except RefusedTable as refused:
            if (message := str(refused)) not in _refused:
                _refused.add(message)
                _log.warning("%s: jumps begin from the analytic guess", message)
            return None


_refused: set[str] = set()  # messages of this process, each given once


def table_path(formulation: Formulation) -> Path:
    """Where a table lies: the feet that stand are in its name, unless as in the default type."""
    robot, layout = formulation.robot, formulation.layout
    stands = schedule_of(Jump(robot=str(robot.path)), robot).stands
    plain = np.array_equal(layout.stands, stands) and not layout.clears
    name = robot.name if plain else f"{robot.name}-{layout.name}"
    return assets_directory() / "guesses" / f"{name}.npz"


def make_table(
    solved: Sequence[tuple[Jump, Iterate, float]], formulation: Formulation
) -> GuessTable:
    """A table of jumps, their solutions and their costs."""
    robot, first = formulation.robot, solved[0][0]
    ranges = np.array([getattr(robot.file.task, name) for name in REQUEST])
    problem = formulation.problem(make_task(first, robot))
    rows = np.flatnonzero(problem.lower < problem.upper)
    plain = Jump(robot=first.robot, model=first.model).as_dict()
    kind = {n: v for n, v in first.as_dict().items() if n not in REQUEST and v != plain[n]}
    return GuessTable(
        requests=np.array([[getattr(jump, n) for n in REQUEST] for jump, _, _ in solved]),
        scale=np.ptp(ranges, axis=1) / 2,
        variables=np.array([solution.variables for _, solution, _ in solved]),
        multipliers=np.array([solution.multipliers[rows] for _, solution, _ in solved]),
        rows=rows,
        all_rows=len(problem.lower),
        costs=np.array([cost for _, _, cost in solved]),
        kind=kind,
    )


def write_table(path: Path, table: GuessTable, formulation: Formulation) -> None:
    """Write a table's file.

    Raises:
        InputError: it cannot be written.
    """
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
            "meta": np.array(json.dumps(_of(formulation) | {"kind": table.kind})),
            "requests": table.requests,
            "costs": table.costs,
            "scale": table.scale,
            "rows": table.rows.astype(np.int32),
            "all_rows": np.array(table.all_rows),
            "variables": variables.T.astype(np.float16),
            "multipliers": kept.T.astype(np.float16),
        },
    )


def read_table(path: Path, formulation: Formulation) -> GuessTable | None:
    """Read a table; None if it is for another model, layout or solver, or for other drives.

    Raises:
        FileNotFoundError: there is none.
        RefusedTable: it should fit, but the robot or the problem has changed, or it is damaged.
    """
    robot = formulation.robot
    own = load_robot(str(robot.path))
    if formulation.layout.turns:
        own = own.turning
    if formulation.solver.name != "fatrop" or robot is not own:
        return None
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
            kind=meta.pop("kind", {}),
        )
    except FileNotFoundError:
        raise
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
        raise RefusedTable(path, f"it is damaged ({type(error).__name__})") from error
    expected = _of(formulation)
    if any(meta.get(name) != expected[name] for name in ("model", "layout")):
        return None
    for name, value in expected.items():
        if meta.get(name) != value:
            raise RefusedTable(path, f"built for {_NAMES[name]}")
    _check(path, table, formulation)
    return table


class RefusedTable(Exception):
    """A table that should fit, and why it is ignored."""

    def __init__(self, path: Path, reason: str) -> None:
        super().__init__(f"{path.name}, a table of guesses, is ignored: {reason}")


# Reasons against a table: its solutions depend on these.
_NAMES = {
    "schema": "another format",
    "robot": "other robot parameters",
    "sizes": "a problem of another size",
    "weights": "other default weights",
}


def _of(formulation: Formulation) -> dict[str, Any]:
    """Plain data on which a table's solutions depend."""
    return {
        "schema": SCHEMA,
        "robot": numbers_key(formulation.robot),
        "model": formulation.model.name,
        "layout": repr(formulation.layout),
        "sizes": list(formulation.solver.sizes),
        "weights": default_weights(),
    }


def numbers_key(robot: Robot) -> str:
    """A key of a robot's numbers, on which its solutions depend."""
    numbers = robot.parameters()
    numbers = _rounded({name: numbers[name] for name in NUMBERS})
    return content_key(json.dumps(numbers, sort_keys=True)).hex()


def _rounded(data: Any) -> Any:
    """Plain data, its numbers with `DIGITS` digits after the point."""
    if isinstance(data, dict):
        return {key: _rounded(value) for key, value in data.items()}
    if isinstance(data, list | tuple):
        return [_rounded(value) for value in data]
    return round(data, DIGITS) + 0.0 if isinstance(data, float) else data


def _check(path: Path, table: GuessTable, formulation: Formulation) -> None:
    """Compare the table's first solution with today's problem.

    A constraint or a cost may have changed since, which nothing that is compared above shows.

    Raises:
        RefusedTable: it is of another problem.
    """
    count = len(table.requests)
    variables, rows = formulation.solver.sizes
    shapes = table.variables.shape, table.multipliers.shape, table.all_rows
    fewest = 1 if {"pitch", "roll"} & table.kind.keys() else NEIGHBOURS  # see `Guesses.start`
    if shapes != ((count, variables), (count, len(table.rows)), rows) or count < fewest:
        raise RefusedTable(path, "it is damaged (sizes)")
    first, robot = table.solution(0), formulation.robot
    fields: dict[str, Any] = {**table.kind, **table.request(0)}
    jump = Jump(robot=str(robot.path), model=formulation.model.name, **fields)
    task = make_task(jump, robot)
    stale = STALE_ROWS
    if task.jump.turns:
        task, stale = formulation.with_bounds_of_start(task, first), STALE_TURNING
    problem = formulation.problem(task)
    w = first.variables
    cost = float(formulation.solver.function("nlp_f")(w, problem.parameters))
    if formulation.solver.miss(problem, w) > stale or abs(cost - table.costs[0]) > STALE_COST * abs(
        table.costs[0]
    ):
        raise RefusedTable(path, "its solutions are of another problem")


def _is_usual(task: Task) -> bool:
    """True if a task has its type's own weights and limits, and begins at rest."""
    tuned = task.tuning.weights or task.tuning.limits
    return not tuned and task.motion is None and task.correction is None
