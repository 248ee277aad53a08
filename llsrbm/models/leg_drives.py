"""Rates and torques of a leg's joints, as functions of its foot's place and the force on it.

The planner knows feet, not joints. For its limits on drives it needs, of each leg,

    q'   = r(x, x')                     joint rates, rad/s or m/s
    tau  = -J^T (f, m)                  joint torques that hold a force and a moment at the foot
    q''  = d/dt r(x, x')                joint accelerations, for what swinging the leg takes

as expressions in x, the foot in its mirrored hip frame (`llsrbm.models.base`), and where the knee
is, which must not run into anything. Two kinds of legs:

- `KneeLeg`: an abduction joint and two parallel ones, hip and knee, with a point foot, which most
  quadrupeds have. Closed forms, exact.
- `FittedLeg`: any other leg. Joint angles and the columns of J as quadratic polynomials of x,
  fitted over the robot file's reach by inverse kinematics, soles level.

The matrices may be CasADi SX or DM.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, NamedTuple

import casadi as ca
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from llsrbm.body.trunk_and_knees import knee_joint
from llsrbm.robots.leg_fit import sampled_legs
from llsrbm.robots.leg_maps import quadratic_features, quadratic_term_rates, quadratic_terms
from llsrbm.robots.robot import Robot

Array = NDArray[np.float64]
Matrix = Any  # casadi.SX or casadi.DM

# Axes closer than this to parallel, or to square, make a planar leg; rad.
_ALIGNED = 0.02
# Shares of a leg's length below which the closed forms are bent away from their singularities, the
# straight leg, the foot at the abduction axis and the foot at the hip; all are out of any sensible
# reach. Where rows grow a thousandfold Fatrop may look for a direction for ever.
_NEARLY_STRAIGHT = 0.1
_AT_THE_AXIS = 0.08
_AT_THE_HIP = 0.08
_REST = 0.25  # half of the share of a floor that is left far below it
_SAMPLES, _SEED = 800, 0


class LegDrives(ABC):
    """Joint rates and torques of one leg of n joints, from the base outwards."""

    joints: int  # n
    exact: bool  # whether the expressions are closed forms, not fits

    @abstractmethod
    def rates(self, x: Matrix, x_rate: Matrix) -> Matrix:
        """q' (n, 1), linear in `x_rate`; `x`: (d, 1) m, rad: the foot in its mirrored hip frame."""

    @abstractmethod
    def holding_torque(self, x: Matrix, force: Matrix, moment: Matrix | None) -> Matrix:
        """-J^T (f, m), (n, 1) Nm or N, linear in force and moment, (3, 1) on the foot, base axes.

        The moment is about the foot's frame; None of points.
        """

    @abstractmethod
    def knee(self, x: Matrix) -> Matrix | None:
        """The knee seen from the hip, (3, 1) m, base axes; None of legs that have none."""

    @abstractmethod
    def numbers(self) -> dict[str, Any]:
        """Numbers computed from the robot, for keys of caches."""

    def accelerations(self, x: Matrix, x_rate: Matrix, x_acceleration: Matrix) -> Matrix:
        """q'' (n, 1) rad/s2 or m/s2."""
        return self.rates(x, x_acceleration) + ca.jtimes(self.rates(x, x_rate), x, x_rate)


def leg_drives(robot: Robot) -> list[LegDrives]:
    """The drives of each leg, in the robot's order."""
    legs = [KneeLeg.of(robot, index) for index in range(len(robot.legs))]
    if all(leg is not None for leg in legs):
        return [leg for leg in legs if leg is not None]
    return FittedLeg.of(robot)


