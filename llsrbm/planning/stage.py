"""One stage: symbols at a knot, and all that follows from them over the interval after it."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import casadi as ca

from llsrbm.models.base import CentroidalModel
from llsrbm.motion.plan import Phase
from llsrbm.ocp.lifting import Lifting
from llsrbm.planning.headings import across, heading_rate, relative_yaw, relative_yaw_rate
from llsrbm.planning.layout import STANDING, Layout, Role
from llsrbm.planning.rotations import quat_exp, quat_product, rotation_matrix

GRAVITY = 9.81  # m/s2
BALANCE_SCALE = 10.0  # the momentum balance in 0.1 m2/s, about as large as the other rows


class Stage:
    """Symbolic quantities of one role, for constraints, costs and dynamics to pick from.

    World frame unless a name says otherwise; angular momentum and moments divided by the mass.
    Accelerations over an interval are constant, so position, velocity and angular momentum are
    exact; the attitude uses the angular velocity at the interval's midpoint.

    Attributes:
        role, layout, model: what the stage is about.
        parameters: name -> symbols that stay fixed in a solve.
        symbols: name -> this stage's variables; variables: all of them, states first.
        standing_feet: (3, L) m: where the feet stand in this phase (flight: where they left).
        standing_contacts: (3, C) m: their contact points; standing_yaw: (L,) rad, their headings.
        standing: all three in one column.
        lift: collects the intermediates derivatives run through.
    """

    def __init__(
        self, role: Role, layout: Layout, model: CentroidalModel, parameters: dict[str, ca.SX]
    ) -> None:
        self.role, self.layout, self.model, self.parameters = role, layout, model, parameters
        names = (*layout.states(role), *layout.controls(role))
        self.symbols = {name: ca.SX.sym(name, layout.size(name)) for name in names}
        self.variables = ca.vertcat(*self.symbols.values())
        # Symbols of their own, so that take-off and landing can share their expressions.
        self.standing_feet = ca.SX.sym("standing_feet", 3, layout.legs)
        self.standing_contacts = ca.SX.sym("standing_contacts", 3, layout.contacts)
        self.standing_yaw = ca.SX.sym("standing_yaw", layout.legs)
        self.standing = ca.vertcat(
            ca.vec(self.standing_feet), ca.vec(self.standing_contacts), self.standing_yaw
        )
        self.lift = Lifting(self.variables)
        self.intervals = layout.intervals_of(role.phase)

    # ---- at the knot

    @property
    def position(self) -> Any:
        """r, (3, 1) m."""
        return self.symbols.get("position", self.parameters["start_position"])

    @property
    def quat(self) -> Any:
        """q_world_base, (4, 1)."""
        return self.symbols.get("quat", ca.SX([1, 0, 0, 0]))

    @property
    def velocity(self) -> Any:
        """Of the CoM, (3, 1) m/s."""
        return self.symbols.get("velocity", ca.SX.zeros(3))

    @property
    def momentum(self) -> Any:
        """L / m, (3, 1) m2/s."""
        return self.symbols.get("momentum", ca.SX.zeros(3))

    @staticmethod
    def standing_parameters(role: Role) -> tuple[str, ...]:
        """The parameters of `standing` in a role."""
        return STANDING["goal" if role.phase == Phase.LANDING else "start"]

    @cached_property
    def R_world_base(self) -> Any:
        """At the knot, (3, 3)."""
        return self.lift(rotation_matrix(self.quat))

    @cached_property
    def feet_in_hip(self) -> Any:
        """x at the knot, (d, L): variables in flight, functions of r and R in stance."""
        if "feet" in self.symbols:
            return ca.reshape(self.symbols["feet"], self.layout.foot_coordinates, -1)
        return self._feet_in_stance(self.R_world_base, self.position)[0]

    @cached_property
    def offset(self) -> Any:
        """o at the knot of a stage whose feet are variables, (3, 1) m."""
        return self.lift(self.model.base_offset(self.feet_in_hip))

    @property
    def feet_velocity(self) -> Any:
        """xdot just before the knot of a stage whose feet are variables, (d, L)."""
        return ca.reshape(self.symbols["feet_velocity"], self.layout.foot_coordinates, -1)

    @property
    def feet_steps(self) -> list[tuple[Any, Any]]:
        """(d, L) changes of xdot in m/s, rad/s, and the times that they take, s.

        From interval to interval it is one of them; from rest at lift-off to the first interval's
        middle, and from the last one's to rest at touchdown, half of one.
        """
        shape = (self.layout.foot_coordinates, self.layout.legs)
        steps = [(ca.reshape(self.symbols["feet_step"], *shape), self.dt)]
        if self.role.first:
            steps = [(steps[0][0], self.dt / 2)]
        if self.role.last:
            steps.append((ca.reshape(self.symbols["feet_stop"], *shape), self.dt / 2))
        return steps

    def foot_from_com(self, leg: int) -> Any:
        """beta_i at the knot of a stage whose feet are variables, (3, 1) m, base axes."""
        return self.model.foot_from_com(leg, self.feet_in_hip[:, leg], self.offset)

    def relative_yaw(self, leg: int) -> Any:
        """The foot's yaw against the base at the knot, rad, base axes."""
        return self.model.turn_mirrors[leg] * self.feet_in_hip[3, leg]

    def _across(self, R: Any) -> list[Any]:
        """The direction across each standing foot, (3, 1) in base axes; none for points."""
        if self.layout.foot_coordinates == 3:
            return []
        return [self.lift(across(R, psi)) for psi in ca.vertsplit(self.standing_yaw)]

    def _feet_in_stance(self, R: Any, position: Any) -> tuple[Any, Any, Any]:
        r_base = self.lift(ca.mtimes(R.T, position))
        beta = [ca.mtimes(R.T, self.standing_feet[:, i]) - r_base for i in range(self.layout.legs)]
        if directions := self._across(R):
            yaws = [self.lift(relative_yaw(nb)) for nb in directions]
            beta = [ca.vertcat(b, yaw) for b, yaw in zip(beta, yaws, strict=True)]
        o = self.lift(self.model.base_offset_from_com(ca.horzcat(*beta)))
        feet = [self.lift(self.model.foot_in_hip(i, b, o)) for i, b in enumerate(beta)]
        return ca.horzcat(*feet), o, ca.horzcat(*beta)

    # ---- over the interval

    @property
    def duration(self) -> Any:
        """T of the phase, s."""
        return self.symbols["duration"]

    @cached_property
    def dt(self) -> Any:
        """Length of the interval, s."""
        return self.duration / self.intervals

    @property
    def force(self) -> Any:
        """(3, contacts) in m g / contacts."""
        return ca.reshape(self.symbols["force"], 3, self.layout.contacts)

    @cached_property
    def _specific_force(self) -> Any:
        if not self.role.in_contact:
            return ca.SX.zeros(3)
        return self.lift(ca.sum2(self.force) * (GRAVITY / self.layout.contacts))

    @cached_property
    def acceleration(self) -> Any:
        """Of the CoM, (3, 1) m/s2 (eq. 1)."""
        return self._specific_force - ca.DM([0, 0, GRAVITY])

    @cached_property
    def _moment_about_origin(self) -> Any:
        points = self.standing_contacts
        moments = (ca.cross(points[:, j], self.force[:, j]) for j in range(self.layout.contacts))
        return self.lift(sum(moments) * (GRAVITY / self.layout.contacts))

    def _moment_about(self, position: Any) -> Any:
        """Moment of the contact forces about a point, divided by m, (3, 1) m2/s2."""
        return self._moment_about_origin - ca.cross(position, self._specific_force)

    @cached_property
    def moment(self) -> Any:
        """Mean moment of the contact forces about the CoM, by m, (3, 1) m2/s2 (eq. 1)."""
        if not self.role.in_contact:
            return ca.SX.zeros(3)
        return self._moment_about(
            self.position + self.velocity * self.dt / 2 + self.acceleration * self.dt**2 / 6
        )

    @property
    def rotation_rate(self) -> Any:
        """omega of the base over the interval, (3, 1) rad/s, base axes."""
        return self.symbols["rotation_rate"]

    @cached_property
    def _half_turn(self) -> Any:
        return self.lift(quat_exp(self.lift(self.rotation_rate * self.dt / 2)))

    @cached_property
    def _quat_mid(self) -> Any:
        return self.lift(quat_product(self.quat, self._half_turn))

    @cached_property
    def R_world_base_mid(self) -> Any:
        """At the interval's midpoint, (3, 3)."""
        return self.lift(rotation_matrix(self._quat_mid))

    @cached_property
    def velocity_mid_base(self) -> Any:
        """The CoM's velocity at the midpoint, (3, 1) m/s, base axes."""
        velocity = self.lift(self.velocity + self.acceleration * self.dt / 2)
        return self.lift(ca.mtimes(self.R_world_base_mid.T, velocity))

    @cached_property
    def momentum_mean_base(self) -> Any:
        """R^T L / m, L's mean over the interval, R at the midpoint, (3, 1) m2/s.

        The mean is exact, a cubic's integral: with L at the midpoint, or the mean of both ends,
        a side jump rolls by half a degree more than planned.
        """
        momentum = self.momentum
        if self.role.in_contact:
            about = (
                self.position + self.velocity * self.dt / 3 + self.acceleration * self.dt**2 / 12
            )
            momentum = self.lift(momentum + self._moment_about(about) * self.dt / 2)
        return self.lift(ca.mtimes(self.R_world_base_mid.T, momentum))

    @cached_property
    def feet_mid(self) -> tuple[Any, Any, Any, Any]:
        """x (d, L), xdot (d, L), o (3, 1) and odot (3, 1) at the midpoint."""
        if self.role.phase == Phase.FLIGHT:
            xdot = self.lift(self.feet_velocity + self.feet_steps[0][0])
            x = self.lift(self.feet_in_hip + xdot * self.dt / 2)
            o_rate = self.lift(self.model.base_offset_rate(xdot))
            return x, xdot, self.lift(self.model.base_offset(x)), o_rate
        position = self.lift(
            self.position + self.velocity * self.dt / 2 + self.acceleration * self.dt**2 / 8
        )
        x, o, beta = self._feet_in_stance(self.R_world_base_mid, position)
        beta_rate = [
            -self.velocity_mid_base - ca.cross(self.rotation_rate, beta[:3, i])
            for i in range(self.layout.legs)
        ]
        turns: list[Any] = [ca.SX(0, 1)] * self.layout.legs
        if directions := self._across(self.R_world_base_mid):
            turns = [relative_yaw_rate(nb, self.rotation_rate) for nb in directions]
        seen = ca.horzcat(*map(ca.vertcat, beta_rate, turns))
        o_rate = self.lift(self.model.base_offset_rate_from_com(seen))
        xdot = [
            self.lift(ca.vertcat(ca.DM(M) * (rate - o_rate), side * turn))
            for M, side, rate, turn in zip(
                self.model.mirrors, self.model.turn_mirrors, beta_rate, turns, strict=True
            )
        ]
        return x, ca.horzcat(*xdot), o, o_rate

    @cached_property
    def balance(self) -> Any:
        """(I omega + h - R^T L) / m of an interval, (3, 1), in 1 / BALANCE_SCALE m2/s."""
        x, xdot, o, _ = self.feet_mid
        momentum = self.model.angular_momentum(x, xdot, self.rotation_rate, o, self.lift)
        return BALANCE_SCALE * (momentum / self.model.mass - self.momentum_mean_base)

    @cached_property
    def foot_velocity_base(self) -> Any:
        """The feet's velocity in the world, base axes, mean over a flight interval, (3, L) m/s."""
        x, xdot, o, o_rate = self.feet_mid
        columns = []
        for i in range(self.layout.legs):
            beta = self.model.foot_from_com(i, x[:, i], o)
            beta_rate = o_rate + ca.DM(self.model.mirrors[i]) * xdot[:3, i]
            columns.append(
                self.lift(self.velocity_mid_base + ca.cross(self.rotation_rate, beta) + beta_rate)
            )
        return ca.horzcat(*columns)

    @cached_property
    def foot_turn(self) -> Any:
        """How fast the feet turn in the world, mean over a flight interval, (L, 1) rad/s.

        Empty for points.
        """
        if self.layout.foot_coordinates == 3:
            return ca.SX(0, 1)
        x, xdot, _, _ = self.feet_mid
        up = self.lift(self.R_world_base_mid[2, :].T)
        rates = [
            heading_rate(up, side * x[3, i], side * xdot[3, i], self.rotation_rate)
            for i, side in enumerate(self.model.turn_mirrors)
        ]
        return ca.vertcat(*rates)

    @cached_property
    def foot_velocity_at_knot(self) -> Any:
        """The feet's velocity in the world as the interval begins, base axes, (3, L) m/s."""
        velocity = self.lift(ca.mtimes(self.R_world_base.T, self.velocity))
        xdot = self.feet_velocity
        o_rate = self.model.base_offset_rate(xdot)
        return ca.horzcat(
            *(
                velocity
                + ca.cross(self.rotation_rate, self.foot_from_com(i))
                + o_rate
                + ca.DM(self.model.mirrors[i]) * xdot[:3, i]
                for i in range(self.layout.legs)
            )
        )

    @cached_property
    def foot_turn_at_knot(self) -> Any:
        """How fast the feet turn in the world as the interval begins, (L, 1) rad/s; no points."""
        if self.layout.foot_coordinates == 3:
            return ca.SX(0, 1)
        up, x, xdot = self.R_world_base[2, :].T, self.feet_in_hip, self.feet_velocity
        return ca.vertcat(
            *(
                heading_rate(up, side * x[3, i], side * xdot[3, i], self.rotation_rate)
                for i, side in enumerate(self.model.turn_mirrors)
            )
        )

    # ---- drives

    @cached_property
    def joint_rates(self) -> Any:
        """q' in the middle of the interval, (n, L) rad/s or m/s, legs from the base outwards."""
        x, xdot, _, _ = self.feet_mid
        legs = self.model.drives.legs
        return ca.horzcat(
            *(self.lift(leg.rates(x[:, i], xdot[:, i])) for i, leg in enumerate(legs))
        )

    @cached_property
    def joint_torques(self) -> Any:
        """(n, L) shares of what the drives give at rest, in stance in the middle of the interval.

        What holds the contact forces and the leg's own weight, and what moves the leg. In flight
        what swings the legs as the interval begins; of the last one also as it ends, (n, 2 L).
        """
        legs = range(self.layout.legs)
        if self.role.phase == Phase.FLIGHT:
            start = self.feet_in_hip, self.feet_velocity
            end = self.feet_in_hip + self.feet_mid[1] * self.dt, self.feet_mid[1]
            steps = zip((start, end), self.feet_steps, strict=False)
            torques = [
                self._swing_torque(i, x[:, i], before[:, i] + step[:, i] / 2, step[:, i] / span)
                for (x, before), (step, span) in steps
                for i in legs
            ]
        else:
            torques = [self._stance_torque(i) for i in legs]
        return ca.horzcat(*torques)

    def _swing_torque(self, leg: int, x: Any, x_rate: Any, x_acceleration: Any) -> Any:
        drives = self.model.drives
        x, x_rate, x_acceleration = map(self.lift, (x, x_rate, x_acceleration))
        joints = drives.legs[leg].accelerations(x, x_rate, x_acceleration)
        return self._share(leg, ca.mtimes(ca.DM(drives.mass_matrix[leg]), joints))

    def _stance_torque(self, leg: int) -> Any:
        x, xdot, _, _ = self.feet_mid
        drives = self.model.drives
        force, moment = self._load_on_foot(leg)
        torque = drives.legs[leg].holding_torque(x[:, leg], force, moment)
        torque = torque + ca.mtimes(ca.DM(drives.weight[leg]), self._specific_force_base)
        # The foot stands, so seen from the hip it accelerates as the body does, the other way.
        carried = -ca.DM(self.model.mirrors[leg]) * self._acceleration_base
        still = ca.SX.zeros(self.layout.foot_coordinates - 3)
        joints = drives.legs[leg].accelerations(x[:, leg], xdot[:, leg], ca.vertcat(carried, still))
        return self._share(leg, torque + ca.mtimes(ca.DM(drives.mass_matrix[leg]), joints))

    def _share(self, leg: int, torque: Any) -> Any:
        return self.lift(torque / ca.DM(self.model.drives.torque_limit[leg]))

    @cached_property
    def _acceleration_base(self) -> Any:
        return self.lift(ca.mtimes(self.R_world_base_mid.T, self.acceleration))

    def _load_on_foot(self, leg: int) -> tuple[Any, Any]:
        """Force (3, 1) N on a standing foot and its moment (3, 1) Nm.

        In base axes, the moment about the foot's middle; none of points.
        """
        R, corners = self.R_world_base_mid, self.layout.corners
        unit = self.model.mass * GRAVITY / self.layout.contacts
        mine = range(leg * corners, (leg + 1) * corners)
        total = sum(self.force[:, j] for j in mine)
        force = self.lift(ca.mtimes(R.T, total) * unit)
        if corners == 1:
            return force, None
        moments = (
            ca.cross(self.standing_contacts[:, j] - self.standing_feet[:, leg], self.force[:, j])
            for j in mine
        )
        return force, self.lift(ca.mtimes(R.T, sum(moments)) * unit)

    @cached_property
    def _specific_force_base(self) -> Any:
        return self.lift(ca.mtimes(self.R_world_base_mid.T, self._specific_force))

    # ---- dynamics

    def next_state(self, names: tuple[str, ...]) -> Any:
        """The states called `names` at the next knot (eq. 8)."""
        role, s, dt = self.role, self.symbols, self.dt
        step = {
            "position": lambda: self.position + self.velocity * dt + self.acceleration * dt**2 / 2,
            "quat": lambda: quat_product(self._quat_mid, self._half_turn),
            "velocity": lambda: self.velocity + self.acceleration * dt,
            "momentum": lambda: self.momentum + self.moment * dt,
            "duration": lambda: s.get("next_duration", self.duration),
            "force": lambda: (
                s["next_force"]
                if "next_force" in s
                else s["force"] + s.get("force_step", ca.SX.zeros(s["force"].shape))
            ),
            "feet": lambda: (
                s["feet"] + (s["feet_velocity"] + s["feet_step"]) * dt
                if role.phase == Phase.FLIGHT
                else s["next_feet"]
            ),
            "feet_velocity": lambda: (
                s["feet_velocity"] + s["feet_step"] + s.get("feet_stop", 0)
                if role.phase == Phase.FLIGHT
                else s["next_feet_velocity"]
            ),
        }
        return ca.vertcat(*(step[name]() for name in names))
