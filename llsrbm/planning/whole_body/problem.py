"""The whole-body problem as an optimal control problem, and the numbers of one plan."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from itertools import groupby
from operator import itemgetter

import numpy as np
from numpy.typing import NDArray

from llsrbm.body.rolling import rolled
from llsrbm.ocp.horizon import Horizon, Problem, Run
from llsrbm.planning.whole_body.bounds import RowBounds
from llsrbm.planning.whole_body.grid import Grid
from llsrbm.planning.whole_body.sizes import LIMITS, WEIGHTS, Sizes, parts, robot_numbers
from llsrbm.planning.whole_body.stage import composed_stage
from llsrbm.planning.whole_body.start import LANDED
from llsrbm.request.jump import COMPONENTS
from llsrbm.request.schedule import Schedule
from llsrbm.request.slopes import normals
from llsrbm.robots.robot import Robot

Array = NDArray[np.float64]


HEIGHT = COMPONENTS.index("height")


def make_horizon(sizes: Sizes, grid: Grid) -> Horizon:
    """The stages of plans on a grid, of all robots of these sizes."""
    own, every = sum(sizes.own.values()), sum(sizes.robot.values())
    runs: list[Run] = []
    for knot, alike in groupby(enumerate(grid.knots), key=itemgetter(1)):
        stages = [k for k, _ in alike]
        places = tuple(slice(every + k * own, every + (k + 1) * own) for k in stages)
        build = partial(composed_stage, knot, sizes)
        shared = (slice(0, every),)
        runs.append(Run(family=knot, count=len(stages), build=build, local=shared, own=places))
    return Horizon(tuple(runs), every + own * len(grid.knots))


def make_problem(rows: RowBounds) -> Problem:
    """A plan's numbers."""
    lower, upper = zip(*((low, high) for *_, low, high in rows), strict=True)
    own = _parameters(rows)
    parameters = np.concatenate([robot_numbers(rows.robot), own])
    return Problem(parameters, np.concatenate(lower), np.concatenate(upper))


def _parameters(rows: RowBounds) -> Array:
    grid, sizes, start = rows.grid, rows.sizes, rows.start
    values = np.zeros((len(grid.knots), sum(sizes.own.values())))
    own = parts(values, sizes.own)
    for name, state in start.state.items():
        own[name][:] = state
    own["step"][:-1, 0] = np.diff(grid.shares[::2])
    own["phase"][np.arange(grid.intervals), grid.phase] = 1.0
    own["weights"][:] = [start.weights[name] for name in WEIGHTS]
    for name, factor in LANDED.items():
        own["weights"][grid.landed[::2], list(WEIGHTS).index(name)] *= factor
    own["limits"][:] = [getattr(start.task.limits, name) for name in LIMITS]
    slope = start.apart.slope.reshape(len(start.time), -1)
    own["apart"][:] = slope[::2]
    own["apart_in_middle"][:-1] = slope[1::2]
    place = start.place[::2].copy()
    away = start.rolled
    if away is None:
        away = rolled_by(rows.robot, grid, start.task.schedule, start.state)
    place[..., :2] += away
    place[..., 2] += (start.tilt * away).sum(axis=-1)
    own["place"][:] = place.reshape(len(values), -1)
    own["tilt"][:] = start.tilt.reshape(len(values), -1)
    own["normal"][:] = normals(start.tilt).reshape(len(values), -1)
    own["level"][:] = start.level
    own["heading"][:] = start.heading.reshape(len(values), -1)
    for k, phase in enumerate(grid.phase):
        own["towards"][k] = start.task.towards(int(phase)).ravel()
    _offset(rows, own)
    return values.ravel()


def _offset(rows: RowBounds, own: dict[str, Array]) -> None:
    """Write an offset of the landing and all that goes with it; nothing where none is wanted."""
    grid, start, task = rows.grid, rows.start, rows.start.task
    if not start.price:
        return
    last, ranges = task.places[-1], rows.robot.file.task
    own["free"][:], own["wanted"][:] = start.wanted != 0, start.wanted
    own["price"][:] = start.price / np.array(
        [np.ptp(getattr(ranges, n)) or 1.0 for n in COMPONENTS]
    )
    own["pivot"][:] = last.origin
    # On the way down feet keep beyond an edge that is as far from where they land.
    own["edges"][:] = task.jump.height < 0 or start.wanted[HEIGHT] < 0
    for k, knot in enumerate(grid.knots):
        there = task.footholds_before(grid.phase_at(2 * k)).feet == last.feet
        rests = list(knot.resting)
        own["moves"][k, rests] = there.all(axis=1)[rests]
    rises = rows.rises().reshape(len(grid.knots), 2, -1)
    own["rises"][:], own["rises_in_middle"][:] = np.swapaxes(rises, 0, 1)


def rolled_by(robot: Robot, grid: Grid, schedule: Schedule, state: Mapping[str, Array]) -> Array:
    """(N + 1, L, 2) m: how far standing feet's frames have rolled from where they stand at rest, in
    a motion of these states; zeros of feet in the air.
    """
    phase = np.append(grid.phase, len(grid.phases) - 1)
    rests = np.zeros((len(grid.knots), len(robot.legs), 1))
    for k, knot in enumerate(grid.knots):
        rests[k, list(knot.resting)] = 1.0
    pose = state["joint_position"], state["quat"]
    away = rolled(robot, *pose, schedule, phase, frames=True)
    return rests * away
