"""Parameters of the solver: their names, sizes and places, and a task's values."""

import casadi as ca
import numpy as np

from llsrbm.arrays import Array
from llsrbm.planning.problem.clearance_profile import CLEARANCE_PARAMETERS, clearance_parameters
from llsrbm.planning.problem.costs import COSTS, weight_parameter
from llsrbm.planning.problem.layout import Layout
from llsrbm.planning.problem.shortfall import (
    shortfall_parameters,
    shortfall_sizes,
    swing_numbers,
)
from llsrbm.planning.problem.stage_body import StageBody
from llsrbm.planning.problem.task import Task
from llsrbm.request.jump import Jump

OWN = "own"
"""The parameters that each interval has for itself, `Layout.own_numbers` of it."""


def parameters(layout: Layout, task: Task, *, at_knots: bool = False) -> dict[str, Array]:
    """Name -> value of the solver's parameters (names and sizes: `parameter_sizes`).

    `at_knots`: with feet where they have rolled to at the knots, not over the intervals.
    """
    # Rows are of the file's drives; those of the torque at speed are `battery` times as large.
    torque_share = task.limits.torque_share * task.drive_strength / task.battery
    values = {
        "start_position": task.start_position,
        "start_quat": task.start_quat,
        "start_velocity": task.start_velocity,
        "goal_position": task.goal_position,
        "goal_quat": task.goal_quat,
        "goal_velocity": task.goal_velocity,
        "corners": task.corners[:, :2],
        "friction": np.array([task.limits.friction]),
        "torque_share": np.array([torque_share]),
        "upright_axes": upright_axes(task.jump),
    }
    if layout.arm_joints:
        values |= start_arms(task)
    if task.clears:
        values |= clearance_parameters(task)
    if task.motion is not None:
        values["start_momentum"] = task.motion.momentum / task.mass
        values["start_feet"] = task.motion.feet
        values["start_feet_velocity"] = task.motion.feet_velocity
    for p in range(len(task.schedule)):
        stood = task.footholds_before(p)
        local = (stood.feet, stood.contacts, stood.yaw, task.towards(p), stood.tilt)
        values |= dict(zip(_local_names(p), local, strict=True))
    weights = {
        weight_parameter(cost): np.array([cost.share(task.jump) * task.weights[cost.name]])
        for cost in COSTS
    }
    correction = np.zeros((layout.total, 3)) if task.correction is None else task.correction
    own = [correction / task.mass]
    if layout.turns:
        own.append(_rolled(layout, task, at_knots=at_knots).reshape(layout.total, -1))
    if layout.gives:
        values |= shortfall_parameters(layout, task)
        own.append(swing_numbers(layout, task))
    last = {OWN: np.hstack(own)}
    return {name: np.ravel(value) for name, value in (values | weights | last).items()}


def _rolled(layout: Layout, task: Task, *, at_knots: bool) -> Array:
    """(N, L, 2) m: how far feet have rolled at the knots, or in the middle of the intervals.

    Where feet leave or land their place at the knot counts.
    """
    if task.rolled is None:
        return np.zeros((layout.total, layout.legs, 2))
    begins, ends = task.rolled[:-1], task.rolled[1:]
    given = [at_knots or bool(role.leaving or role.landing) for role in layout.roles[:-1]]
    return np.where(np.array(given)[:, None, None], begins, (begins + ends) / 2)


def start_arms(task: Task) -> dict[str, Array]:
    """Where free arms begin, how they move there, and where they end."""
    angles = task.robot.arm_angles
    moves = (angles, np.zeros_like(angles)) if task.motion is None else task.motion.arms
    return {"start_arms": moves[0], "start_arms_velocity": moves[1], "goal_arms": angles}


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
    if layout.arm_joints:
        arms = layout.arm_joints
        sizes |= {"start_arms": arms, "start_arms_velocity": arms, "goal_arms": arms}
    if layout.clears:
        sizes |= CLEARANCE_PARAMETERS
    if layout.under_way:
        feet = layout.legs * layout.foot_coordinates
        sizes |= {"start_momentum": 3, "start_feet": feet, "start_feet_velocity": feet}
    for p in range(layout.phases):
        local = StageBody.local_sizes(layout)
        sizes |= dict(zip(_local_names(p), local.values(), strict=True))
    if layout.gives:
        sizes |= shortfall_sizes(layout)
    weights = {weight_parameter(cost): 1 for cost in COSTS}
    return sizes | weights | {OWN: layout.own_numbers * layout.total}


def local_parameters(phase: int) -> tuple[str, ...]:
    """Names of a phase's own parameters, in the order of `Stage.local`."""
    return tuple(_local_names(phase))


def _local_names(phase: int) -> list[str]:
    return [f"phase{phase}_{name}" for name in ("feet", "contacts", "yaw", "towards", "tilt")]


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


def parameter_symbols(layout: Layout) -> dict[str, ca.SX]:
    """Name -> symbols of the solver's parameters, in their order."""
    return {name: ca.SX.sym(name, size) for name, size in parameter_sizes(layout).items()}


def parameter_places(layout: Layout) -> dict[str, slice]:
    """Name -> place in the vector of all parameters."""
    sizes = parameter_sizes(layout)
    ends = np.cumsum(list(sizes.values())).tolist()
    return {n: slice(end - size, end) for (n, size), end in zip(sizes.items(), ends, strict=True)}
