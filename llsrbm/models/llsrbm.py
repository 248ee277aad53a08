"""The paper's lump leg single rigid body model (section III), and a single rigid body."""

from typing import Any

import casadi as ca
import numpy as np

from llsrbm.models.arms import Carried
from llsrbm.models.base import CentroidalModel, no_lift, point_inertia
from llsrbm.robots.robot import Robot


class LLSRBM(CentroidalModel):
    """A rigid base and a point mass a leg, on the line from foot to hip at a constant fraction.

    - r = (r_B m_B + sum r_l m_l) / (m_B + sum m_l) (eq. 3) gives the base offset o.
    - L = I_W omega (eq. 4), h = 0.
    - I_G = I_B + sum m_l P(r - p_i + dp_i) (eqs. 5, 6): the base's inertia projected to the CoM
      and the legs' point masses; dp_i, from the contact to the point mass, is (1 - s) of the leg
      seen from the hip, s the fraction in the default posture.

    A leg is what lies beyond the hip joint of the robot file; the hip drives belong to the base,
    whose CoM and inertia make the model agree with the URDF in the default posture.
    """

    name = "llsrbm"
    summary = "the paper's model: rigid base, one proportional point mass a leg"

    def __init__(self, robot: Robot) -> None:
        fit = robot.fit
        affine = np.vstack(
            [np.zeros(3), (1.0 - fit.proportional_fraction) * np.eye(robot.foot_coordinates, 3)]
        )
        m_l = fit.proportional_mass
        offset = robot.base_position - robot.com
        m_B = robot.mass - m_l * len(fit.hips)
        legs_from_base = [
            h + M * (affine[1:4].T @ (M * (foot - robot.base_position - h)))
            for foot, h, M in zip(robot.feet, fit.hips, fit.mirrors, strict=True)
        ]
        base_com = (-robot.mass * offset - m_l * sum(legs_from_base)) / m_B
        super().__init__(robot, leg_mass=m_l, trunk_com=base_com, leg_com_affine=affine)
        self._base_com = ca.DM(base_com)
        lumps = [m_l * point_inertia(ca.DM(d + offset)) for d in legs_from_base]
        self._base_inertia = (
            ca.DM(robot.inertia) - m_B * point_inertia(ca.DM(base_com + offset)) - sum(lumps)
        )

    def inertia(self, feet_in_hip: Any, offset: Any, arms: Carried | None = None) -> Any:
        """I_B + m_B P(c_B + o) + sum m_l P(a_i), (3, 3) kg m2."""
        total = self._base_inertia + self.base_mass * point_inertia(self._base_com + offset)
        for i in range(self.legs):
            a = self.foot_from_com(i, self.leg_com(i, feet_in_hip[:, i]), offset)
            total = total + self.leg_mass[i] * point_inertia(a)
        return total

    def leg_com(self, leg: int, foot_in_hip: Any) -> Any:
        """(1 - s) x_i, (3, 1) m."""
        return ca.mtimes(ca.DM(self._leg_com_affine[1:4].T), foot_in_hip[:3])

    def angular_momentum(
        self,
        feet_in_hip: Any,
        feet_in_hip_rate: Any,
        angular_velocity: Any,
        offset: Any,
        lift: Any = no_lift,
        arms: Carried | None = None,
    ) -> Any:
        """I omega as base_inertia omega + sum of m a x (omega x a), (3, 1) kg m2/s (eq. 4)."""
        w = angular_velocity
        a = self._base_com + offset
        total = ca.mtimes(self._base_inertia, w) + self.base_mass * ca.cross(a, ca.cross(w, a))
        for i in range(self.legs):
            a = lift(self.foot_from_com(i, self.leg_com(i, feet_in_hip[:, i]), offset))
            total = total + self.leg_mass[i] * ca.cross(a, ca.cross(w, a))
        return total


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

    def inertia(self, feet_in_hip: Any, offset: Any, arms: Carried | None = None) -> Any:
        """I_0, (3, 3) kg m2."""
        return self._inertia

    def leg_com(self, leg: int, foot_in_hip: Any) -> Any:
        """The foot itself: a massless leg has no CoM to show."""
        return foot_in_hip[:3]
