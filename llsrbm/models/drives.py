"""The drives of a robot's legs: how each leg moves, what its joints give, and what they move."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np
import pinocchio as pin

from llsrbm.arrays import Array, BoolArray, IntArray
from llsrbm.models.drive_losses import DriveLosses
from llsrbm.models.fitted_leg import FittedLeg
from llsrbm.models.knee_leg import KneeLeg
from llsrbm.models.leg_drives import LegDrives
from llsrbm.robots.robot import Robot

# Places along each side of the reach at which angles are compared with the joints' stops, and what
# is near one, a share of what lies between: soles that tilt against the base turn ankles further.
_GRID, _NEAR_STOP = 9, 0.1
# The most that requests, and motions that are planned anew, make of the robot file's reach: factors
# of the box's ends, of those on the hip's other side too, and of the shortest and the longest leg.
BOX_ENDS, SHORTEST_LEG, LONGEST_LEG = (0.4, 1.4), 0.8, 1.08


@lru_cache(maxsize=12)
def leg_drives(robot: Robot) -> tuple[LegDrives, ...]:
    """The drives of each leg, in the robot's order."""
    legs = [KneeLeg.of(robot, index) for index in range(len(robot.legs))]
    if all(leg is not None for leg in legs):
        return tuple(leg for leg in legs if leg is not None)
    return tuple(FittedLeg.of(robot))


@dataclass(frozen=True, eq=False)
class Drives:
    """The legs' drives and what they move: L legs of n joints."""

    legs: tuple[LegDrives, ...]  # (L) joint rates and torques
    torque_limit: Array  # (L, n) Nm or N, rad/s or m/s
    speed_limit: Array  # (L, n) Nm or N, rad/s or m/s
    may_stop: BoolArray  # (L, n) see `near_stops`
    # (L, n, n) joint-space inertia of each leg in the default posture, with rotors. What swinging a
    # leg takes is this times its joints' acceleration, within 6 % of the hip's torque limit on
    # ANYmal's jumps and 10 % of the abduction's: the legs' inertia changes with posture, and the
    # base gives way.
    mass_matrix: Array
    losses: DriveLosses
    joints: IntArray  # (L, n) places of the legs' joints in `losses`
    # (L, n, 3) kg m, kg: the torques that carry the leg in the default posture, per specific force
    # on the base, base axes.
    weight: Array

    @staticmethod
    def of(robot: Robot) -> Drives:
        """The drives of a robot."""
        data = robot.model.createData()
        M = pin.crba(robot.model, data, robot.posture)
        joints = (np.triu(M) + np.triu(M, 1).T)[6:, 6:]
        index = robot.leg_joint_index
        motion = robot.chains.motion(robot.posture[7:][index])
        return Drives(
            legs=leg_drives(robot),
            torque_limit=robot.torque_limit[index],
            speed_limit=robot.speed_limit[index],
            may_stop=near_stops(robot),
            mass_matrix=np.array([joints[np.ix_(rows, rows)] for rows in index]),
            losses=DriveLosses.of(robot),
            joints=index,
            weight=robot.mass * motion.com_jacobian.transpose(0, 2, 1),
        )

    def numbers(self) -> dict[str, Any]:
        """Everything that was computed from the robot, for keys of caches."""
        others = ("legs", "losses")
        plain = {k: np.asarray(v).tolist() for k, v in vars(self).items() if k not in others}
        legs = [leg.numbers() for leg in self.legs]
        return plain | {"legs": legs, "losses": self.losses.numbers()}

    def effort(self, leg: int, rates: Any, accelerations: Any) -> Any:
        """(n, 1) Nm or N of a leg's drives that move it at joint rates and accelerations."""
        resistance = (
            self.losses.resistance(int(joint), rates[k]) for k, joint in enumerate(self.joints[leg])
        )
        return ca.mtimes(ca.DM(self.mass_matrix[leg]), accelerations) + ca.vertcat(*resistance)


def widest_box(robot: Robot) -> tuple[Array, Array]:
    """Corners (3,) of the widest box that a request may ask for, m, as the robot file's."""
    box = robot.file.reach
    lower, upper = (np.outer(BOX_ENDS, corner) for corner in (box.lower, box.upper))
    return lower.min(axis=0), upper.max(axis=0)


@lru_cache(maxsize=12)
def near_stops(robot: Robot) -> BoolArray:
    """(L, n) whether the joint may come near a stop with its foot within the widest reach."""
    foot, x = robot.file.foot, ca.SX.sym("x", robot.foot_coordinates)
    ends = [*zip(*widest_box(robot), strict=True)]
    if robot.foot_coordinates > len(ends):
        ends.append(foot.yaw)
    grid = np.meshgrid(*(np.linspace(*end, _GRID) for end in ends))
    places = np.stack(grid).reshape(len(ends), -1)
    distance = np.linalg.norm(places[:3], axis=0)
    low, high = np.array(robot.file.reach.distance) * [SHORTEST_LEG, LONGEST_LEG]
    places = places[:, (distance >= low) & (distance <= high)]
    near = []
    stops = robot.joint_stops[:, robot.leg_joint_index]
    for leg, lower, upper in zip(leg_drives(robot), *stops, strict=True):
        angles = np.array(ca.Function("angles", [x], [leg.angles(x)])(places))
        room = _NEAR_STOP * (upper - lower)
        least, most = np.nanmin(angles, axis=1), np.nanmax(angles, axis=1)
        near.append((least < lower + room) | (most > upper - room))
    return np.array(near)
