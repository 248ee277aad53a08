"""A leg in closed form: an abduction joint and two parallel ones, hip and knee, with a point foot.

Most quadrupeds have such legs. The matrices may be CasADi SX or DM.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from llsrbm.models.leg_drives import LegDrives, Matrix
from llsrbm.robots.robot import Robot

# Axes closer than this to parallel, or to square, make a planar leg; rad.
_ALIGNED = 0.02
# Shares of a leg's length below which the closed forms are bent away from their singularities, the
# straight leg, the foot at the abduction axis and the foot at the hip; all are out of any sensible
# reach. Where rows grow a thousandfold Fatrop may look for a direction for ever.
_NEARLY_STRAIGHT = 0.1
_AT_THE_AXIS = 0.08
_AT_THE_HIP = 0.08
_REST = 0.25  # half of the share of a floor that is left far below it


class KneeLeg(LegDrives):
    """Abduction about an axis a that is fixed in the base, then hip and knee about n, square to a.

    The foot is w from a point of the abduction axis; seen along a it is d beside the axis (always)
    and h = sqrt(|w - (a.w) a|^2 - d^2) away from it in the leg's plane. There, with (a.w, h) as
    coordinates, the foot is u from the hip joint, thigh and shank close a triangle over u, and the
    shank is A u + B (u turned by 90 deg), A and B functions of |u|^2.
    """

    joints = 3

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
        thigh = plane @ (knee - hip)
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
            standing_angles=stance[index],
            standing_away=e_standing,
            standing_thigh=thigh,
            standing_shank=(thigh @ shank, thigh[0] * shank[1] - thigh[1] * shank[0]),
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

    def angles(self, x: Matrix) -> Matrix:
        c, p = self._c, self._plane(x)
        standing_away, thigh_then = ca.DM(c["standing_away"]), c["standing_thigh"]
        _, e = self._across_and_away(p)
        abduction = ca.atan2(
            ca.dot(ca.DM(c["axis"]), ca.cross(standing_away, e)), ca.dot(standing_away, e)
        )
        thigh = self._thigh(p)
        swing = ca.atan2(
            thigh_then[0] * thigh[1] - thigh_then[1] * thigh[0],
            thigh_then[0] * thigh[0] + thigh_then[1] * thigh[1],
        )
        # The angle from thigh to shank against the standing one.
        (cosine, sine), now = c["standing_shank"], (-p.cosine, c["bend"] * p.area)
        fold = ca.atan2(cosine * now[1] - sine * now[0], cosine * now[0] + sine * now[1])
        turned = ca.vertcat(abduction, -c["side"] * swing, -c["side"] * c["knee_sign"] * fold)
        return ca.DM(c["standing_angles"]) + turned

    def _across_and_away(self, p: _Plane) -> tuple[Matrix, Matrix]:
        """Where n and, in the leg's plane square to a, e point: both from the foot's own place."""
        c = self._c
        round_axis = ca.cross(ca.DM(c["axis"]), p.square)
        n = (c["across"] * p.square - c["side"] * p.h * round_axis) / p.rho2
        e = (p.h * p.square + c["side"] * c["across"] * round_axis) / p.rho2
        return n, e

    def _thigh(self, p: _Plane) -> Matrix:
        """Hip to knee along a and e, (2, 1) m."""
        turned = self._c["bend"] * p.area / p.u2
        return (1 - p.A) * p.u - turned * ca.vertcat(-p.u[1], p.u[0])

    def knee(self, x: Matrix) -> Matrix:
        c, a = self._c, ca.DM(self._c["axis"])
        p = self._plane(x)
        n, e = self._across_and_away(p)
        thigh = self._thigh(p)
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
        turns = ca.vertcat(
            -ca.dot(round_axis, force),
            c["side"] * about_hip,
            c["side"] * c["knee_sign"] * about_knee,
        )
        if moment is None:
            return turns
        n, _ = self._across_and_away(p)
        bends = ca.dot(n, moment)
        return turns - ca.vertcat(ca.dot(a, moment), bends, c["knee_sign"] * bends)


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
