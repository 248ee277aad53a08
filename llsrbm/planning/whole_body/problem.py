"""The whole-body problem as an optimal control problem, and the numbers of one plan."""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import NDArray

from llsrbm.models.rigid_bodies import RigidBodies
from llsrbm.ocp.horizon import Horizon, Problem, Run
from llsrbm.planning.whole_body.bounds import RowBounds
from llsrbm.planning.whole_body.grid import Grid
from llsrbm.planning.whole_body.sizes import LIMITS, WEIGHTS, Sizes, parts
from llsrbm.planning.whole_body.stage import stage_expressions
from llsrbm.planning.whole_body.start import Start
from llsrbm.robots.robot import Robot

Array = NDArray[np.float64]

# Stages a run: longer ones would be evaluated together, operation by operation
# (`llsrbm.ocp.stage_functions`), which takes a minute more and a gigabyte to build.
LONGEST = 5


def make_horizon(robot: Robot, grid: Grid) -> Horizon:
    """The stages of a robot's plans on a grid."""
    bodies, sizes = RigidBodies(robot), Sizes.of(robot, len(grid.phases))
    own = sum(sizes.own.values())
    runs: list[Run] = []
    first = 0
    knots = grid.knots
    for k, knot in enumerate(knots):
        if k + 1 < len(knots) and knots[k + 1] == knot and k + 1 - first < LONGEST:
            continue
        places = tuple(slice(i * own, (i + 1) * own) for i in range(first, k + 1))
        build = partial(stage_expressions, bodies, knot, sizes)
        runs.append(Run(family=knot, count=k + 1 - first, build=build, own=places))
        first = k + 1
    return Horizon(tuple(runs), own * len(knots))


def make_problem(rows: RowBounds) -> Problem:
    """A plan's numbers."""
    lower, upper = zip(*((low, high) for *_, low, high in rows), strict=True)
    parameters = _parameters(rows.grid, rows.sizes, rows.start)
    return Problem(parameters, np.concatenate(lower), np.concatenate(upper))


def _parameters(grid: Grid, sizes: Sizes, start: Start) -> Array:
    values = np.zeros((len(grid.knots), sum(sizes.own.values())))
    own = parts(values, sizes.own)
    for name, state in start.state.items():
        own[name][:] = state
    own["step"][:-1, 0] = np.diff(grid.shares[::2])
    own["phase"][np.arange(grid.intervals), grid.phase] = 1.0
    own["weights"][:] = [start.weights[name] for name in WEIGHTS]
    own["limits"][:] = [getattr(start.task.limits, name) for name in LIMITS]
    slope = start.apart.slope.reshape(len(start.time), -1)
    own["apart"][:] = slope[::2]
    own["apart_in_middle"][:-1] = slope[1::2]
    own["place"][:] = start.place[::2].reshape(len(values), -1)
    own["heading"][:] = start.heading.reshape(len(values), -1)
    for k, phase in enumerate(grid.phase):
        own["towards"][k] = start.task.towards(int(phase)).ravel()
    return values.ravel()
