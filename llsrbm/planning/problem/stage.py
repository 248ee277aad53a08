"""One stage: symbols at a knot, and all that follows from them over the interval after it."""

from functools import cached_property
from typing import Any

import casadi as ca

from llsrbm.mechanics import GRAVITY
from llsrbm.models.arms import Carried
from llsrbm.planning.problem.layout import TURNED
from llsrbm.planning.problem.roles import Role
from llsrbm.planning.problem.rotations import direction
from llsrbm.planning.problem.stage_feet import StageFeet

BALANCE_SCALE = 10.0  # the momentum balance in 0.1 m2/s, about as large as the other rows


class Stage(StageFeet):
    """Symbolic quantities of one role, for constraints, costs and dynamics to pick from."""

    @cached_property
    def balance(self) -> Any:
        """(I omega + h + correction - R^T L) / m over an interval, (3, 1), BALANCE_SCALE m2/s."""
        x, xdot, o = self.feet_of_balance
        moving = x, xdot, self.rotation_rate, o, self.lift, self.arms_mid
        momentum = self.model.angular_momentum(*moving)
        momentum = momentum / self.model.mass + self.correction
        return BALANCE_SCALE * (momentum - self.momentum_mean_base)

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
    def edge_rates(self) -> Any:
        """q' of legs `at_edge` as their feet leave or have met the ground, (n, them)."""
        legs, rates = self.model.drives.legs, []
        for i in self.role.at_edge:
            x, xdot = self.feet_at_end if i in self.role.lifting_off else self.feet_at_begin
            rates.append(self.lift(legs[i].rates(x[:, i], xdot[:, i])))
        return ca.horzcat(*rates)

    @cached_property
    def joint_torques(self) -> Any:
        """(n, L + touching_down) shares of what the drives give at rest.

        Standing legs in the middle of the interval: what holds the contact forces and the leg's
        own weight, and what moves the leg. Swinging legs: what swings them as the interval
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

    @cached_property
    def arm_speeds(self) -> Any:
        """(A n, 1) shares of their limits; none of robots whose arms do not move."""
        arms = self.model.arms
        return ca.SX(0, 1) if arms is None else self.arm_rates / ca.DM(arms.speed_limit)

    @cached_property
    def arm_torques(self) -> Any:
        """(A n, 1) shares of what the arms' drives give at rest, as the interval begins."""
        arms = self.model.arms
        if arms is None:
            return ca.SX(0, 1)
        acceleration = self.lift(self.arm_step / self.dt)
        torque = arms.torques(
            self.arm_angles,
            self.lift(self._arms_velocity + self.arm_step / 2),
            acceleration,
            self.rotation_rate,
            self.lift(self.rotation_acceleration),
            self.lift(self._force_on_base(arms.carried(self.arm_angles, acceleration, self.lift))),
            self.lift,
        )
        return self.lift(torque / ca.DM(arms.torque_limit))

    def _force_on_base(self, arms: Carried) -> Any:
        """Specific force on the base's origin as the interval begins, base axes, (3, 1) m/s2.

        The CoM's, and how limbs move the CoM against the base: standing legs, which stay below,
        swinging ones and the arms. As a foot lands it is that of the flight before: half of the
        arms' step is made there.

        Args:
            arms: with their accelerations in place of their rates.
        """
        if self.role.landing:
            return self.model.offset_map(()).rate({}, arms)
        legs = {i: steps[0][0] / steps[0][1] for i, steps in self.feet_steps.items()}
        away = -self._acceleration_base
        still = ca.SX.zeros(self.layout.foot_coordinates - 3)
        legs |= {i: ca.vertcat(away, still) for i in self.role.standing}
        moved = self.model.offset_map(self.role.standing).rate(legs, arms)
        return self._specific_force_base + moved

    def _swing_torque(self, leg: int, x: Any, x_rate: Any, x_acceleration: Any) -> Any:
        drives = self.model.drives
        x, x_rate, x_acceleration = map(self.lift, (x, x_rate, x_acceleration))
        joints = drives.legs[leg].accelerations(x, x_rate, x_acceleration)
        torque = drives.effort(leg, drives.legs[leg].rates(x, x_rate), joints)
        if self.role.in_contact:  # not falling freely: the leg has a weight
            torque += ca.mtimes(ca.DM(drives.weight[leg]), self._specific_force_base)
        if self.layout.turns:
            torque += ca.mtimes(ca.DM(drives.weight[leg]), self._turning_force(leg, x, x_rate))
        return self._share(leg, torque)

    def _turning_force(self, leg: int, x: Any, x_rate: Any) -> Any:
        """Centrifugal and Coriolis acceleration of a leg's CoM in the turning body, (3, 1) m/s2."""
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
        return self._share(leg, torque + drives.effort(leg, self.joint_rates[:, leg], joints))

    def _share(self, leg: int, torque: Any) -> Any:
        return self.lift(torque / ca.DM(self.model.drives.torque_limit[leg]))

    @cached_property
    def _acceleration_base(self) -> Any:
        return self.lift(ca.mtimes(self.R_world_base_mid.T, self.acceleration))

    def _load_on_foot(self, leg: int) -> tuple[Any, Any]:
        """Force (3, 1) N on a standing foot and its moment (3, 1) Nm about its frame.

        In base axes; no moment of points, but of those that stand on balls.
        """
        R, corners = self.R_world_base_mid, self.layout.corners
        unit = self.model.mass * GRAVITY / self.layout.contacts
        first = self.role.standing.index(leg) * corners
        mine = range(first, first + corners)
        total = sum(self.force[:, j] for j in mine)
        force = self.lift(ca.mtimes(R.T, total) * unit)
        if corners == 1:
            lift = self.model.foot_lift
            return force, ca.cross(force, lift * R[2, :].T) if lift else None
        moments = (
            ca.cross(
                self.standing_contacts[:, self.points[j]] - self.standing_feet[:, leg],
                self.force[:, j],
            )
            for j in mine
        )
        return force, self.lift(ca.mtimes(R.T, sum(moments)) * unit)

    @cached_property
    def _specific_force_base(self) -> Any:
        return self.lift(ca.mtimes(self.R_world_base_mid.T, self._specific_force))

    # ---- quantities of a finished motion (`llsrbm.planning.problem.knots`)

    @property
    def inertia(self) -> Any:
        """Inertia of the model at the knot, (3, 3) kg m2, base axes."""
        return self.model.inertia(self.feet_in_hip, self.offset, self.arms_at_knot)

    @property
    def leg_com(self) -> Any:
        """CoMs of the model's legs at the knot, (3, L) m, seen from the CoM, base axes."""
        model, x = self.model, self.feet_in_hip
        coms = (model.leg_com(i, x[:, i]) for i in range(self.layout.legs))
        return ca.horzcat(*(model.foot_from_com(i, com, self.offset) for i, com in enumerate(coms)))

    @property
    def foot_position(self) -> Any:
        """(3, L) m: as the model sees feet that fly, where the others stand."""
        flying = self.role.flying
        return ca.horzcat(
            *(
                self.foot_place(i) if i in flying else self.standing_feet[:, i]
                for i in range(self.layout.legs)
            )
        )

    @property
    def foot_heading(self) -> Any:
        """(L, 1) rad: within half a turn of feet that fly, as the others stand; points 0."""
        headings = ca.vertsplit(self.standing_yaw)
        if self.layout.foot_coordinates > 3:
            for i in self.role.flying:
                ahead = direction(self.R_world_base, self.relative_yaw(i))
                headings[i] = ca.atan2(ahead[1], ahead[0])
        return ca.vertcat(*headings)

    @property
    def contact_force(self) -> Any:
        """(3, C) N of all contact points; zeros where feet swing."""
        force = ca.SX.zeros(3, self.layout.contacts)
        if self.role.in_contact:
            force[:, self.points] = self.force
        return force * (self.model.mass * GRAVITY / self.layout.contacts)

    # ---- dynamics

    def next_state(self, following: Role) -> Any:
        """The states at the next knot, of that role (eq. 8)."""
        step = {
            "position": lambda: self.position_end,
            "quat": lambda: self.quat_end,
            "velocity": lambda: self.velocity_end,
            "momentum": lambda: self.momentum + self.moment * self.dt,
            TURNED: lambda: self.rotation_rate,
            "arms": lambda: self.arm_angles + self.arm_rates * self.dt,
            "arms_velocity": lambda: self.arm_rates,
            "force": lambda: self._next_force(following),
            "feet": lambda: self._next_feet(following),
            "feet_velocity": lambda: self._next_feet_velocity(following),
        }
        # The others do not change, but where another value is chosen.
        return ca.vertcat(
            *(
                step[name]()
                if name in step
                else self.symbols.get(f"next_{name}", self.symbols.get(name))
                for name in self.layout.states(following)
            )
        )

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
