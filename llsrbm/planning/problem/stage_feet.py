"""Feet of one stage: where they are seen from the body, and how they move."""

from functools import cached_property
from typing import Any

import casadi as ca

from llsrbm.models.arms import Carried
from llsrbm.planning.problem.rotations import (
    across,
    heading_rate,
    relative_yaw,
    relative_yaw_rate,
    rotation_matrix,
)
from llsrbm.planning.problem.stage_body import StageBody


class StageFeet(StageBody):
    """Places and velocities of the feet at the knot and over the interval after it."""

    # ---- at the knot

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
            return self.lift(self.model.base_offset(self.feet_in_hip, self.arms_at_knot))
        return self._placed_at_knot[1]

    @cached_property
    def _placed_at_knot(self) -> tuple[Any, Any, dict[int, Any]]:
        feet, arms = self.of_legs("feet"), self.arms_at_knot
        return self._placed(self.R_world_base, self.position, feet, arms)

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

    def foot_place(self, leg: int) -> Any:
        """A foot's lowest point at the knot, the middle of a sole, (3, 1) m in the world."""
        lift = ca.DM([0, 0, self.model.foot_lift])
        return self.position + ca.mtimes(self.R_world_base, self.foot_from_com(leg)) - lift

    def relative_yaw(self, leg: int) -> Any:
        """The foot's yaw against the base at the knot, rad, base axes."""
        return self.model.turn_mirrors[leg] * self.feet_in_hip[3, leg]

    def _placed(
        self, R: Any, position: Any, in_air: dict[int, Any], arms: Carried | None
    ) -> tuple[Any, Any, Any]:
        """x (d, L), o (3, 1), and leg -> beta (d, 1) of the feet that stand.

        Args:
            R, position: of base and CoM.
            in_air: leg -> x_i of the feet that do not.
            arms: if they are free.
        """
        standing = [leg for leg in range(self.layout.legs) if leg not in in_air]
        lift = ca.vertcat(0, 0, self.model.foot_lift)
        r_base = self.lift(ca.mtimes(R.T, position - lift))
        beta = {i: ca.mtimes(R.T, self.standing_feet[:, i]) - r_base for i in standing}
        if self.layout.foot_coordinates > 3:
            for i, direction in self._across(R, standing).items():
                beta[i] = ca.vertcat(beta[i], self.lift(relative_yaw(direction)))
        o = self.lift(self.model.offset_map(tuple(standing))(beta | in_air, arms))
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

    @cached_property
    def feet_mid(self) -> tuple[Any, Any, Any, Any]:
        """x (d, L), xdot (d, L), o (3, 1) and odot (3, 1) at the midpoint."""
        body = self.R_world_base_mid, self.position_mid, self.velocity_mid_base, self.rotation_rate
        return self._moving(*body, self.dt / 2, self.arms_mid)

    @cached_property
    def feet_of_balance(self) -> tuple[Any, Any, Any]:
        """x (d, L), xdot (d, L) and o (3, 1) of which the momentum balance is.

        They are those of the midpoint. Where feet leave or land, rows that have them at rest in
        the world follow from omega, thus from the balance. If legs have no momentum of their own,
        the balance depends on what swings them by 1e-5 alone, through where they get to, and
        Fatrop takes that for a pivot: there it is of feet that go on as fast as they were.
        """
        x, xdot, o, _ = self.feet_mid
        if self.model.swinging_turns_base or not self.edge_legs:
            return x, xdot, o
        in_air = {
            leg: self.lift(self.feet_in_hip[:, leg] + self.feet_velocity[leg] * self.dt / 2)
            for leg in self.role.swinging
        }
        x, o, _ = self._placed(self.R_world_base_mid, self.position_mid, in_air, self.arms_mid)
        return x, xdot, o

    @cached_property
    def feet_at_begin(self) -> tuple[Any, Any]:
        """x and xdot, (d, L), as the interval begins; a foot that lands here stands already."""
        R = self.R_world_base
        velocity, rate = ca.mtimes(R.T, self.velocity), self._rotation_rate_at(R, self.momentum)
        velocity, rate = self.lift(velocity), self.lift(rate)
        return self._moving(R, self.position, velocity, rate, 0, self.arms_at_knot)[:2]

    @cached_property
    def feet_at_end(self) -> tuple[Any, Any]:
        """Likewise as it ends; a foot that leaves there still stands."""
        R = self.lift(rotation_matrix(self.lift(self.quat_end)))
        momentum = self.momentum + self.moment * self.dt
        velocity, rate = ca.mtimes(R.T, self.velocity_end), self._rotation_rate_at(R, momentum)
        velocity, rate = self.lift(velocity), self.lift(rate)
        position, arms = self.lift(self.position_end), self.arms_after(self.dt)
        return self._moving(R, position, velocity, rate, self.dt, arms)[:2]

    def _rotation_rate_at(self, R: Any, momentum: Any) -> Any:
        """omega of the base at an end of the interval, (3, 1) rad/s, base axes.

        While feet push it changes as the angular momentum does; what the legs' own part of that
        changes is left out.

        Args:
            R: of the base, at that end.
            momentum: L / m there, (3, 1) m2/s.
        """
        x, _, o, _ = self.feet_mid
        inertia = self.lift(self.model.inertia(x, o, self.arms_mid) / self.model.mass)
        change = self.lift(ca.mtimes(R.T, momentum) - self.momentum_mean_base)
        return self.rotation_rate + ca.mtimes(ca.inv_minor(inertia), change)

    def _moving(
        self,
        R: Any,
        position: Any,
        velocity: Any,
        turning: Any,
        since: Any,
        arms: Carried | None,
    ) -> tuple[Any, ...]:
        """x (d, L), xdot (d, L), o (3, 1) and odot (3, 1) at an instant of the interval.

        Args:
            R, position: of base and CoM at that instant.
            velocity, turning: of the CoM, and omega of the base, base axes.
            since: time since the knot, s.
            arms: if they are free.
        """
        legs, model = range(self.layout.legs), self.model
        xdot, in_air = {}, {}
        if self.role.swinging:
            before = ca.horzcat(*(self.feet_velocity[i] for i in self.role.swinging))
            steps = ca.horzcat(*(self.feet_steps[i][0][0] for i in self.role.swinging))
            at_knot = ca.horzcat(*(self.feet_in_hip[:, i] for i in self.role.swinging))
            rate = self.lift(before + steps)
            place = self.lift(at_knot + rate * since)
            xdot = dict(zip(self.role.swinging, ca.horzsplit(rate), strict=True))
            in_air = dict(zip(self.role.swinging, ca.horzsplit(place), strict=True))
        if not self.role.standing:
            o_rate = self.lift(model.offset_map(()).rate(xdot, arms))
            return place, rate, self.lift(model.base_offset(place, arms)), o_rate
        x, o, beta = self._placed(R, position, in_air, arms)
        seen = {i: -velocity - ca.cross(turning, b[:3]) for i, b in beta.items()}
        for i, direction in self._across(R, list(beta)).items():
            turn = relative_yaw_rate(direction, turning)
            seen[i] = ca.vertcat(seen[i], turn)
        o_rate = self.lift(model.offset_map(tuple(beta)).rate(seen | xdot, arms))
        for i, rate in seen.items():
            xdot[i] = self.lift(model.foot_rate_in_hip(i, rate, o_rate))
        return x, ca.horzcat(*(xdot[i] for i in legs)), o, o_rate

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
        """Turning rate of the swinging feet in the world, mean over the interval, rad/s.

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
        rates = seen | self.feet_velocity
        o_rate = self.model.offset_map(tuple(standing)).rate(rates, self.arms_at_knot)
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
        """Turning rate of `edge_legs` in the world as the interval begins, (n, 1) rad/s.

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
