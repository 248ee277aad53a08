"""From a request to a `Task`: checked, and placed in the world."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from llsrbm.errors import InputError
from llsrbm.planning.problem.clearance_profile import (
    CLEARANCE_PARAMETERS,
    check_footing,
    clearance_parameters,
)
from llsrbm.planning.problem.costs import COSTS, default_weights, weight_parameter
from llsrbm.planning.problem.layout import Layout
from llsrbm.planning.problem.limits import Limit, check_limits, limits_in, put_limits
from llsrbm.planning.problem.stage import Stage
from llsrbm.planning.problem.task import Footholds, Task, contact_points
from llsrbm.request.jump import Jump
from llsrbm.request.jump_types import JumpType, load_type
from llsrbm.request.obstacle import Obstacle
from llsrbm.request.tuning import Tuning
from llsrbm.robots.robot import Robot

Array = NDArray[np.float64]

CORRECTION = "correction"
"""The parameters that each interval has for itself, three of it."""

FASTEST = 1.5  # m/s at the start and at the end: a brisk walk of the largest robot


def limits_of(robot: Robot) -> dict[str, tuple[Limit, float]]:
    """Limit name -> the limit and the robot's own value; `lowest` and `highest` in its unit."""
    return limits_in(place_task(Jump(robot=robot.name), robot))


def make_task(
    jump: Jump,
    robot: Robot,
    weights: Mapping[str, float] | None = None,
    limits: Mapping[str, float] | None = None,
) -> Task:
    """Check the request and place it in the world.

    Raises:
        InputError: a value outside of the robot file's [task], a weight or a limit that is none, a
            jump type that is none or not for this robot.
    """
    asked = robot.file.task
    for name in ("twist", "forward", "lateral", "height"):
        low, high = getattr(asked, name)
        value = getattr(jump, name)
        if not low - 1e-4 <= value <= high + 1e-4:
            raise InputError(_out_of_range(robot.name, name, value, low, high))
    for name in ("speed", "end_speed"):
        value = getattr(jump, name)
        if not 0 <= value <= FASTEST:
            raise InputError(f"{name} {value:g} m/s is out of range; expected 0 to {FASTEST:g} m/s")
    kind = load_type(jump.type)
    for where, given in (
        (f"{robot.path}: planning: ", robot.file.planning),
        (f"jump type {jump.type}: weights: ", kind.weights),
        ("", weights or {}),
    ):
        for name, weight in given.items():
            if name not in default_weights():
                valid = ", ".join(default_weights())
                raise InputError(f"{where}unknown weight {name!r}; the weights are {valid}")
            if not (np.isfinite(weight) and weight >= 0):
                raise InputError(
                    f"{where}weight {name}: expected a number of at least 0, got {weight}"
                )
    own = place_task(replace(jump, twist=0.0, forward=0.0, lateral=0.0, height=0.0), robot)
    if kind.limits:
        check_limits(kind.limits, own, robot.name)
    if limits:
        check_limits(limits, own, robot.name)
    task = place_task(jump, robot, Tuning(weights or {}, limits or {}))
    check_footing(task)
    return task


def place_task(jump: Jump, robot: Robot, tuning: Tuning | None = None) -> Task:
    """Place the request in the world, whatever it asks; its numbers are not checked.

    Raises:
        InputError: a jump type that is none, or not for this robot.
    """
    tuning = tuning or Tuning()
    if jump.turns:
        robot = robot.turning
    kind = load_type(jump.type)
    schedule = kind.schedule(robot, jump)
    places = _places(jump, kind, robot, schedule.places)
    end = places[-1]
    c, s = np.cos(end.heading), np.sin(end.heading)
    Rz = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    turns = round((jump.roll + jump.pitch) / (2 * np.pi))
    half = end.heading / 2
    quat = np.array([np.cos(half), 0.0, 0.0, np.sin(half)])
    task = Task(
        jump=jump,
        schedule=schedule,
        mass=float(robot.mass),
        places=places,
        start_position=np.array(robot.com),
        goal_position=Rz @ robot.com + end.origin,
        start_quat=np.array([1.0, 0.0, 0.0, 0.0]),
        goal_quat=-quat if turns % 2 else quat,
        start_velocity=np.array([jump.speed, 0.0, 0.0]),
        goal_velocity=Rz @ [jump.end_speed, 0.0, 0.0],
        corners=np.array(robot.corners),
        limits=robot.file.limits,
        reach=robot.file.reach,
        timing=robot.file.timing,
        foot=robot.file.foot,
        robot=robot,
        weights=default_weights() | robot.file.planning | kind.weights | dict(tuning.weights),
        tuning=tuning,
        obstacle=_obstacle(kind, places[0]),
        clears=kind.clears,
    )
    return put_limits(put_limits(task, kind.limits), tuning.limits)


