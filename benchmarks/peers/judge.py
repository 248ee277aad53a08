"""One checker for everybody's jump: its demands on drives, floor and feet."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from llsrbm.body.joint_loads import joint_loads
from llsrbm.body.knot_motion import KnotMotion
from llsrbm.robots.drives.torques import torque_in_direction
from llsrbm.robots.robot import Robot

Array = NDArray[np.float64]

FRICTION = 0.5  # of the floor on which all are judged
LOADED = 1.0  # N; a foot that carries less cannot slip in a way that matters


@dataclass(frozen=True, eq=False)
class Motion:
    """The motion of a planner, N intervals, J joints, L feet; world frame, SI units.

    Attributes:
        joint_velocity, joint_torque: (N, J) in the order of `Robot.joint_names`.
        contact_force: (N, L, 3).
        foot_position: (N+1, L, 3), of the balls' middles.
        standing: (N, L) whether a foot stands over an interval.
        impulse: N s that the floor gives at touchdown in no time; 0 of plans without impacts.
    """

    joint_velocity: Array
    joint_torque: Array
    contact_force: Array
    foot_position: Array
    standing: NDArray[np.bool_]
    impulse: float = 0.0

    @staticmethod
    def of_knots(robot: Robot, knots: KnotMotion) -> Motion:
        """A centroidal plan, with the torques that inverse dynamics of the whole body finds."""
        loads = joint_loads(robot, knots)
        return Motion(
            joint_velocity=loads.joint_velocity,
            joint_torque=loads.joint_torque,
            contact_force=knots.contact_force[:-1],
            foot_position=knots.foot_position,
            standing=knots.standing,
        )


@dataclass(frozen=True)
class Verdict:
    """How near a motion comes to its limits, and how far it goes beyond them.

    Attributes:
        torque: largest torque as a share of what the drive gives at that speed; infinite where a
            drive would have to push beyond its speed limit.
        speed: largest joint speed as a share of its limit.
        friction: largest horizontal force as a share of what friction of 0.5 holds.
        clearance: m that the lowest foot is above where it stood, in the middle of the flight.
        slip: m that standing feet move.
        impulse: N s at touchdown.
    """

    torque: float
    speed: float
    friction: float
    clearance: float
    slip: float
    impulse: float

    @property
    def violated(self) -> tuple[str, ...]:
        """Names of the limits that are exceeded."""
        beyond = {
            "torque": self.torque > 1.0,
            "speed": self.speed > 1.0,
            "friction": self.friction > 1.0 + 1e-3,
            "clearance": self.clearance < 0.0,
            "impact": self.impulse > 0.0,
        }
        return tuple(name for name, so in beyond.items() if so)


def judge(robot: Robot, motion: Motion) -> Verdict:
    """The largest of everything over a motion."""
    available = torque_in_direction(robot, motion.joint_velocity, motion.joint_torque)
    with np.errstate(divide="ignore"):
        torque = np.abs(motion.joint_torque) / available
    force = motion.contact_force
    loaded = force[..., 2] > LOADED
    share = np.linalg.norm(force[..., :2], axis=-1)[loaded] / (FRICTION * force[..., 2][loaded])
    flying = np.flatnonzero(~motion.standing.any(axis=1))
    middle = flying[len(flying) // 2]
    moved = np.linalg.norm(np.diff(motion.foot_position, axis=0), axis=-1)
    before, after = motion.foot_position[0, :, 2], motion.foot_position[-1, :, 2]
    return Verdict(
        torque=float(torque.max()),
        speed=float((np.abs(motion.joint_velocity) / robot.speed_limit).max()),
        friction=float(share.max()),
        clearance=float((motion.foot_position[middle, :, 2] - (before + after) / 2).min()),
        slip=float(moved[motion.standing].max(initial=0.0)),
        impulse=motion.impulse,
    )
