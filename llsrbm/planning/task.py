"""The request in numbers: where everything starts and ends, and the limits that hold between."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from llsrbm.errors import InputError
from llsrbm.jump import Jump
from llsrbm.planning.costs import COSTS, default_weights, weight_parameter
from llsrbm.planning.layout import STANDING, Layout
from llsrbm.planning.limits import check_limits, put_limits
from llsrbm.robots.robot import Robot
from llsrbm.robots.schema import Foot, Limits, Reach, Timing
from llsrbm.tuning import Tuning

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Task:
    """What the planner solves.

    Attributes:
        jump: the request.
        mass: kg.
        start_position, goal_position: (3,) m, CoM.
        goal_quat: (4,) w, x, y, z, continuous in the twist (w < 0 beyond 180 degrees).
        start_feet, goal_feet: (L, 3) m; start_yaw, goal_yaw: (L,) rad, headings of the feet;
            points look nowhere, 0.
        start_contacts, goal_contacts: (C, 3) m, legs x corners.
        corners: (c, 3) m, contact points of a foot in its frame.
        limits, reach, timing, foot: of the robot file, with what the request changes.
        robot: whose drives and whole body a plan is checked with.
        weights: cost name -> weight, of every cost.
        tuning: what of weights and limits the request changes.
    """

    jump: Jump
    mass: float
    start_position: Array
    goal_position: Array
    goal_quat: Array
    start_feet: Array
    goal_feet: Array
    start_yaw: Array
    goal_yaw: Array
    corners: Array
    limits: Limits
    reach: Reach
    timing: Timing
    foot: Foot
    robot: Robot
    weights: dict[str, float]
    tuning: Tuning

    @cached_property
    def start_contacts(self) -> Array:
        """(C, 3) m."""
        return contact_points(self.start_feet, self.start_yaw, self.corners)

    @cached_property
    def goal_contacts(self) -> Array:
        """(C, 3) m."""
        return contact_points(self.goal_feet, self.goal_yaw, self.corners)

    @property
    def joints(self) -> int:
        """J."""
        return len(self.robot.joint_names)

    @property
    def lowest_hips(self) -> float:
        """How high the hips stay above standing feet, m."""
        robot = self.robot
        stands = float((robot.base_position + robot.hips - robot.feet)[:, 2].mean())
        return self.reach.standing * stands

    @property
    def towards(self) -> Array:
        """(L, 2) horizontal directions across the edge between start and target; or zeros.

        See `gap`, which is there where these are.
        """
        return self._edge[0]

    @property
    def gap(self) -> Array:
        """(L,) m: how far it is from start to target along `towards`.

        Onto a higher surface from a foot's own start to all of the target, to a lower one from all
        of the start to the foot's own target. Of the landing heading's axes the one that leaves the
        widest gap counts.
        """
        return self._edge[1]

    @cached_property
    def _edge(self) -> tuple[Array, Array]:
        c, s = np.cos(self.jump.twist), np.sin(self.jump.twist)
        axes = np.array([(c, s), (-c, -s), (-s, c), (s, -c)])
        legs = len(self.start_feet)
        start, goal = (
            points[:, :2].reshape(legs, -1, 2) @ axes.T
            for points in (self.start_contacts, self.goal_contacts)
        )
        if self.jump.height < 0:
            gaps = goal.min(axis=1) - start.max(axis=(0, 1))
        else:
            gaps = goal.min(axis=(0, 1)) - start.max(axis=1)
        widest = gaps.max(axis=1)
        return axes[gaps.argmax(axis=1)] * (widest[:, None] > 0), np.maximum(widest, 0.0)

    def parameters(self) -> dict[str, Array]:
        """Name -> value of the solver's parameters (names and sizes: `parameter_sizes`)."""
        values = {
            "start_position": self.start_position,
            "goal_position": self.goal_position,
            "goal_quat": self.goal_quat,
            **{name: getattr(self, name) for name in STANDING["start"] + STANDING["goal"]},
            "corners": self.corners[:, :2],
            "towards": self.towards,
            "friction": np.array([self.limits.friction]),
            "torque_share": np.array([self.limits.torque_share]),
        }
        weights = {
            weight_parameter(cost): np.array([cost.share(self.jump) * self.weights[cost.name]])
            for cost in COSTS
        }
        return {name: np.ravel(value) for name, value in (values | weights).items()}


