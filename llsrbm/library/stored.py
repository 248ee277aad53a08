"""A whole body's plan as few numbers in float32, and the plan that they give again.

What is kept of N intervals is what the whole-body problem decides: states at the knots,
accelerations and forces at the two nodes of each interval (`llsrbm.planning.whole_body`), and the
phases' durations. All else of a `Plan` follows from these, its request and the robot.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from llsrbm.body.momentum import base_velocities
from llsrbm.errors import FileFormatError, InputError
from llsrbm.library.card import Card
from llsrbm.mechanics import apply, rotation_matrices
from llsrbm.motion.plan import Plan
from llsrbm.motion.robot import robot_of
from llsrbm.planning.problem.placement import make_task
from llsrbm.planning.whole_body.grid import Grid
from llsrbm.planning.whole_body.motion import Motion
from llsrbm.planning.whole_body.result import Feet, plan_of
from llsrbm.planning.whole_body.sizes import NODES, Sizes
from llsrbm.planning.whole_body.start import footholds, tilts
from llsrbm.planning.whole_body.unplanned import unplanned
from llsrbm.request.schedule import Schedule
from llsrbm.robots.robot import Robot

Array = NDArray[np.float64]
Stored = NDArray[np.float32]


def motion_of(plan: Plan, robot: Robot, grid: Grid) -> Motion:
    """The whole-body problem's motion of a refined plan, which has it at its knots.

    Accelerations are straight lines over an interval, so that the change of a velocity over each
    half of it is the acceleration in that half's middle, its node.
    """
    assert plan.joint_velocity is not None  # a refined plan has it
    order = [plan.joint_names.index(name) for name in robot.joint_names]
    R_base_world = np.swapaxes(rotation_matrices(plan.base_quat), -1, -2)
    joints, joint_speed = plan.joint_position[:, order], plan.joint_velocity[:, order]
    omega = apply(R_base_world, plan.angular_velocity)
    base = plan.base_position, plan.base_quat, omega
    velocity = base_velocities(robot, plan.com_velocity, *base, joints, joint_speed)
    halves, count = np.diff(plan.time)[:, None], grid.intervals

    def rates(values: Array) -> Array:
        return (np.diff(values, axis=0) / halves).reshape(count, len(NODES), -1)

    return Motion(
        time=plan.time[::2],
        state={
            "position": plan.base_position[::2],
            "quat": plan.base_quat[::2],
            "joint_position": joints[::2],
            "velocity": velocity[::2],
            "omega": omega[::2],
            "joint_velocity": joint_speed[::2],
            "durations": np.tile(np.diff(plan.phase_start), (count + 1, 1)),
        },
        rates={
            "acceleration": rates(velocity),
            "omega_rate": rates(omega),
            "joint_acceleration": rates(joint_speed),
        },
        force=plan.contact_force[:-1].reshape(count, len(NODES), -1, 3),
    )


def stored(plan: Plan, robot: Robot | None = None) -> tuple[Grid, Stored]:
    """The grid that a plan is of, and its motion as one row of numbers.

    Raises:
        InputError: it is no whole body's plan.
    """
    if not plan.refined:
        raise InputError(
            "the plan is a draft; expected one of the whole body, as `llsrbm plan` makes without "
            "--draft"
        )
    robot = robot or robot_of(plan)
    grid = Grid.under(plan)
    return grid, row_of(motion_of(plan, robot, grid), plan.foot_quat, robot, grid)


def row_of(motion: Motion, foot_quat: Array, robot: Robot, grid: Grid) -> Stored:
    """A motion as one row of numbers; `foot_quat`: (2 N + 1, L, 4), of which soles' count."""
    rows = [
        motion.durations,
        *(values for name, values in motion.state.items() if name != "durations"),
        *motion.rates.values(),
        motion.force[_standing(grid, len(robot.legs), motion.force.shape[2])],
    ]
    if not robot.file.foot.is_point:
        rows.append(foot_quat)
    return np.concatenate([np.ravel(values) for values in rows]).astype(np.float32)


def _standing(grid: Grid, legs: int, contacts: int) -> NDArray[np.bool_]:
    """(N, nodes, C) contact points of the legs that stand."""
    found = np.zeros((grid.intervals, len(NODES), legs, contacts // legs), dtype=bool)
    for k, knot in enumerate(grid.knots[:-1]):
        found[k, :, list(knot.standing)] = True
    return found.reshape(grid.intervals, len(NODES), contacts)


class _Numbers:
    """Numbers that are taken from a row one after the other."""

    def __init__(self, row: Stored, where: str) -> None:
        self._row, self._where, self._next = row.astype(np.float64), where, 0

    def take(self, *shape: int) -> Array:
        """The next ones. Raises `FileFormatError`: there are too few."""
        count = int(np.prod(shape))
        found = self._row[self._next : self._next + count]
        if len(found) < count:
            raise self.wrong(f"expected {count} numbers more, got {len(found)}")
        self._next += count
        return found.reshape(shape)

    def end(self) -> None:
        """Raise `FileFormatError` if some are left."""
        if left := len(self._row) - self._next:
            raise self.wrong(f"{left} numbers are left over")

    def wrong(self, why: str) -> FileFormatError:
        """That the row does not fit robot and request."""
        return FileFormatError(
            f"{self._where}: {why}; expected the motion of this robot and request; the library was "
            "made with another robot file, or it is damaged"
        )


def reopened(card: Card, numbers: Stored, robot: Robot, where: str) -> Plan:
    """The plan of which `stored` gave these numbers, with the certificate that its card states.

    `where`: the file and the name, for messages.

    Raises:
        FileFormatError: the numbers are those of another robot or request.
    """
    taken = _Numbers(numbers, where)
    task = make_task(card.request, robot, card.tuning.weights, card.limits)
    grid = _grid(task.schedule, card, taken)
    sizes = Sizes.of(robot, len(grid.phases))
    count, contacts = grid.intervals, sizes.legs * sizes.corners
    durations = taken.take(len(grid.phases))
    state = {name: taken.take(count + 1, size) for name, size in sizes.moving.items()}
    rates = {name: taken.take(count, len(NODES), size) for name, size in sizes.motion.items()}
    force = np.zeros((count, len(NODES), contacts, 3))
    on = _standing(grid, sizes.legs, contacts)
    force[on] = taken.take(int(on.sum()), 3)
    place, quat = footholds(task, grid)
    if not robot.file.foot.is_point:
        quat = taken.take(2 * count + 1, sizes.legs, 4)
    taken.end()
    if not (durations > 0).all():
        raise taken.wrong("a phase takes no time")
    edges = np.concatenate([[0.0], np.cumsum(durations)])
    motion = Motion(
        time=grid.times(edges)[::2],
        state=state | {"durations": np.tile(durations, (count + 1, 1))},
        rates=rates,
        force=force,
    )
    bare = replace(
        unplanned(task, robot, card.report.solver),
        tuning=card.tuning,
        limits=card.limits,
        report=card.report,
        refinement=card.refinement,
    )
    plan = plan_of(motion, Feet(place, quat, tilts(task, grid)), bare, robot, grid)
    return replace(plan, certificate=card.certificate)


def _grid(schedule: Schedule, card: Card, taken: _Numbers) -> Grid:
    stands = [tuple(np.flatnonzero(legs).tolist()) for legs in schedule.stands]
    if len(stands) != len(card.intervals):
        raise taken.wrong(f"it has {len(card.intervals)} phases, the schedule {len(stands)}")
    return Grid(tuple(zip(stands, card.intervals, strict=True)), card.denser_in_flight)
