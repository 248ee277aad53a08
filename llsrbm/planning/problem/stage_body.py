"""One stage's symbols, and what its body does: position, attitude, momentum and contact forces."""

from functools import cached_property
from typing import Any

import casadi as ca

from llsrbm.mechanics import GRAVITY
from llsrbm.models.arms import Carried
from llsrbm.planning.problem.layout import TURNED, Layout
from llsrbm.planning.problem.rotations import quat_exp, quat_product, rotation_matrix
from llsrbm.planning.problem.stage_places import StagePlaces


class StageBody(StagePlaces):
    """Symbols of a stage of one role; the body's motion and the contact forces.

    World frame unless a name says otherwise; angular momentum and moments divided by the mass.
    Accelerations over an interval are constant, so position, velocity and angular momentum are
    exact; the attitude uses the angular velocity at the interval's midpoint.
    """

    @staticmethod
    def local_sizes(layout: Layout) -> dict[str, int]:
        """Name -> number of scalars of a phase's parameters, in the order of `local`."""
        legs = layout.legs
        places = {"feet": 3 * legs, "contacts": 3 * layout.contacts, "yaw": legs}
        return places | {"towards": 2 * legs, "tilt": 2 * legs}

    def of_legs(self, name: str) -> dict[int, Any]:
        """Leg -> its part of a variable, (d, 1), or of a force, (3 corners, 1)."""
        legs = self.layout.legs_of(name, self.role)
        if not legs:
            return {}
        parts = ca.vertsplit(self._chosen_or_given(name), self._width(name))
        if name not in self.symbols:  # a parameter is of all legs, also of those that stand
            parts = [parts[leg] for leg in legs]
        return dict(zip(legs, parts, strict=True))

    def _chosen_or_given(self, name: str) -> Any:
        """A variable, or where it all begins a parameter."""
        return self.symbols[name] if name in self.symbols else self.parameters[f"start_{name}"]

    # ---- arms

    @cached_property
    def arm_angles(self) -> Any:
        """(A n, 1) rad at the knot; none of robots whose arms do not move."""
        return self._chosen_or_given("arms") if self.role.moves_arms else ca.SX(0, 1)

    @cached_property
    def arm_rates(self) -> Any:
        """(A n, 1) rad/s over the interval, even; at the end those of the one before."""
        if not self.role.moves_arms:
            return ca.SX(0, 1)
        return self.lift(self._arms_velocity + self.arm_step)

    @property
    def _arms_velocity(self) -> Any:
        """(A n, 1) rad/s over the interval before."""
        return self._chosen_or_given("arms_velocity")

    @property
    def arm_step(self) -> Any:
        """(A n, 1) rad/s: by how much they are faster than over the interval before."""
        return self.symbols.get("arms_step", ca.SX.zeros(self.layout.arm_joints))

    def arms_after(self, since: Any) -> Carried | None:
        """The free arms so long after the knot, s."""
        if self.model.arms is None:
            return None
        angles = self.lift(self.arm_angles + self.arm_rates * since)
        return self.model.arms.carried(angles, self.arm_rates, self.lift)

    @cached_property
    def arms_at_knot(self) -> Carried | None:
        """The free arms at the knot."""
        return self.arms_after(0)

    @cached_property
    def arms_mid(self) -> Carried | None:
        """The free arms at the interval's midpoint."""
        return self.arms_after(self.dt / 2)

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
        """Velocity of the CoM, (3, 1) m/s."""
        return self.symbols.get("velocity", self.parameters["start_velocity"])

    @property
    def momentum(self) -> Any:
        """L / m, (3, 1) m2/s."""
        return self.symbols.get("momentum", self.parameters.get("start_momentum", ca.SX.zeros(3)))

    @property
    def off_goal(self) -> Any:
        """(3, 1) m: how far the CoM is from where it is to end, above the feet it lands on."""
        return self.position - self.parameters["goal_position"] - ca.vertcat(self.shift, 0)

    @cached_property
    def R_world_base(self) -> Any:
        """At the knot, (3, 3)."""
        return self.lift(rotation_matrix(self.quat))

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
    def points(self) -> list[int]:
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
        """Acceleration of the CoM, (3, 1) m/s2 (eq. 1)."""
        return self._specific_force - ca.DM([0, 0, GRAVITY])

    @cached_property
    def _moment_about_origin(self) -> Any:
        points = self.standing_contacts
        moments = (
            ca.cross(points[:, point], self.force[:, j]) for j, point in enumerate(self.points)
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

    @property
    def rotation_acceleration(self) -> Any:
        """Angular acceleration of the base as the interval begins, with free arms, (3, 1) rad/s2,
        base axes.
        """
        before = self.symbols.get(TURNED, self.rotation_rate)
        return (self.rotation_rate - before) / self.dt

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
    def position_end(self) -> Any:
        """The CoM as the interval ends, (3, 1) m."""
        return self.position + self.velocity * self.dt + self.acceleration * self.dt**2 / 2

    @cached_property
    def velocity_end(self) -> Any:
        """The CoM's as the interval ends, (3, 1) m/s."""
        return self.velocity + self.acceleration * self.dt

    @cached_property
    def quat_end(self) -> Any:
        """q_world_base as the interval ends, (4, 1)."""
        return quat_product(self._quat_mid, self._half_turn)