def contact_points(feet: Array, yaw: Array, corners: Array) -> Array:
    """Contact points of level feet.

    Args:
        feet: (..., L, 3) m, world frame.
        yaw: (..., L) rad, headings.
        corners: (c, 3) m, in the frame of a foot.

    Returns:
        (..., L c, 3) m, world frame, legs x corners.
    """
    c, s = np.cos(yaw)[..., None], np.sin(yaw)[..., None]
    x, y, z = corners.T
    turned = np.stack([c * x - s * y, s * x + c * y, np.broadcast_to(z, (c * x).shape)], axis=-1)
    points: Array = feet[..., None, :] + turned
    return points.reshape(*yaw.shape[:-1], -1, 3)


def parameter_sizes(layout: Layout) -> dict[str, int]:
    """Name -> number of scalars of the solver's parameters."""
    legs, contacts = layout.legs, layout.contacts
    standing = (3 * legs, 3 * contacts, legs)
    sizes = {
        "start_position": 3,
        "goal_position": 3,
        "goal_quat": 4,
        **dict(zip(STANDING["start"], standing, strict=True)),
        **dict(zip(STANDING["goal"], standing, strict=True)),
        "corners": 2 * contacts // legs,
        "towards": 2 * legs,
        "friction": 1,
        "torque_share": 1,
    }
    return sizes | {weight_parameter(cost): 1 for cost in COSTS}


def make_task(
    jump: Jump,
    robot: Robot,
    weights: Mapping[str, float] | None = None,
    limits: Mapping[str, float] | None = None,
) -> Task:
    """Check the request and place it in the world.

    Raises:
        InputError: a value outside of the robot file's [task], a weight or a limit that is none.
    """
    asked = robot.file.task
    for name in ("twist", "forward", "lateral", "height"):
        low, high = getattr(asked, name)
        value = getattr(jump, name)
        if not low - 1e-4 <= value <= high + 1e-4:
            raise InputError(_out_of_range(robot.name, name, value, low, high))
    for where, given in ((f"{robot.path}: planning: ", robot.file.planning), ("", weights or {})):
        for name, weight in given.items():
            if name not in default_weights():
                valid = ", ".join(default_weights())
                raise InputError(f"{where}unknown weight {name!r}; the weights are {valid}")
            if not (np.isfinite(weight) and weight >= 0):
                raise InputError(
                    f"{where}weight {name}: expected a number of at least 0, got {weight}"
                )
    if limits:
        check_limits(limits, place_task(Jump(robot=jump.robot), robot), robot.name)
    return place_task(jump, robot, Tuning(weights or {}, limits or {}))


def place_task(jump: Jump, robot: Robot, tuning: Tuning | None = None) -> Task:
    """Place the request in the world, whatever it asks; nothing is checked."""
    tuning = tuning or Tuning()
    c, s = np.cos(jump.twist), np.sin(jump.twist)
    Rz = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    shift = np.array([jump.forward, jump.lateral, jump.height])
    yaw = _headings(robot)
    task = Task(
        jump=jump,
        mass=float(robot.mass),
        start_position=np.array(robot.com),
        goal_position=Rz @ robot.com + shift,
        goal_quat=np.array([np.cos(jump.twist / 2), 0.0, 0.0, np.sin(jump.twist / 2)]),
        start_feet=np.array(robot.feet),
        goal_feet=robot.feet @ Rz.T + shift,
        start_yaw=yaw,
        goal_yaw=yaw + jump.twist * (robot.foot_coordinates > 3),
        corners=np.array(robot.corners),
        limits=robot.file.limits,
        reach=robot.file.reach,
        timing=robot.file.timing,
        foot=robot.file.foot,
        robot=robot,
        weights=default_weights() | robot.file.planning | dict(tuning.weights),
        tuning=tuning,
    )
    return put_limits(task, tuning.limits)


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
