"""One stage: symbols at a knot, and all that follows from them over the interval after it."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import casadi as ca

from llsrbm.mechanics import GRAVITY
from llsrbm.models.base import CentroidalModel
from llsrbm.ocp.lifting import Lifting
from llsrbm.planning.problem.headings import across, heading_rate, relative_yaw, relative_yaw_rate
from llsrbm.planning.problem.layout import SHIFT, Layout, Role
from llsrbm.planning.problem.rotations import quat_exp, quat_product, rotation_matrix

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
        standing_feet: (3, L) m: where the feet stand in this phase, or stood last; shifted or not.
        standing_contacts: (3, C) m: their contact points; standing_yaw: (L,) rad, their headings.
        towards: (2, L) directions across the edge that flying feet cross, see `Task.towards`.
        local: all of these in one column: parameters of a phase.
        correction: (3, 1) m2/s, base axes, parameters of the interval: see `Task.correction`; / m.
        lift: collects the intermediates derivatives run through.
    """

    def __init__(
        self, role: Role, layout: Layout, model: CentroidalModel, parameters: dict[str, ca.SX]
    ) -> None:
        self.role, self.layout, self.model, self.parameters = role, layout, model, parameters
        names = (*layout.states(role), *layout.controls(role))
        self.symbols = {name: ca.SX.sym(name, layout.size(name, role)) for name in names}
        self.variables = ca.vertcat(*self.symbols.values())
        # Symbols of their own, so that phases can share their expressions.
        feet = ca.SX.sym("standing_feet", 3, layout.legs)
        contacts = ca.SX.sym("standing_contacts", 3, layout.contacts)
        self.standing_yaw = ca.SX.sym("standing_yaw", layout.legs)
        self.towards = ca.SX.sym("towards", 2, layout.legs)
        self.local = ca.vertcat(
            ca.vec(feet), ca.vec(contacts), self.standing_yaw, ca.vec(self.towards)
        )
        shift = ca.vertcat(self.shift, 0) if role.shifted else ca.SX.zeros(3)
        self.standing_feet = feet + ca.repmat(shift, 1, layout.legs)
        self.standing_contacts = contacts + ca.repmat(shift, 1, layout.contacts)
        self.correction = ca.SX.sym("correction", 3)
        self.lift = Lifting(self.variables)
        self.intervals = role.intervals

    @staticmethod
    def local_sizes(layout: Layout) -> dict[str, int]:
        """Name -> number of scalars of a phase's parameters, in the order of `local`."""
        legs = layout.legs
        return {"feet": 3 * legs, "contacts": 3 * layout.contacts, "yaw": legs, "towards": 2 * legs}

    def of_legs(self, name: str) -> dict[int, Any]:
        """Leg -> its part of a variable, (d, 1), or of a force, (3 corners, 1)."""
        legs = self.layout.legs_of(name, self.role)
        if not legs:
            return {}
        values = self._chosen_or_given(name)
        return dict(zip(legs, ca.vertsplit(values, self._width(name)), strict=True))

    def _chosen_or_given(self, name: str) -> Any:
        """A variable, or where it all begins a parameter."""
        return self.symbols[name] if name in self.symbols else self.parameters[f"start_{name}"]

    def _width(self, name: str) -> int:
        return 3 * self.layout.corners if "force" in name else self.layout.foot_coordinates

    # ---- at the knot

    @property
    def position(self) -> Any:
        """r, (3, 1) m."""
        return self.symbols.get("position", self.parameters["start_position"])

    @property
    def quat(self) -> Any:
        """q_world_base, (4, 1)."""
        return self.symbols.get("quat", self.parameters["start_quat"])

    @property
    def velocity(self) -> Any:
        """Of the CoM, (3, 1) m/s."""
        return self.symbols.get("velocity", self.parameters["start_velocity"])

    @property
    def momentum(self) -> Any:
        """L / m, (3, 1) m2/s."""
        return self.symbols.get("momentum", self.parameters.get("start_momentum", ca.SX.zeros(3)))

    @property
    def shift(self) -> Any:
        """Of where feet land, (2, 1) m."""
        return self.symbols.get(SHIFT, ca.SX.zeros(2))

    @property
    def off_goal(self) -> Any:
        """(3, 1) m: how far the CoM is from where it is to end, above the feet it lands on."""
        return self.position - self.parameters["goal_position"] - ca.vertcat(self.shift, 0)

    @cached_property
    def R_world_base(self) -> Any:
        """At the knot, (3, 3)."""
        return self.lift(rotation_matrix(self.quat))

    @cached_property
    def feet_in_hip(self) -> Any:
        """x at the knot, (d, L): variables in the air, functions of r and R on the ground."""
        if len(self.role.in_air) == self.layout.legs:
            return ca.reshape(self._chosen_or_given("feet"), self.layout.foot_coordinates, -1)
        return self._placed_at_knot[0]

    @cached_property
    def offset(self) -> Any:
        """o at the knot, (3, 1) m."""
        if len(self.role.in_air) == self.layout.legs:
            return self.lift(self.model.base_offset(self.feet_in_hip))
        return self._placed_at_knot[1]

    @cached_property
    def _placed_at_knot(self) -> tuple[Any, Any, dict[int, Any]]:
        return self._placed(self.R_world_base, self.position, self.of_legs("feet"))

    @cached_property
    def feet_velocity(self) -> dict[int, Any]:
        """Leg -> xdot just before the knot, (d, 1), of feet in the air."""
        return self.of_legs("feet_velocity")

    @cached_property
    def feet_steps(self) -> dict[int, list[tuple[Any, Any]]]:
        """Swinging leg -> (d, 1) changes of xdot in m/s, rad/s, and the times that they take, s.

        From interval to interval it is one of them. Half of one it is to the first interval's
        middle, from rest at lift-off or from a knot at which it all begins under way, and from the
        last one's to rest at touchdown.
        """
        stops = self.of_legs("feet_stop")
        steps: dict[int, list[tuple[Any, Any]]] = {}
        for leg, step in self.of_legs("feet_step").items():
            begins = leg in self.role.leaving or self.role.initial
            steps[leg] = [(step, self.dt / 2 if begins else self.dt)]
            if leg in stops:
                steps[leg].append((stops[leg], self.dt / 2))
        return steps

    def foot_from_com(self, leg: int) -> Any:
        """beta_i at the knot, (3, 1) m, base axes."""
        return self.model.foot_from_com(leg, self.feet_in_hip[:, leg], self.offset)

    def relative_yaw(self, leg: int) -> Any:
        """The foot's yaw against the base at the knot, rad, base axes."""
        return self.model.turn_mirrors[leg] * self.feet_in_hip[3, leg]

    def _placed(self, R: Any, position: Any, in_air: dict[int, Any]) -> tuple[Any, Any, Any]:
        """x (d, L), o (3, 1), and leg -> beta (d, 1) of the feet that stand.

        Args:
            R, position: of base and CoM.
            in_air: leg -> x_i of the feet that do not.
        """
        standing = [leg for leg in range(self.layout.legs) if leg not in in_air]
        r_base = self.lift(ca.mtimes(R.T, position))
        beta = {i: ca.mtimes(R.T, self.standing_feet[:, i]) - r_base for i in standing}
        if self.layout.foot_coordinates > 3:
            for i, direction in self._across(R, standing).items():
                beta[i] = ca.vertcat(beta[i], self.lift(relative_yaw(direction)))
        o = self.lift(self.model.offset_map(tuple(standing))(beta | in_air))
        x = [
            in_air[i] if i in in_air else self.lift(self.model.foot_in_hip(i, beta[i], o))
            for i in range(self.layout.legs)
        ]
        return ca.horzcat(*x), o, beta

    def _across(self, R: Any, legs: list[int]) -> dict[int, Any]:
        """Leg -> the direction across its standing foot, (3, 1) in base axes; none of points."""
        if self.layout.foot_coordinates == 3:
            return {}
        return {leg: self.lift(across(R, self.standing_yaw[leg])) for leg in legs}

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
        """(3, standing contacts) in m g / contacts."""
        return ca.reshape(self.symbols["force"], 3, -1)

    @cached_property
    def _points(self) -> list[int]:
        """Columns of `standing_contacts` at which `force` acts."""
        corners = self.layout.corners
        return [leg * corners + c for leg in self.role.standing for c in range(corners)]

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
        moments = (
            ca.cross(points[:, point], self.force[:, j]) for j, point in enumerate(self._points)
        )
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
    def position_mid(self) -> Any:
        """The CoM at the midpoint, (3, 1) m."""
        return self.lift(
            self.position + self.velocity * self.dt / 2 + self.acceleration * self.dt**2 / 8
        )

    @cached_property
    def feet_mid(self) -> tuple[Any, Any, Any, Any]:
        """x (d, L), xdot (d, L), o (3, 1) and odot (3, 1) at the midpoint."""
        R, legs, model = self.R_world_base_mid, range(self.layout.legs), self.model
        xdot, in_air = {}, {}
        if self.role.swinging:
            before = ca.horzcat(*(self.feet_velocity[i] for i in self.role.swinging))
            steps = ca.horzcat(*(self.feet_steps[i][0][0] for i in self.role.swinging))
            at_knot = ca.horzcat(*(self.feet_in_hip[:, i] for i in self.role.swinging))
            rate = self.lift(before + steps)
            place = self.lift(at_knot + rate * self.dt / 2)
            xdot = dict(zip(self.role.swinging, ca.horzsplit(rate), strict=True))
            in_air = dict(zip(self.role.swinging, ca.horzsplit(place), strict=True))
        if not self.role.standing:
            o_rate = self.lift(model.offset_map(()).rate(xdot))
            return place, rate, self.lift(model.base_offset(place)), o_rate
        x, o, beta = self._placed(R, self.position_mid, in_air)
        seen = {
            i: -self.velocity_mid_base - ca.cross(self.rotation_rate, b[:3])
            for i, b in beta.items()
        }
        for i, direction in self._across(R, list(beta)).items():
            turn = relative_yaw_rate(direction, self.rotation_rate)
            seen[i] = ca.vertcat(seen[i], turn)
        o_rate = self.lift(model.offset_map(tuple(beta)).rate(seen | xdot))
        for i, rate in seen.items():
            place_rate = ca.DM(model.mirrors[i]) * (rate[:3] - o_rate)
            xdot[i] = self.lift(ca.vertcat(place_rate, model.turn_mirrors[i] * rate[3:]))
        return x, ca.horzcat(*(xdot[i] for i in legs)), o, o_rate

    @cached_property
    def balance(self) -> Any:
        """(I omega + h + correction - R^T L) / m over an interval, (3, 1), BALANCE_SCALE m2/s."""
        x, xdot, o, _ = self.feet_mid
        momentum = self.model.angular_momentum(x, xdot, self.rotation_rate, o, self.lift)
        momentum = momentum / self.model.mass + self.correction
        return BALANCE_SCALE * (momentum - self.momentum_mean_base)

    @cached_property
    def foot_velocity_base(self) -> Any:
        """The swinging feet's mean velocity in the world, base axes, (3, swinging) m/s."""
        x, xdot, o, o_rate = self.feet_mid
        columns = []
        for i in self.role.swinging:
            beta = self.model.foot_from_com(i, x[:, i], o)
            beta_rate = o_rate + ca.DM(self.model.mirrors[i]) * xdot[:3, i]
            columns.append(
                self.lift(self.velocity_mid_base + ca.cross(self.rotation_rate, beta) + beta_rate)
            )
        return ca.horzcat(*columns)

    @cached_property
    def foot_turn(self) -> Any:
        """How fast the swinging feet turn in the world, mean over the interval, rad/s.

        (swinging, 1); empty for points.
        """
        if self.layout.foot_coordinates == 3:
            return ca.SX(0, 1)
        x, xdot, _, _ = self.feet_mid
        up = self.lift(self.R_world_base_mid[2, :].T)
        side = self.model.turn_mirrors
        rates = [
            heading_rate(up, side[i] * x[3, i], side[i] * xdot[3, i], self.rotation_rate)
            for i in self.role.swinging
        ]
        return ca.vertcat(*rates)

    @property
    def edge_legs(self) -> tuple[int, ...]:
        """Legs whose feet have just left or met the ground."""
        return tuple(sorted({*self.role.leaving, *self.role.landing}))

    @cached_property
    def foot_velocity_at_knot(self) -> Any:
        """Velocity of `edge_legs` in the world as the interval begins, base axes, (3, n) m/s."""
        velocity = self.lift(ca.mtimes(self.R_world_base.T, self.velocity))
        standing = [i for i in range(self.layout.legs) if i not in self.role.in_air]
        seen = {}
        if standing:
            beta = self._placed_at_knot[2]
            seen = {i: -velocity - ca.cross(self.rotation_rate, beta[i][:3]) for i in standing}
            for i, direction in self._across(self.R_world_base, standing).items():
                seen[i] = ca.vertcat(seen[i], relative_yaw_rate(direction, self.rotation_rate))
        o_rate = self.model.offset_map(tuple(standing)).rate(seen | self.feet_velocity)
        return ca.horzcat(
            *(
                velocity
                + ca.cross(self.rotation_rate, self.foot_from_com(i))
                + o_rate
                + ca.DM(self.model.mirrors[i]) * self.feet_velocity[i][:3]
                for i in self.edge_legs
            )
        )

    @cached_property
    def foot_turn_at_knot(self) -> Any:
        """How fast `edge_legs` turn in the world as the interval begins, (n, 1) rad/s.

        Empty for points.
        """
        if self.layout.foot_coordinates == 3:
            return ca.SX(0, 1)
        up, x, xdot = self.R_world_base[2, :].T, self.feet_in_hip, self.feet_velocity
        side = self.model.turn_mirrors
        return ca.vertcat(
            *(
                heading_rate(up, side[i] * x[3, i], side[i] * xdot[i][3], self.rotation_rate)
                for i in self.edge_legs
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
        """(n, L + settling) shares of what the drives give at rest.

        Of standing legs in the middle of the interval: what holds the contact forces and the leg's
        own weight, and what moves the leg. Of swinging legs what swings them as the interval
        begins; after all legs those that land at its end, as it ends.
        """
        starts, ends = [], []
        for leg in range(self.layout.legs):
            if leg in self.role.standing:
                starts.append(self._stance_torque(leg))
                continue
            (step, span), *stop = self.feet_steps[leg]
            x, before = self.feet_in_hip[:, leg], self.feet_velocity[leg]
            starts.append(self._swing_torque(leg, x, before + step / 2, step / span))
            if stop:
                (step, span), rate = stop[0], self.feet_mid[1][:, leg]
                x = x + rate * self.dt
                ends.append(self._swing_torque(leg, x, rate + step / 2, step / span))
        return ca.horzcat(*starts, *ends)

    def _swing_torque(self, leg: int, x: Any, x_rate: Any, x_acceleration: Any) -> Any:
        drives = self.model.drives
        x, x_rate, x_acceleration = map(self.lift, (x, x_rate, x_acceleration))
        joints = drives.legs[leg].accelerations(x, x_rate, x_acceleration)
        torque = ca.mtimes(ca.DM(drives.mass_matrix[leg]), joints)
        if self.role.in_contact:  # not falling freely: the leg has a weight
            torque += ca.mtimes(ca.DM(drives.weight[leg]), self._specific_force_base)
        if self.layout.turns:
            torque += ca.mtimes(ca.DM(drives.weight[leg]), self._turning_force(leg, x, x_rate))
        return self._share(leg, torque)

    def _turning_force(self, leg: int, x: Any, x_rate: Any) -> Any:
        """What a leg's CoM feels of the body's turning, (3, 1) m/s2: centrifugal and Coriolis."""
        model, omega = self.model, self.rotation_rate
        offset = self.feet_mid[2]
        com = self.lift(model.foot_from_com(leg, model.leg_com(leg, x), offset))
        rate = ca.DM(model.mirrors[leg]) * ca.jtimes(model.leg_com(leg, x), x, x_rate)
        return self.lift(ca.cross(omega, ca.cross(omega, com) + 2 * rate))

    def _stance_torque(self, leg: int) -> Any:
        x, xdot, _, _ = self.feet_mid
        drives = self.model.drives
        force, moment = self._load_on_foot(leg)
        torque = drives.legs[leg].holding_torque(x[:, leg], force, moment)
        torque = torque + ca.mtimes(ca.DM(drives.weight[leg]), self._specific_force_base)
        # The foot stands, so seen from the hip it accelerates as the body does, the other way.
        carried = self._acceleration_base
        if self.layout.turns:
            torque += ca.mtimes(
                ca.DM(drives.weight[leg]), self._turning_force(leg, x[:, leg], xdot[:, leg])
            )
            arm = self.model.foot_from_com(leg, x[:, leg], self.feet_mid[2])
            turned = 2 * self.velocity_mid_base + ca.cross(self.rotation_rate, arm)
            carried = carried - ca.cross(self.rotation_rate, turned)
        carried = -ca.DM(self.model.mirrors[leg]) * carried
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
        first = self.role.standing.index(leg) * corners
        mine = range(first, first + corners)
        total = sum(self.force[:, j] for j in mine)
        force = self.lift(ca.mtimes(R.T, total) * unit)
        if corners == 1:
            return force, None
        moments = (
            ca.cross(
                self.standing_contacts[:, self._points[j]] - self.standing_feet[:, leg],
                self.force[:, j],
            )
            for j in mine
        )
        return force, self.lift(ca.mtimes(R.T, sum(moments)) * unit)

    @cached_property
    def _specific_force_base(self) -> Any:
        return self.lift(ca.mtimes(self.R_world_base_mid.T, self._specific_force))

    # ---- dynamics

    def next_state(self, following: Role) -> Any:
        """The states at the next knot, of that role (eq. 8)."""
        dt = self.dt
        step = {
            "position": lambda: self.position + self.velocity * dt + self.acceleration * dt**2 / 2,
            "quat": lambda: quat_product(self._quat_mid, self._half_turn),
            "velocity": lambda: self.velocity + self.acceleration * dt,
            "momentum": lambda: self.momentum + self.moment * dt,
            "duration": lambda: self.symbols.get("next_duration", self.duration),
            "force": lambda: self._next_force(following),
            "feet": lambda: self._next_feet(following),
            "feet_velocity": lambda: self._next_feet_velocity(following),
            SHIFT: lambda: self.shift,
        }
        return ca.vertcat(*(step[name]() for name in self.layout.states(following)))

    def _next_force(self, following: Role) -> Any:
        new, now, steps = map(self.of_legs, ("next_force", "force", "force_step"))
        parts = []
        for leg in following.standing:
            if leg in now:
                parts.append(now[leg] + steps[leg] if leg in steps else now[leg])
            else:
                parts.append(new[leg])
        return ca.vertcat(*parts)

    def _next_feet(self, following: Role) -> Any:
        new, now, steps = map(self.of_legs, ("next_feet", "feet", "feet_step"))
        return ca.vertcat(
            *(
                now[leg] + (self.feet_velocity[leg] + steps[leg]) * self.dt
                if leg in steps
                else new[leg]
                for leg in following.in_air
            )
        )

    def _next_feet_velocity(self, following: Role) -> Any:
        new, steps, stops = map(self.of_legs, ("next_feet_velocity", "feet_step", "feet_stop"))
        parts = []
        for leg in following.in_air:
            if leg not in steps:
                parts.append(new[leg])
                continue
            velocity = self.feet_velocity[leg] + steps[leg]
            parts.append(velocity + stops[leg] if leg in stops else velocity)
        return ca.vertcat(*parts)
