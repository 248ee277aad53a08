"""The second stage as an optimal control problem, and the numbers of one plan."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from llsrbm.models.rigid_bodies import RigidBodies
from llsrbm.ocp.horizon import Horizon, Problem, Run
from llsrbm.planning.whole_body.grid import EQUALITIES, NODES, Grid, Knot, Sizes, parts, units
from llsrbm.planning.whole_body.stage import stage_expressions
from llsrbm.planning.whole_body.start import Start
from llsrbm.robots.robot import Robot

Array = NDArray[np.float64]

LOWER_FEET = (
    0.003  # m by which a foot in the air may be lower than planned: more meets the ground early
)
LOWER_CORNERS = 0.03  # m, a sole's corners, as soles may lean; near the ground half of its height


def make_horizon(robot: Robot, grid: Grid) -> Horizon:
    """The stages of a robot's plans on a grid."""
    bodies, sizes = RigidBodies(robot), Sizes.of(robot)
    own = sum(sizes.own.values())
    runs: list[Run] = []
    first = 0
    knots = grid.knots
    for k, knot in enumerate(knots):
        if k + 1 < len(knots) and knots[k + 1] == knot:
            continue
        places = tuple(slice(i * own, (i + 1) * own) for i in range(first, k + 1))
        runs.append(
            Run(
                family=knot,
                count=k + 1 - first,
                build=lambda knot=knot: stage_expressions(bodies, knot),  # type: ignore[misc]
                own=places,
            )
        )
        first = k + 1
    return Horizon(tuple(runs), own * len(knots))


def make_problem(robot: Robot, grid: Grid, start: Start) -> Problem:
    """A plan's numbers."""
    sizes = Sizes.of(robot)
    lower, upper = zip(*((low, high) for *_, low, high in rows(robot, grid, start)), strict=True)
    return Problem(_parameters(grid, sizes, start), np.concatenate(lower), np.concatenate(upper))


def unit_of_variables(grid: Grid, sizes: Sizes) -> Array:
    """(n,) what one of each variable is in SI units."""
    found = []
    for knot in grid.knots:
        found.append(units(sizes.state, 1.0))
        of_node = sizes.node(len(knot.standing))
        found += [units(of_node, sizes.unit_force)] * (0 if knot.last else len(NODES))
    return np.concatenate(found)


def rows(robot: Robot, grid: Grid, start: Start) -> Iterator[tuple[str, int, float, Array, Array]]:
    """The rows of g in their order: name, knot, instant (s), lower and upper bounds."""
    sizes = Sizes.of(robot)
    for k, knot in enumerate(grid.knots):
        time = float(start.time[2 * k])
        if not knot.last:
            yield "", k, time, *(np.zeros((2, sizes.states)))
        for name, size in sizes.rows(knot).items():
            yield name, k, time, *_bounds(name, size, robot, knot, start, 2 * k)
        if knot.last:
            break
        for name, share, size in sizes.interval_rows(knot):
            at = time + share * float(start.step[k])
            yield name, k, at, *_bounds(name, size, robot, knot, start, 2 * k + 1)


def _bounds(
    name: str, size: int, robot: Robot, knot: Knot, start: Start, half: int
) -> tuple[Array, Array]:
    """`half`: of the start's instants, the knot or the middle after it."""
    torque_share, speed_share, _ = start.limits
    if name in EQUALITIES:
        return np.zeros(size), np.zeros(size)
    if name == "stop":
        return robot.model.lowerPositionLimit[7:], robot.model.upperPositionLimit[7:]
    if name == "clearance":
        return np.concatenate(_lowest(robot, knot, start, half // 2)), np.full(size, np.inf)
    if name == "apart":
        return -start.apart.at_zero[half], np.full(size, np.inf)
    if name == "friction":
        return np.zeros(size), np.full(size, np.inf)
    most = {"speed": speed_share, "torque": torque_share, "drive": 1.0}[name]
    return np.full(size, -most), np.full(size, most)


def _lowest(robot: Robot, knot: Knot, start: Start, k: int) -> list[Array]:
    """Lowest heights, m, of each swinging foot and the corners of its sole."""
    found = []
    for leg in range(len(robot.legs)):
        if leg in knot.resting:
            continue
        height = start.place[::2, leg, 2]
        # How far it is above the lower of the places that it comes from and goes to.
        above = height[k] - min(height[0], height[-1])
        found.append(np.array([height[k] - LOWER_FEET]))
        if len(robot.corners) > 1:
            lean = min(LOWER_CORNERS, LOWER_FEET + max(above, 0.0) / 2)
            found.append(np.full(len(robot.corners), height[k] - lean))
    return found


def _parameters(grid: Grid, sizes: Sizes, start: Start) -> Array:
    values = np.zeros((len(grid.knots), sum(sizes.own.values())))
    own = parts(values, sizes.own)
    for name, state in start.state.items():
        own[name][:] = state
    for node in range(len(NODES)):
        for name, motion in (*start.motion.items(), ("force", start.force)):
            own[f"{name}_{node}"][:-1] = motion[:, node]
    own["step"][:-1, 0] = start.step
    own["limits"][:] = start.limits
    slope = start.apart.slope.reshape(len(start.time), -1)
    own["apart"][:] = slope[::2]
    own["apart_in_middle"][:-1] = slope[1::2]
    own["place"][:] = start.place[::2].reshape(len(values), -1)
    own["heading"][:] = start.heading.reshape(len(values), -1)
    return values.ravel()
