"""The request in numbers: where everything starts and ends, and the limits that hold between."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from llsrbm.errors import InputError
from llsrbm.jump import Jump
from llsrbm.planning.costs import COSTS, default_weights, weight_parameter
from llsrbm.robots.knee import knee_links
from llsrbm.robots.robot import Robot
from llsrbm.robots.schema import Limits, Reach, Timing

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Task:
    """What the planner solves.

    Attributes:
        jump: the request.
        mass: kg.
        start_position, goal_position: (3,) m, CoM.
        goal_quat: (4,) w, x, y, z, continuous in the twist (w < 0 beyond 180 degrees).
        start_feet, goal_feet: (L, 3) m.
        limits, reach, timing: of the robot file.
        knee: thigh and shank, m, of legs that fold at a knee.
        weights: cost name -> weight.
    """

    jump: Jump
    mass: float
    start_position: Array
    goal_position: Array
    goal_quat: Array
    start_feet: Array
    goal_feet: Array
    limits: Limits
    reach: Reach
    timing: Timing
    knee: tuple[float, float] | None
    weights: dict[str, float]

    def parameters(self) -> dict[str, Array]:
        """Name -> value of the solver's parameters (names and sizes: `parameter_sizes`)."""
        thigh, shank = self.knee or (1.0, 1.0)
        values = {
            "start_position": self.start_position,
            "goal_position": self.goal_position,
            "goal_quat": self.goal_quat,
            "start_feet": self.start_feet,
            "goal_feet": self.goal_feet,
            "friction": np.array([self.limits.friction]),
            "joint_speed": np.array([self.limits.joint_speed]),
            "thigh": np.array([thigh]),
            "shank": np.array([shank]),
        }
        weights = {weight_parameter(cost): np.array([self.weights[cost.name]]) for cost in COSTS}
        return {name: np.ravel(value) for name, value in (values | weights).items()}


def parameter_sizes(legs: int) -> dict[str, int]:
    """Name -> number of scalars of the solver's parameters."""
    sizes = {
        "start_position": 3,
        "goal_position": 3,
        "goal_quat": 4,
        "start_feet": 3 * legs,
        "goal_feet": 3 * legs,
        "friction": 1,
        "joint_speed": 1,
        "thigh": 1,
        "shank": 1,
    }
    return sizes | {weight_parameter(cost): 1 for cost in COSTS}


def make_task(jump: Jump, robot: Robot, weights: dict[str, float] | None = None) -> Task:
    """Check the request and place it in the world.

    Raises:
        InputError: a value outside of the robot file's [task], or a weight that is none.
    """
    asked = robot.file.task
    for name in ("twist", "forward", "lateral", "height"):
        low, high = getattr(asked, name)
        value = getattr(jump, name)
        if not low - 1e-4 <= value <= high + 1e-4:
            raise InputError(_out_of_range(robot.name, name, value, low, high))
    unknown = set(weights or {}) - set(default_weights())
    if unknown:
        raise InputError(
            f"unknown weight {sorted(unknown)[0]!r}; the weights are {', '.join(default_weights())}"
        )
    for name, weight in (weights or {}).items():
        if not (np.isfinite(weight) and weight >= 0):
            raise InputError(f"weight {name}: expected a number of at least 0, got {weight}")
    return place_task(jump, robot, default_weights() | (weights or {}))


def place_task(jump: Jump, robot: Robot, weights: dict[str, float]) -> Task:
    """Place the request in the world, whatever it asks; all weights given."""
    c, s = np.cos(jump.twist), np.sin(jump.twist)
    Rz = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    shift = np.array([jump.forward, jump.lateral, jump.height])
    return Task(
        jump=jump,
        mass=float(robot.mass),
        start_position=np.array(robot.com),
        goal_position=Rz @ robot.com + shift,
        goal_quat=np.array([np.cos(jump.twist / 2), 0.0, 0.0, np.sin(jump.twist / 2)]),
        start_feet=np.array(robot.feet),
        goal_feet=robot.feet @ Rz.T + shift,
        limits=robot.file.limits,
        reach=robot.file.reach,
        timing=robot.file.timing,
        knee=knee_links(robot),
        weights=weights,
    )


def _out_of_range(robot: str, name: str, value: float, low: float, high: float) -> str:
    if name != "twist":
        return f"{name} {value:g} m is out of range; {robot} takes {low:g} to {high:g} m"
    low, high, value = (np.degrees(v) for v in (low, high, value))
    return f"twist {value:g} deg is out of range; {robot} takes {low:.0f} to {high:.0f} deg"
