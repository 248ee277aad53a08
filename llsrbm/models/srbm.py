"""SRBM: the single rigid body, the comparison of the paper (section III)."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from llsrbm.models.base import CentroidalModel
from llsrbm.robots.robot import Robot


class SRBM(CentroidalModel):
    """One rigid body: the inertia of the whole robot in its default posture, massless legs.

    L = I_W omega (eq. 4) with I_W = R I_0 R^T (eq. 5 with a constant I_G), h = 0; the base stays
    where it is relative to the CoM, o = o_0.
    """

    name = "srbm"
    summary = "single rigid body, constant inertia of the default posture"

    def __init__(self, robot: Robot) -> None:
        super().__init__(
            robot,
            leg_mass=0.0,
            trunk_com=robot.com - robot.base_position,
            leg_com_affine=np.zeros((1 + robot.foot_coordinates, 3)),
        )
        self._inertia = ca.DM(robot.inertia)

    def inertia(self, feet_in_hip: Any, offset: Any) -> Any:
        """I_0, (3, 3) kg m2."""
        return self._inertia

    def legs_momentum(self, feet_in_hip: Any, feet_in_hip_rate: Any, offset: Any) -> Any:
        """Zero: massless legs."""
        return ca.DM.zeros(3)

    def leg_com(self, leg: int, foot_in_hip: Any) -> Any:
        """The foot itself: a massless leg has no CoM to show."""
        return foot_in_hip[:3]