class KneeLeg(LegDrives):
    """Abduction about an axis a that is fixed in the base, then hip and knee about n, square to a.

    The foot is w from a point of the abduction axis; seen along a it is d beside the axis (always)
    and h = sqrt(|w - (a.w) a|^2 - d^2) away from it in the leg's plane. There, with (a.w, h) as
    coordinates, the foot is u from the hip joint, thigh and shank close a triangle over u, and the
    shank is A u + B (u turned by 90 deg), A and B functions of |u|^2.
    """

    joints = 3
    exact = True

    def __init__(self, **constants: Any) -> None:
        self._c = constants

    @staticmethod
    def of(robot: Robot, index: int) -> KneeLeg | None:
        """Leg number `index` of a robot; None if it is not of this kind."""
        leg, chains = robot.legs[index], robot.chains
        if robot.foot_coordinates != 3 or len(leg.joints) != 3 or chains.prismatic.any():
            return None
        stance = robot.posture[7:][robot.leg_joint_index]
        rest = np.zeros_like(stance)
        zero, standing = chains.motion(rest), chains.motion(stance)
        axes = zero.foot_turning[index].T
        a, n = axes[0], axes[1]
        sigma = float(np.sign(axes[2] @ n))
        if np.linalg.norm(np.cross(n, axes[2])) > _ALIGNED or abs(a @ n) > _ALIGNED:
            return None
        if leg.joints.index(robot.file.legs[leg.name].hip) != 1:
            return None
        o1, o2, o3 = chains.origins(rest)[index]
        foot = standing.foot[index]
        across, knee_across = (float(n @ (point - o1)) for point in (zero.foot[index], o3))
        # Which way of the two the leg's plane reaches down from the axis, when it stands.
        turned, n_standing, _ = standing.foot_turning[index].T
        side = float(np.sign(np.cross(turned, n_standing) @ (foot - o1)))
        e = side * np.cross(a, n)
        _, hip, knee = chains.origins(stance)[index]
        e_standing = side * np.cross(turned, n_standing)
        plane = np.array([turned, e_standing])
        u = plane @ (foot - hip)
        shank = plane @ (foot - knee)
        bend = float(np.sign(u[0] * shank[1] - u[1] * shank[0]))
        in_plane = np.array([a, e])
        return KneeLeg(
            mirror=robot.mirrors[index],
            hip=robot.hips[index] - o1,
            axis=a,
            side=side,
            across=across,
            knee_across=knee_across,
            hip_in_plane=in_plane @ (o2 - o1),
            thigh=float(np.linalg.norm(in_plane @ (o3 - o2))),
            shank=float(np.linalg.norm(in_plane @ (zero.foot[index] - o3))),
            bend=bend,
            knee_sign=sigma,
        )

    def numbers(self) -> dict[str, Any]:
        return {name: np.asarray(value).tolist() for name, value in self._c.items()}

    def _plane(self, x: Matrix) -> _Plane:
        c, a = self._c, ca.DM(self._c["axis"])
        w = ca.DM(c["hip"]) + ca.DM(c["mirror"]) * x[:3]
        along = ca.dot(a, w)
        square = w - along * a
        length = c["thigh"] + c["shank"]
        rho2 = _at_least(ca.sumsqr(square), (_AT_THE_HIP * length) ** 2)
        h = ca.sqrt(_at_least(rho2 - c["across"] ** 2, (_AT_THE_AXIS * length) ** 2))
        u = ca.vertcat(along - c["hip_in_plane"][0], h - c["hip_in_plane"][1])
        u2 = _at_least(ca.sumsqr(u), (_AT_THE_HIP * length) ** 2)
        a2, b2 = c["thigh"] ** 2, c["shank"] ** 2
        cosine = (a2 + b2 - u2) / 2
        area = ca.sqrt(_at_least(a2 * b2 - cosine**2, a2 * b2 * _NEARLY_STRAIGHT**2))
        return _Plane(square, rho2, h, u, u2, (u2 + b2 - a2) / (2 * u2), area, cosine)

    def rates(self, x: Matrix, x_rate: Matrix) -> Matrix:
        return self._motion(self._plane(x), x_rate, None)[0]

    def accelerations(self, x: Matrix, x_rate: Matrix, x_acceleration: Matrix) -> Matrix:
        return self._motion(self._plane(x), x_rate, x_acceleration)[1]

    def _motion(self, p: _Plane, x_rate: Matrix, x_acceleration: Matrix | None) -> tuple[Any, Any]:
        c, a = self._c, ca.DM(self._c["axis"])
        side, sign, bend = c["side"], c["knee_sign"], c["bend"]
        n_of = (c["across"] * p.square - side * p.h * ca.cross(a, p.square)) / p.rho2
        v = ca.DM(c["mirror"]) * x_rate[:3]
        along_rate = ca.dot(a, v)
        h_rate = ca.dot(p.square, v) / p.h
        u_rate = ca.vertcat(along_rate, h_rate)
        radial = ca.dot(p.u, u_rate)
        turning = p.u[0] * u_rate[1] - p.u[1] * u_rate[0]
        abduction = -side * ca.dot(n_of, v) / p.h
        knee = side * sign * bend * radial / p.area
        hip = -side * turning / p.u2 - sign * p.A * knee
        rates = ca.vertcat(abduction, hip, knee)
        if x_acceleration is None:
            return rates, None
        w = ca.DM(c["mirror"]) * x_acceleration[:3]
        h_acceleration = (ca.dot(p.square, w) + ca.sumsqr(v) - along_rate**2 - h_rate**2) / p.h
        u_acceleration = ca.vertcat(ca.dot(a, w), h_acceleration)
        radial_rate = ca.sumsqr(u_rate) + ca.dot(p.u, u_acceleration)
        turning_rate = p.u[0] * u_acceleration[1] - p.u[1] * u_acceleration[0]
        coriolis = 2 * side * h_rate * abduction + c["across"] * abduction**2
        abduction_2 = -side * (ca.dot(n_of, w) + coriolis) / p.h
        knee_2 = side * sign * bend * (radial_rate - p.cosine * radial**2 / p.area**2) / p.area
        A_rate = -(c["shank"] ** 2 - c["thigh"] ** 2) * radial / p.u2**2
        hip_2 = -side * (turning_rate / p.u2 - 2 * turning * radial / p.u2**2) - sign * (
            A_rate * knee + p.A * knee_2
        )
        return rates, ca.vertcat(abduction_2, hip_2, knee_2)

    def knee(self, x: Matrix) -> Matrix:
        c, a = self._c, ca.DM(self._c["axis"])
        p = self._plane(x)
        round_axis = ca.cross(a, p.square)
        # Where n and, in the leg's plane square to a, e point: both from the foot's own place.
        n = (c["across"] * p.square - c["side"] * p.h * round_axis) / p.rho2
        e = (p.h * p.square + c["side"] * c["across"] * round_axis) / p.rho2
        turned = c["bend"] * p.area / p.u2
        thigh = (1 - p.A) * p.u - turned * ca.vertcat(-p.u[1], p.u[0])
        along, away = c["hip_in_plane"][0] + thigh[0], c["hip_in_plane"][1] + thigh[1]
        return along * a + away * e + c["knee_across"] * n - ca.DM(c["hip"])

    def holding_torque(self, x: Matrix, force: Matrix, moment: Matrix | None) -> Matrix:
        c, a = self._c, ca.DM(self._c["axis"])
        p = self._plane(x)
        round_axis = ca.cross(a, p.square)
        along = ca.dot(a, force)
        away = p.h * ca.dot(p.square, force) + c["side"] * c["across"] * ca.dot(round_axis, force)
        away = away / p.rho2
        about_hip = p.u[0] * away - p.u[1] * along
        radial = p.u[0] * along + p.u[1] * away
        about_knee = p.A * about_hip - c["bend"] * p.area / p.u2 * radial
        return ca.vertcat(
            -ca.dot(round_axis, force),
            c["side"] * about_hip,
            c["side"] * c["knee_sign"] * about_knee,
        )


