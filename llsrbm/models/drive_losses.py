"""Torque of drives beside that of their links, as expressions: for rotors, friction, damping.

    I q'' + F s(q') + D q',    s(q') = q' / sqrt(q'^2 + w^2),

where `llsrbm.robots.drives.torques` has a hyperbolic tangent. The two differ by up to 0.46 F, at
1.3 % of the speed limit, and by less than 0.15 F above 5 %; this one's curvature stays small, which
the planner's solver needs.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import casadi as ca

from llsrbm.arrays import Array
from llsrbm.robots.drives.torques import STILL
from llsrbm.robots.robot import Robot

_WIDER = 3.0  # times `STILL`: friction turns about within 1 rad/s, about what an interval changes


@dataclass(frozen=True, eq=False)
class DriveLosses:
    """Rotors, friction and damping of J joints."""

    armature: Array  # (J,) kg m2 or kg
    friction: Array  # (J,) Nm or N
    damping: Array  # (J,) Nm s/rad or N s/m
    width: Array  # (J,) rad/s or m/s

    @staticmethod
    def of(robot: Robot) -> DriveLosses:
        """Those of a robot's joints, in the order of `Robot.joint_names`."""
        width = _WIDER * STILL * robot.rated_speed
        return DriveLosses(robot.armature, robot.friction, robot.damping, width)

    def torque(self, joint: int, speed: Any, acceleration: Any) -> Any:
        """Nm or N of one joint at a speed and an acceleration."""
        return float(self.armature[joint]) * acceleration + self.resistance(joint, speed)

    def resistance(self, joint: int, speed: Any) -> Any:
        """Nm or N that friction and damping take of one joint."""
        friction, width = float(self.friction[joint]), float(self.width[joint])
        turned = speed / ca.sqrt(speed**2 + width**2)
        return friction * turned + float(self.damping[joint]) * speed

    def numbers(self) -> list[Any]:
        """For keys of caches."""
        return [values.tolist() for values in vars(self).values()]
