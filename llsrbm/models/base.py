"""Interface of the centroidal models, and the kinematics of the base that all of them share.

Frames and symbols, as in the docstrings of the models:

- beta_i = R^T (p_i - r): foot i seen from the CoM, base axes; R = R_world_base.
- o: origin of the base (the URDF's root link) seen from the CoM, base axes.
- h_i: hip i in the base frame; M_i = diag(mirror_i) turns base axes into the leg's mirrored axes.
- x_i = M_i (beta_i - o - h_i): foot i in its mirrored hip frame. The legs' configuration is the
  (d, L) matrix of all x_i: the variables of the planner in flight, functions of r and R in stance.
- What the arms' joints do, if they are free, is given too: of the CoM's definition it is the sum of
  m c of their links (`llsrbm.models.arms`). Held arms are part of the base.
- Where feet are lines or soles, d = 4: beta_i goes on with the foot's yaw relative to the base, x_i
  with the same in mirrored axes, det(M_i) times it (outwards positive). The feet are level.

Every model's leg CoM is an affine function of x_i for the purpose of finding o, so that o is affine
in the feet: the CoM's definition (eq. 3 of the paper) m o = -(m_T c_T + m_l sum_i d_i), with
d_i = h_i + M_i (w_0 + W x_i) the CoM of leg i in the base frame, W (3, d), has a solution in closed
form both for given x_i and for given beta_i.

The matrices may be CasADi SX or DM.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import casadi as ca
import numpy as np

from llsrbm.arrays import Array
from llsrbm.models.arms import Arms, Carried
from llsrbm.models.drives import Drives
from llsrbm.robots.robot import Robot

Matrix = Any  # casadi.SX or casadi.DM
Lift = Callable[[Matrix], Matrix]


def no_lift(expression: Matrix) -> Matrix:
    """Evaluate in place; the planner passes `Lifting` here to keep derivatives small."""
    return expression


def point_inertia(d: Matrix) -> Matrix:
    """P(d) = |d|^2 1 - d d^T, (3, 3): inertia of a unit mass at d (eq. 5)."""
    return ca.dot(d, d) * ca.DM.eye(3) - ca.mtimes(d, d.T)


def _sparse(matrix: Array) -> ca.DM:
    """Without the rounding errors that stand for zeros, so that they cost nothing."""
    return ca.sparsify(ca.DM(matrix), 1e-12)


@dataclass(frozen=True, eq=False)
class OffsetMap:
    """o = constant + sum_i G_i y_i + C s, y_i how foot i is given: beta_i or x_i; s of the arms."""

    constant: Array  # (3,) m
    maps: dict[int, Array]  # leg -> G_i, (3, d)
    of_moment: Array  # C, (3, 3) 1/kg

    def __call__(self, feet: dict[int, Matrix], arms: Carried | None = None) -> Matrix:
        """o, (3, 1) m, of feet (d, 1)."""
        own = ca.DM(self.constant) + self._of_feet(feet)
        return own if arms is None else own + ca.mtimes(_sparse(self.of_moment), arms.moment)

    def rate(self, rates: dict[int, Matrix], arms: Carried | None = None) -> Matrix:
        """Time derivative of o, (3, 1) m/s; of feet that are not among the rates at rest."""
        own = self._of_feet(rates)
        return own if arms is None else own + ca.mtimes(_sparse(self.of_moment), arms.moment_rate)

    def _of_feet(self, feet: dict[int, Matrix]) -> Matrix:
        parts = (ca.mtimes(_sparse(G), feet[i]) for i, G in self.maps.items() if i in feet)
        return sum(parts)


class CentroidalModel(ABC):
    """A robot's centroidal inertia and the legs' momentum as functions of where its feet are.

    Attributes:
        is_true: whether plans are held to what the whole body makes of them; else the model is
            there for comparison.
        swinging_turns_base: whether legs that swing have an angular momentum of their own.
        mass: of the whole robot, kg.
        leg_mass: (L,) kg; base_mass: kg.
        hips: (L, 3) m, base frame; mirrors: (L, 3) of +-1.
        coordinates: d, of a foot: 3, or 4 with its yaw.
        turn_mirrors: (L,) of +-1, what mirroring does to a yaw.
        foot_lift: m, of the feet's frames above the points with which they stand. beta and x are
            of the frames.
        drives: what the legs' joints must do, the same in all models.
        arms: if they are free; else the base has them.
        moves_arms: whether they can be.
    """

    name: ClassVar[str]  # as in `llsrbm.models.MODELS`
    summary: ClassVar[str]  # one line for lists
    is_true: ClassVar[bool] = False
    swinging_turns_base: ClassVar[bool] = False
    moves_arms: ClassVar[bool] = False

    def __init__(
        self,
        robot: Robot,
        *,
        leg_mass: float,
        trunk_com: Array,
        leg_com_affine: Array,
        arms: Arms | None = None,
    ) -> None:
        """Precompute the base offset's affine maps, from the robot's fit and default posture.

        Args:
            robot: the robot.
            leg_mass: m_l, kg.
            trunk_com: c_T, (3,) m, CoM of all but the legs and free arms, base frame.
            leg_com_affine: (1 + d, 3): rows w_0 and W^T of the leg's CoM, mirrored hip frame.
            arms: if they are free.
        """
        fit = robot.fit
        self.mass = float(robot.mass)
        self.hips, self.mirrors = fit.hips, fit.mirrors
        self.legs = len(self.hips)
        self.coordinates = robot.foot_coordinates
        self.foot_lift = robot.foot_lift
        self.turn_mirrors = self.mirrors[:, 0] * self.mirrors[:, 1]
        self.leg_mass = np.full(self.legs, leg_mass)
        self.arms = arms
        self.base_mass = self.mass - self.legs * leg_mass - (0.0 if arms is None else arms.mass)
        self._leg_com_affine = leg_com_affine
        self.drives = Drives.of(robot)
        W, W_turn = leg_com_affine[1:4].T, leg_com_affine[4:].T
        per_leg = [np.diag(M) @ W @ np.diag(M) for M in self.mirrors]
        turns = [
            t * np.diag(M) @ W_turn for M, t in zip(self.mirrors, self.turn_mirrors, strict=True)
        ]
        fixed = self.base_mass * trunk_com + leg_mass * sum(
            h + M * leg_com_affine[0] for h, M in zip(self.hips, self.mirrors, strict=True)
        )
        # Given x: o = offset_0 + sum_i offset_x_i x_i.
        self._offset_0 = -fixed / self.mass
        self._offset_x = [
            -leg_mass / self.mass * np.diag(M) @ leg_com_affine[1:].T for M in self.mirrors
        ]
        # Given beta: A o = k + m_l sum_i M_i W M_i beta_i, yaws as further columns.
        A_inverse: Array = np.asarray(
            np.linalg.inv(-self.mass * np.eye(3) + leg_mass * sum(per_leg)), dtype=np.float64
        )
        self._offset_moment = A_inverse
        hips_share = sum(G @ h for G, h in zip(per_leg, self.hips, strict=True))
        self._offset_beta_0 = A_inverse @ (fixed - leg_mass * hips_share)
        self._offset_beta = [
            np.hstack([leg_mass * A_inverse @ G, leg_mass * A_inverse @ T])
            for G, T in zip(per_leg, turns, strict=True)
        ]

    def numbers(self) -> dict[str, Any]:
        """Everything the model computed from the robot, for keys of caches."""
        plain = {k: v for k, v in vars(self).items() if k not in ("drives", "arms")}
        numbers = {k: np.asarray(v).tolist() for k, v in plain.items()}
        arms = {} if self.arms is None else {"arms": self.arms.numbers()}
        return numbers | {"drives": self.drives.numbers()} | arms

    # ---- where the base is

    def base_offset(self, feet_in_hip: Matrix, arms: Carried | None = None) -> Matrix:
        """o(x), (3, 1) m, affine in the feet x (d, L)."""
        return self.offset_map(())(dict(enumerate(ca.horzsplit(feet_in_hip))), arms)

    def offset_map(self, standing: tuple[int, ...]) -> OffsetMap:
        """o where standing feet are given as seen from the CoM, others in their hip frames."""
        hanging: Array = np.diag(np.full(3, -1.0 / self.mass))
        if not standing:
            return OffsetMap(self._offset_0, dict(enumerate(self._offset_x)), hanging)
        if len(standing) == self.legs:
            maps = dict(enumerate(self._offset_beta))
            return OffsetMap(self._offset_beta_0, maps, self._offset_moment)
        left, fixed, maps = np.eye(3), self._offset_0.copy(), dict(enumerate(self._offset_x))
        for i in standing:
            turned = maps[i][:, :3] * self.mirrors[i]
            left += turned
            fixed -= turned @ self.hips[i]
            maps[i] = np.hstack([turned, self.turn_mirrors[i] * maps[i][:, 3:]])
        inverse: Array = np.asarray(np.linalg.inv(left), dtype=np.float64)
        maps = {i: inverse @ G for i, G in maps.items()}
        return OffsetMap(inverse @ fixed, maps, inverse @ hanging)

    def foot_in_hip(self, leg: int, foot_from_com: Matrix, offset: Matrix) -> Matrix:
        """x_i of beta_i, (d, 1): M_i (beta_i - o - h_i) m, and a yaw mirrored, rad."""
        place = ca.DM(self.mirrors[leg]) * (foot_from_com[:3] - offset - ca.DM(self.hips[leg]))
        if self.coordinates == 3:
            return place
        return ca.vertcat(place, self.turn_mirrors[leg] * foot_from_com[3])

    def foot_rate_in_hip(self, leg: int, rate_from_com: Matrix, offset_rate: Matrix) -> Matrix:
        """xdot_i of betadot_i and odot, (d, 1) m/s, rad/s."""
        place = ca.DM(self.mirrors[leg]) * (rate_from_com[:3] - offset_rate)
        return ca.vertcat(place, self.turn_mirrors[leg] * rate_from_com[3:])

    def foot_from_com(self, leg: int, foot_in_hip: Matrix, offset: Matrix) -> Matrix:
        """o + h_i + M_i x_i, (3, 1) m: where a point is; a yaw in x_i is not looked at."""
        return offset + ca.DM(self.hips[leg]) + ca.DM(self.mirrors[leg]) * foot_in_hip[:3]

    # ---- what differs from model to model

    @abstractmethod
    def inertia(self, feet_in_hip: Matrix, offset: Matrix, arms: Carried | None = None) -> Matrix:
        """Centroidal inertia, (3, 3) kg m2, base axes."""

    def legs_momentum(
        self, feet_in_hip: Matrix, feet_in_hip_rate: Matrix, offset: Matrix
    ) -> Matrix:
        """h: the legs' angular momentum relative to the base about the CoM, (3, 1), base axes.

        Zero here: the paper writes L = I_W omega.
        """
        return ca.DM.zeros(3)

    @abstractmethod
    def leg_com(self, leg: int, foot_in_hip: Matrix) -> Matrix:
        """Where the model puts leg i's mass, (3, 1) m, mirrored hip frame."""

    def angular_momentum(
        self,
        feet_in_hip: Matrix,
        feet_in_hip_rate: Matrix,
        angular_velocity: Matrix,
        offset: Matrix,
        lift: Lift = no_lift,
        arms: Carried | None = None,
    ) -> Matrix:
        """R^T L = I omega + h, (3, 1) kg m2/s, base axes (eq. 4).

        `lift` marks quantities through which derivatives are taken, so that second ones stay small
        blocks.
        """
        return ca.mtimes(self.inertia(feet_in_hip, offset), angular_velocity) + self.legs_momentum(
            feet_in_hip, feet_in_hip_rate, offset
        )