class _Plane(NamedTuple):
    square: Matrix  # (3, 1) m, w square to the axis
    rho2: Matrix  # its square, m2
    h: Matrix  # m
    u: Matrix  # (2, 1) m
    u2: Matrix  # its square, m2
    A: Matrix  # share of u in the shank
    area: Matrix  # thigh times shank times the sine and the cosine of the angle between them, m2
    cosine: Matrix  # thigh times shank times the sine and the cosine of the angle between them, m2


def _at_least(value: Matrix, floor: float) -> Matrix:
    """`value`, bent smoothly towards a share of `floor` that it never falls below."""
    root = ca.sqrt(ca.sqrt((value**2) ** 2 + floor**4))
    return (value + root) / 2 + _REST * floor * (1 - value / root)


class FittedLeg(LegDrives):
    """Quadratic polynomials of x for the joint angles, the columns of J, and the knee's place.

    Attributes:
        residuals: RMS errors over the samples: "angle" rad or m; "torque" share of the mean column;
            "knee" m, of legs that have one.
    """

    exact = False

    def __init__(
        self, angles: Array, jacobian: Array, knee: Array | None, residuals: dict[str, float]
    ) -> None:
        """Maps of the features: to q (f, n), to J, row by row (f, 6 n), to the knee (f, 3) if any.

        Rows of J: linear, angular.
        """
        self.joints = angles.shape[1]
        self.residuals = residuals
        self._angles = ca.sparsify(ca.DM(angles.T), 1e-9)
        self._jacobian = ca.sparsify(ca.DM(jacobian.T), 1e-9)
        self._knee = None if knee is None else ca.sparsify(ca.DM(knee.T), 1e-9)

    @staticmethod
    def of(robot: Robot) -> list[LegDrives]:
        """Fit every leg of a robot."""
        x, q = sampled_legs(robot, _SAMPLES, _SEED)
        motion, origins = robot.chains.motion(q), robot.chains.origins(q)
        joint = knee_joint(robot)
        fitted: list[LegDrives] = []
        for leg in range(len(robot.legs)):
            features = quadratic_features(x[:, leg])
            J = np.concatenate([motion.foot_jacobian[:, leg], motion.foot_turning[:, leg]], axis=1)
            flat = J.transpose(0, 2, 1).reshape(len(J), -1)
            angles, columns = (np.linalg.lstsq(features, y)[0] for y in (q[:, leg], flat))
            residuals = {
                "angle": float(np.sqrt(np.mean((features @ angles - q[:, leg]) ** 2))),
                "torque": float(
                    np.sqrt(np.mean((features @ columns - flat) ** 2)) / np.abs(flat).mean()
                ),
            }
            knee = None
            if joint is not None:
                places = origins[:, leg, joint] - robot.hips[leg]
                knee = np.linalg.lstsq(features, places)[0]
                residuals["knee"] = float(np.sqrt(np.mean((features @ knee - places) ** 2)))
            fitted.append(FittedLeg(angles, columns, knee, residuals))
        return fitted

    def numbers(self) -> dict[str, Any]:
        knee = {} if self._knee is None else {"knee": str(self._knee)}
        return {"angles": str(self._angles), "jacobian": str(self._jacobian), **knee}

    def knee(self, x: Matrix) -> Matrix | None:
        return None if self._knee is None else ca.mtimes(self._knee, quadratic_terms(x))

    def rates(self, x: Matrix, x_rate: Matrix) -> Matrix:
        return ca.mtimes(self._angles, quadratic_term_rates(x, x_rate))

    def holding_torque(self, x: Matrix, force: Matrix, moment: Matrix | None) -> Matrix:
        J = ca.reshape(ca.mtimes(self._jacobian, quadratic_terms(x)), 6, self.joints)
        torque = ca.mtimes(J[:3, :].T, force)
        if moment is not None:
            torque = torque + ca.mtimes(J[3:, :].T, moment)
        return -torque


@dataclass(frozen=True, eq=False)
class Drives:
    """The legs' drives and what they move: L legs of n joints."""

    legs: list[LegDrives]  # (L) joint rates and torques
    torque_limit: Array  # (L, n) Nm or N, rad/s or m/s
    speed_limit: Array  # (L, n) Nm or N, rad/s or m/s
    # (L, n, n) joint-space inertia of each leg in the default posture. What swinging a leg takes is
    # this times its joints' acceleration, within 6 % of the hip's torque limit on ANYmal's jumps
    # and 10 % of the abduction's: the legs' inertia changes with posture, and the base gives way.
    mass_matrix: Array
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
            mass_matrix=np.array([joints[np.ix_(rows, rows)] for rows in index]),
            weight=robot.mass * motion.com_jacobian.transpose(0, 2, 1),
        )

    def numbers(self) -> dict[str, Any]:
        """Everything that was computed from the robot, for keys of caches."""
        plain = {k: np.asarray(v).tolist() for k, v in vars(self).items() if k != "legs"}
        return plain | {"legs": [leg.numbers() for leg in self.legs]}