def _places(jump: Jump, kind: JumpType, robot: Robot, count: int) -> tuple[Footholds, ...]:
    """Where the feet stand after each displacement; each along the heading after the one before."""
    if kind.displacement and len(kind.displacement) != count:
        raise InputError(
            f'jump type "{kind.title}": {len(kind.displacement)} displacements for {count} '
            f"landings; expected {count}, or none"
        )
    yaw = _headings(robot)
    turning = robot.foot_coordinates > 3
    places = [_footholds(robot, np.array(robot.feet), yaw, 0.0, np.zeros(3))]
    heading, shift = 0.0, np.zeros(3)
    for k in range(count):
        own = kind.displacement[k] if kind.displacement else None

        def asked(name: str, own: object = own) -> float:
            value = getattr(own, name, None)
            return float(getattr(jump, name) if value is None else value)

        c, s = np.cos(heading), np.sin(heading)
        ahead, aside = asked("forward"), asked("lateral")
        shift = shift + np.array([c * ahead - s * aside, s * ahead + c * aside, asked("height")])
        heading += asked("twist")
        c, s = np.cos(heading), np.sin(heading)
        Rz = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        feet = robot.feet @ Rz.T + shift
        places.append(_footholds(robot, feet, yaw + heading * turning, heading, shift))
    return tuple(places)


def _obstacle(kind: JumpType, start: Footholds) -> Obstacle | None:
    """In the world, ahead of the foremost contact point at the start."""
    row = kind.obstacle
    if row is None:
        return None
    front = float(start.contacts[:, 0].max())
    return Obstacle(front + row.near, front + row.far, row.height)


def _footholds(robot: Robot, feet: Array, yaw: Array, heading: float, origin: Array) -> Footholds:
    contacts = contact_points(feet, yaw, np.array(robot.corners))
    return Footholds(feet, yaw, contacts, heading, origin)


def parameters(layout: Layout, task: Task) -> dict[str, Array]:
    """Name -> value of the solver's parameters (names and sizes: `parameter_sizes`)."""
    values = {
        "start_position": task.start_position,
        "start_quat": task.start_quat,
        "start_velocity": task.start_velocity,
        "goal_position": task.goal_position,
        "goal_quat": task.goal_quat,
        "goal_velocity": task.goal_velocity,
        "corners": task.corners[:, :2],
        "friction": np.array([task.limits.friction]),
        "torque_share": np.array([task.limits.torque_share]),
        "upright_axes": upright_axes(task.jump),
    }
    if task.clears:
        values |= clearance_parameters(task)
    if task.motion is not None:
        values["start_momentum"] = task.motion.momentum / task.mass
        values["start_feet"] = task.motion.feet
        values["start_feet_velocity"] = task.motion.feet_velocity
    for p in range(len(task.schedule)):
        stood = task.stood(p)
        local = (stood.feet, stood.contacts, stood.yaw, task.towards(p))
        values |= dict(zip(_local_names(p), local, strict=True))
    weights = {
        weight_parameter(cost): np.array([cost.share(task.jump) * task.weights[cost.name]])
        for cost in COSTS
    }
    correction = np.zeros((layout.total, 3)) if task.correction is None else task.correction
    last = {CORRECTION: correction / task.mass}
    return {name: np.ravel(value) for name, value in (values | weights | last).items()}


def parameter_sizes(layout: Layout) -> dict[str, int]:
    """Name -> number of scalars of the solver's parameters, in their order."""
    sizes = {
        "start_position": 3,
        "start_quat": 4,
        "start_velocity": 3,
        "goal_position": 3,
        "goal_quat": 4,
        "goal_velocity": 3,
        "corners": 2 * layout.corners,
        "friction": 1,
        "torque_share": 1,
        "upright_axes": 3,
    }
    if layout.clears:
        sizes |= CLEARANCE_PARAMETERS
    if layout.under_way:
        feet = layout.legs * layout.foot_coordinates
        sizes |= {"start_momentum": 3, "start_feet": feet, "start_feet_velocity": feet}
    for p in range(layout.phases):
        local = Stage.local_sizes(layout)
        sizes |= dict(zip(_local_names(p), local.values(), strict=True))
    weights = {weight_parameter(cost): 1 for cost in COSTS}
    return sizes | weights | {CORRECTION: 3 * layout.total}


def local_parameters(phase: int) -> tuple[str, ...]:
    """Names of a phase's own parameters, in the order of `Stage.local`."""
    return tuple(_local_names(phase))


def _local_names(phase: int) -> list[str]:
    return [f"phase{phase}_{name}" for name in ("feet", "contacts", "yaw", "towards")]


def upright_axes(jump: Jump) -> Array:
    """(3,) 1 for the body's axes about which a turn is not wanted, 0 for the others.

    Upright jumps turn about z alone. A flip turns about y (a barrel roll about x); about the axes
    square to it only as far as a twist asks, and then nothing is said about them.
    """
    if not jump.turns:
        return np.array([1.0, 1.0, 0.0])
    if jump.twist or (jump.roll and jump.pitch):
        return np.zeros(3)
    return np.array([0.0, 1.0, 1.0]) if jump.roll else np.array([1.0, 0.0, 1.0])


def _headings(robot: Robot) -> Array:
    """(L,) rad: where the feet look in the default posture."""
    if robot.foot_coordinates == 3:
        return np.zeros(len(robot.legs))
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, robot.posture)
    ahead = np.array([data.oMf[leg.foot_frame_id].rotation[:, 0] for leg in robot.legs])
    headings: Array = np.arctan2(ahead[:, 1], ahead[:, 0])
    return headings


def _out_of_range(robot: str, name: str, value: float, low: float, high: float) -> str:
    if name != "twist":
        return f"{name} {value:g} m is out of range; {robot} takes {low:g} to {high:g} m"
    low, high, value = (np.degrees(v) for v in (low, high, value))
    return f"twist {value:g} deg is out of range; {robot} takes {low:.0f} to {high:.0f} deg"
