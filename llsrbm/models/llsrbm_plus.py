"""LL-SRBM+: leg maps fitted from the URDF, with the legs' own inertia and momentum."""

from typing import Any

import casadi as ca
import numpy as np

from llsrbm.models.arms import Arms, Carried
from llsrbm.models.base import CentroidalModel, no_lift, point_inertia
from llsrbm.robots.leg_maps import quadratic_term_rates, quadratic_terms
from llsrbm.robots.robot import Robot


def _rows(row_major: Any) -> Any:
    return ca.reshape(row_major, -1, 3).T


class LLSRBMPlus(CentroidalModel):
    """The model that makes the plan true: what the paper's point masses leave out is counted.

    A leg is every link of the chain from the base to the foot, m_l heavy.

    - CoM of a leg in its mirrored hip frame: c(x_i), quadratic in the foot's place;
      a_i = h_i + M_i c(x_i) + o seen from the CoM.
    - I = I_T + m_T P(c_T + o) + sum [m_l P(a_i) + M_i I_c(x_i) M_i], I_c affine in x_i, or of legs
      that slide quadratic.
    - h = sum [m_l a_i x M_i (dc/dx) xdot_i + det(M_i) M_i S(x_i) xdot_i], S likewise: the rotation
      of the leg's links about the leg's CoM, a sole's turn among them.
    - Free arms are counted link by link, exactly (`llsrbm.models.arms`); held ones are base.
    - The path equality of the planner is I omega + h = R^T L, in place of eq. 4.

    c, I_c, S and the affine map behind o are least-squares fits to the URDF (`robots.leg_fit`).
    """

    name = "llsrbm-plus"
    is_true = True
    swinging_turns_base = True
    moves_arms = True
    summary = "quadratic leg CoM, changing leg inertia and the legs' own momentum, from the URDF"

    def __init__(self, robot: Robot, *, free_arms: bool = False) -> None:
        fit = robot.fit
        trunk = robot.base if free_arms else robot.trunk
        super().__init__(
            robot,
            leg_mass=fit.leg_mass,
            trunk_com=trunk.lever.copy(),
            leg_com_affine=fit.com_affine,
            arms=Arms(robot) if free_arms else None,
        )
        self._trunk_com = ca.DM(trunk.lever)
        self._trunk_inertia = ca.DM(trunk.inertia)
        self._com = ca.DM(fit.com_quadratic.T)
        self._inertia = ca.DM(fit.inertia_map.T)
        self._spin = ca.DM(fit.spin_map.T)

    def leg_com(self, leg: int, foot_in_hip: Any) -> Any:
        """c(x_i), (3, 1) m."""
        return ca.mtimes(self._com, quadratic_terms(foot_in_hip))

    def leg_com_rate(self, foot_in_hip: Any, foot_in_hip_rate: Any) -> Any:
        """(dc/dx) xdot_i, (3, 1) m/s."""
        return ca.mtimes(self._com, quadratic_term_rates(foot_in_hip, foot_in_hip_rate))

    def leg_inertia(self, leg: int, foot_in_hip: Any) -> Any:
        """M_i I_c(x_i) M_i, (3, 3) kg m2, base axes, about the leg's CoM."""
        M = ca.DM(np.diag(self.mirrors[leg]))
        return ca.mtimes([M, self._of_leg(self._inertia, foot_in_hip), M])

    def leg_spin(self, leg: int, foot_in_hip: Any, foot_in_hip_rate: Any) -> Any:
        """det(M_i) M_i S(x_i) xdot_i, (3, 1) kg m2/s, base axes."""
        S = self._of_leg(self._spin, foot_in_hip)
        mirror = self.mirrors[leg]
        return ca.DM(np.prod(mirror) * mirror) * ca.mtimes(S, foot_in_hip_rate)

    def _of_leg(self, coefficients: ca.DM, x: Any) -> Any:
        affine = coefficients.shape[1] == 1 + self.coordinates
        return _rows(ca.mtimes(coefficients, ca.vertcat(1, x) if affine else quadratic_terms(x)))

    def inertia(self, feet_in_hip: Any, offset: Any, arms: Carried | None = None) -> Any:
        """I_T + m_T P(c_T + o) + sum [m_l P(a_i) + M_i I_c M_i], (3, 3) kg m2."""
        total = self._trunk_inertia + self.base_mass * point_inertia(self._trunk_com + offset)
        for i in range(self.legs):
            a = self.foot_from_com(i, self.leg_com(i, feet_in_hip[:, i]), offset)
            total = total + self.leg_mass[i] * point_inertia(a)
            total = total + self.leg_inertia(i, feet_in_hip[:, i])
        return total if arms is None else total + arms.inertia(offset)

    def legs_momentum(self, feet_in_hip: Any, feet_in_hip_rate: Any, offset: Any) -> Any:
        """h, (3, 1) kg m2/s."""
        total = ca.DM.zeros(3)
        for i in range(self.legs):
            x, xdot = feet_in_hip[:, i], feet_in_hip_rate[:, i]
            a = self.foot_from_com(i, self.leg_com(i, x), offset)
            cdot = ca.DM(self.mirrors[i]) * self.leg_com_rate(x, xdot)
            total = total + self.leg_mass[i] * ca.cross(a, cdot) + self.leg_spin(i, x, xdot)
        return total

    def angular_momentum(
        self,
        feet_in_hip: Any,
        feet_in_hip_rate: Any,
        angular_velocity: Any,
        offset: Any,
        lift: Any = no_lift,
        arms: Carried | None = None,
    ) -> Any:
        """I omega + h leg by leg, m_l a x (omega x a + cdot) + ..., without forming I."""
        w = angular_velocity
        a = self._trunk_com + offset
        total = ca.mtimes(self._trunk_inertia, w) + self.base_mass * ca.cross(a, ca.cross(w, a))
        for i in range(self.legs):
            x, xdot = feet_in_hip[:, i], feet_in_hip_rate[:, i]
            a = lift(self.foot_from_com(i, self.leg_com(i, x), offset))
            cdot = lift(ca.DM(self.mirrors[i]) * self.leg_com_rate(x, xdot))
            total = total + self.leg_mass[i] * ca.cross(a, ca.cross(w, a) + cdot)
            total = total + ca.mtimes(self.leg_inertia(i, x), w) + self.leg_spin(i, x, xdot)
        return total if arms is None else total + arms.momentum(w, offset, lift)
