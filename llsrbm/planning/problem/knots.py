"""A vector of all variables, unpacked: the planner's solution as arrays over the knots."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from llsrbm.body.joint_loads import JointLoads, KnotMotion, joint_loads
from llsrbm.body.postures import Postures, solve_postures
from llsrbm.mechanics import GRAVITY
from llsrbm.models.base import CentroidalModel
from llsrbm.planning.problem.headings import (
    heading_rates,
    headings,
    relative_yaw_rates,
    relative_yaws,
)
from llsrbm.planning.problem.layout import SHIFT, Layout
from llsrbm.planning.problem.task import Task, contact_points

Array = NDArray[np.float64]


def rotations(quat_wxyz: Array) -> Array:
    """(K, 3, 3) R_world_base of (K, 4) quaternions w, x, y, z."""
    return Rotation.from_quat(quat_wxyz, scalar_first=True).as_matrix()


@dataclass(frozen=True, eq=False)
class Knots:
    """N + 1 knots and the N intervals between them; world frame, SI units.

    Attributes:
        layout: which feet stand where.
        durations: (P,) s.
        time: (N+1,) s.
        position, velocity: (N+1, 3) m, m/s, CoM; quat: (N+1, 4); momentum: (N+1, 3) kg m2/s.
        force: (N+1, C, 3) N.
        rotation_rate: (N, 3) rad/s, base axes.
        air_feet: (N+1, L, d) m, rad: x of feet in the air, lift-off and touchdown among it; NaN of
            the others.
        air_rate: (N, L, d) m/s, rad/s: xdot of swinging feet over the intervals; NaN of the others.
        knot_rate: (N+1, L, d): xdot of feet in the air just before a knot, at lift-off and
            touchdown that at rest on the ground; NaN of the others.
        shift: (2,) m: of where feet land, if it is a variable.
        near_angles: (N+1, J) joint angles close to the postures, where they are known.
    """

    task: Task
    model: CentroidalModel
    layout: Layout
    durations: Array
    time: Array
    position: Array
    velocity: Array
    quat: Array
    momentum: Array
    force: Array
    rotation_rate: Array
    air_feet: Array
    air_rate: Array
    knot_rate: Array
    shift: Array
    near_angles: Array | None = None

    @property
    def phase(self) -> NDArray[np.int64]:
        """(N+1,) of the schedule, of the interval that begins at a knot."""
        return self.layout.phase

    @cached_property
    def in_air(self) -> NDArray[np.bool_]:
        """(N+1, L) feet in the air, lift-off and touchdown among it."""
        return self._legs("in_air")

    @cached_property
    def flying(self) -> NDArray[np.bool_]:
        """(N+1, L) feet off the ground before and after a knot."""
        return self._legs("flying")

    @cached_property
    def swinging(self) -> NDArray[np.bool_]:
        """(N, L) feet that swing over an interval."""
        return ~self.layout.standing[:-1]

    @cached_property
    def swings_freely(self) -> NDArray[np.bool_]:
        """(N, L) likewise, without the interval that a motion under way begins with."""
        free = self.swinging.copy()
        free[0] = False
        return free

    @cached_property
    def at_edge(self) -> NDArray[np.bool_]:
        """(N+1, L) feet that leave or meet the ground at a knot."""
        return self._legs("leaving") | self._legs("landing")

    def _legs(self, name: str) -> NDArray[np.bool_]:
        mask = np.zeros((self.layout.knots, self.layout.legs), dtype=bool)
        for knot, role in enumerate(self.layout.roles):
            mask[knot, list(getattr(role, name))] = True
        return mask

    @cached_property
    def flights(self) -> tuple[slice, ...]:
        """The intervals of each flight; `stop` is the knot of touchdown."""
        first = self.layout.first_knots
        return tuple(slice(int(first[p]), int(first[p + 1])) for p in self.task.schedule.flights)

    @cached_property
    def R_world_base(self) -> Array:
        """(N+1, 3, 3)."""
        return rotations(self.quat)

    @cached_property
    def dt(self) -> Array:
        """(N,) s."""
        return np.diff(self.time)

    @cached_property
    def acceleration(self) -> Array:
        """(N, 3) m/s2 of the CoM over each interval (eq. 1)."""
        return self.force[:-1].sum(axis=1) / self.task.mass - [0.0, 0.0, GRAVITY]

    @cached_property
    def standing_feet(self) -> Array:
        """(N+1, L, 3) m: where the feet stand, or stood last."""
        return self._shifted(self._stood("feet"))

    @cached_property
    def standing_yaw(self) -> Array:
        """(N+1, L) rad: where standing feet look, or looked last."""
        return self._stood("yaw")

    @cached_property
    def standing_contacts(self) -> Array:
        """(N+1, C, 3) m: contact points of standing feet, or where they were last."""
        return self._shifted(self._stood("contacts"))

    def _shifted(self, places: Array) -> Array:
        """Places (N+1, n, 3) m, in stances that are shifted."""
        moved = np.array([role.shifted for role in self.layout.roles])
        return places + moved[:, None, None] * np.append(self.shift, 0.0)

    def _stood(self, name: str) -> Array:
        phases = range(len(self.task.schedule))
        of_phases: Array = np.array([getattr(self.task.stood(p), name) for p in phases])
        return of_phases[self.phase]

    @cached_property
    def feet_in_hip(self) -> Array:
        """(N+1, L, d) m, rad: x, variables in the air, from r and R on the ground."""
        beta = feet_from_com(
            self.model, self.R_world_base, self.position, self.standing_feet, self.standing_yaw
        )
        given = np.where(self.in_air[..., None], self.air_feet, beta)
        return self.model.feet_of(given, ~self.in_air)

    @cached_property
    def mid(self) -> tuple[Array, Array, Array]:
        """R (N, 3, 3), r (N, 3), v (N, 3) at the intervals' midpoints."""
        half = self.dt[:, None] / 2
        turn = Rotation.from_rotvec(self.rotation_rate * half).as_matrix()
        v, a = self.velocity[:-1], self.acceleration
        return (
            self.R_world_base[:-1] @ turn,
            self.position[:-1] + v * half + a * half**2 / 2,
            v + a * half,
        )

    @cached_property
    def momentum_mid(self) -> Array:
        """(N, 3) kg m2/s: L at the intervals' midpoints."""
        dt = self.dt[:, None]
        r, v, a = self.position[:-1], self.velocity[:-1], self.acceleration
        return self.momentum[:-1] + dt / 2 * self.moment_about(r + v * dt / 4 + a * dt**2 / 24)

    @cached_property
    def momentum_mean(self) -> Array:
        """(N, 3) kg m2/s: the mean of L over each interval."""
        dt = self.dt[:, None]
        r, v, a = self.position[:-1], self.velocity[:-1], self.acceleration
        return self.momentum[:-1] + dt / 2 * self.moment_about(r + v * dt / 3 + a * dt**2 / 12)

    @cached_property
    def momentum_step(self) -> Array:
        """(N, 3) kg m2/s: what the contact forces add to L over each interval."""
        dt = self.dt[:, None]
        r, v, a = self.position[:-1], self.velocity[:-1], self.acceleration
        return dt * self.moment_about(r + v * dt / 2 + a * dt**2 / 6)

    def moment_about(self, point: Array) -> Array:
        """(N, 3) Nm: the contact forces' moment about a point an interval, (N, 3) m."""
        arms = self.standing_contacts[:-1] - point[:, None]
        return np.cross(arms, self.force[:-1]).sum(axis=1)

    @cached_property
    def feet_mid(self) -> tuple[Array, Array]:
        """x and xdot (N, L, d) at the midpoints."""
        R, r, v = self.mid
        feet, yaw = self.standing_feet[:-1], self.standing_yaw[:-1]
        swings = self.swinging[..., None]
        beta = feet_from_com(self.model, R, r, feet, yaw)
        middle = self.air_feet[:-1] + self.air_rate * self.dt[:, None, None] / 2
        x = self.model.feet_of(np.where(swings, middle, beta), ~self.swinging)
        seen = feet_rate_from_com(self.model, R, v, self.rotation_rate, feet - r[:, None], yaw)
        rate = self.model.feet_rate_of(np.where(swings, self.air_rate, seen), ~self.swinging)
        return x, rate

    @cached_property
    def foot_velocity_at_knots(self) -> Array:
        """(N, L, d) m/s, rad/s, base axes: as an interval begins, at lift-off and touchdown zero.

        Of feet that stand it means nothing.
        """
        R, v, omega = self.R_world_base[:-1], self.velocity[:-1], self.rotation_rate
        arms = self.standing_feet[:-1] - self.position[:-1, None]
        seen = feet_rate_from_com(self.model, R, v, omega, arms, self.standing_yaw[:-1])
        in_air = self.in_air[:-1]
        given = np.where(in_air[..., None], self.knot_rate[:-1], seen)
        xdot = self.model.feet_rate_of(given, ~in_air)
        x = self.feet_in_hip[:-1]
        velocity = self._foot_velocity(R, v, omega, x, xdot)
        if self.model.coordinates == 3:
            return velocity
        side = self.model.turn_mirrors
        turn = heading_rates(R, side * x[..., 3], side * xdot[..., 3], omega)
        return np.concatenate([velocity, turn[..., None]], axis=-1)

    def _foot_velocity(self, R: Array, v: Array, omega: Array, x: Array, xdot: Array) -> Array:
        """(K, L, 3) m/s in the world, base axes, of R (K, 3, 3), v, omega (K, 3), x, xdot."""
        offset, offset_rate = self.model.offsets(x, xdot)
        mirrors = self.model.mirrors
        beta = offset[:, None] + self.model.hips + mirrors * x[..., :3]
        return (
            np.einsum("kji,kj->ki", R, v)[:, None]
            + np.cross(omega[:, None], beta)
            + offset_rate[:, None]
            + mirrors * xdot[..., :3]
        )

    @cached_property
    def evaluated(self) -> tuple[Array, Array, Array]:
        """Offset (N+1, 3), inertia (N+1, 3, 3) and leg CoMs (N+1, L, 3) at the knots, base axes."""
        return self.model.evaluate(self.feet_in_hip)

    @cached_property
    def foot_position(self) -> Array:
        """(N+1, L, 3) m, as the model sees them in flight, where they stand in contact."""
        return np.where(self.flying[..., None], self.model_feet, self.standing_feet)

    @cached_property
    def model_feet(self) -> Array:
        """(N+1, L, 3) m: the feet's places as the model sees them."""
        beta = (
            self.evaluated[0][:, None]
            + self.model.hips
            + self.model.mirrors * self.feet_in_hip[..., :3]
        )
        return self.position[:, None] + np.einsum("kij,klj->kli", self.R_world_base, beta)

    @cached_property
    def model_headings(self) -> Array:
        """(N+1, L) rad: where the feet look as the model sees them, in each swing continuous."""
        if self.model.coordinates == 3:
            return np.zeros(self.air_feet.shape[:2])
        yaw = self.model.turn_mirrors * self.feet_in_hip[..., 3]
        found = headings(self.R_world_base, yaw)
        for leg, lift, touch in self.layout.swings:
            # atan2 knows no whole turns, the heading that it starts from does.
            turns = (self.standing_yaw[lift, leg] - found[lift, leg]) / (2 * np.pi)
            found[lift : touch + 1, leg] += 2 * np.pi * np.round(turns)
        return found

    @cached_property
    def foot_heading(self) -> Array:
        """(N+1, L) rad: as the plan has them in flight, as they stand in contact."""
        return np.where(self.flying, self.model_headings, self.standing_yaw)

    @cached_property
    def contact_point(self) -> Array:
        """(N+1, C, 3) m: corners of the feet, wherever they are."""
        return contact_points(self.foot_position, self.foot_heading, self.task.corners)

    @cached_property
    def foot_velocity_base(self) -> Array:
        """(N, L, 3) m/s: the feet's velocity in the world over the intervals, base axes."""
        R, _, v = self.mid
        return self._foot_velocity(R, v, self.rotation_rate, *self.feet_mid)

    @cached_property
    def foot_quat(self) -> Array:
        """(N+1, L, 4) w, x, y, z: of level feet with their headings."""
        half = self.foot_heading / 2
        zero = np.zeros_like(half)
        return np.stack([np.cos(half), zero, zero, np.sin(half)], axis=-1)

    @cached_property
    def postures(self) -> Postures:
        """The whole body's, that realise the plan at the knots."""
        return solve_postures(
            self.task.robot,
            self.position,
            self.quat,
            self.foot_position,
            self.foot_quat,
            near=self.near_angles,
        )

    @cached_property
    def loads(self) -> JointLoads:
        """What the joints have to do in these postures, by Pinocchio."""
        motion = KnotMotion(
            time=self.time,
            schedule=self.task.schedule,
            phase=self.phase,
            com=self.position,
            com_velocity=self.velocity,
            base_quat=self.quat,
            foot_position=self.foot_position,
            foot_quat=self.foot_quat,
            contact_point=self.contact_point,
            contact_force=self.force,
            joint_position=self.postures.joint_position,
        )
        return joint_loads(self.task.robot, motion)

    def under(self, task: Task) -> Knots:
        """The same motion under other limits; postures and loads are not computed again."""
        other = replace(self, task=task)
        for name in ("postures", "loads"):
            if name in vars(self):
                vars(other)[name] = vars(self)[name]
        return other


def rolled_out(knots: Knots) -> Knots:
    """The same forces and rates, with r, H and L integrated from the start, exactly.

    A solver leaves defects of its tolerance; so they all show at the end, against the target.
    """
    dt = knots.dt[:, None]
    a = knots.acceleration
    velocity = knots.velocity[0] + np.vstack([np.zeros(3), np.cumsum(a * dt, axis=0)])
    steps = velocity[:-1] * dt + a * dt**2 / 2
    position = knots.position[0] + np.vstack([np.zeros(3), np.cumsum(steps, axis=0)])
    moved = replace(knots, position=position, velocity=velocity)
    turns = np.cumsum(moved.momentum_step, axis=0)
    return replace(moved, momentum=knots.momentum[0] + np.vstack([np.zeros(3), turns]))


def feet_from_com(
    model: CentroidalModel, R: Array, position: Array, feet: Array, yaw: Array
) -> Array:
    """beta (K, L, d) m, rad of feet (K, L, 3) with headings (K, L), from R (K, 3, 3), r (K, 3)."""
    beta = np.einsum("kji,klj->kli", R, feet - position[:, None])
    if model.coordinates == 3:
        return beta
    return np.concatenate([beta, relative_yaws(R, yaw)[..., None]], axis=-1)


def feet_rate_from_com(
    model: CentroidalModel, R: Array, velocity: Array, omega: Array, arms: Array, yaw: Array
) -> Array:
    """betadot (K, L, d) m/s, rad/s of feet that stand.

    Args:
        model: how many coordinates a foot has.
        R: (K, 3, 3); velocity: (K, 3) m/s of the CoM; omega: (K, 3) rad/s, base axes.
        arms: (K, L, 3) m, from the CoM, world axes; yaw: (K, L) rad.
    """
    rate: Array = -np.einsum("kji,kj->ki", R, velocity)[:, None] - np.cross(
        omega[:, None], np.einsum("kji,klj->kli", R, arms)
    )
    if model.coordinates == 3:
        return rate
    return np.concatenate([rate, relative_yaw_rates(R, yaw, omega)[..., None]], axis=-1)


def unpack(w: Array, layout: Layout, task: Task, model: CentroidalModel) -> Knots:
    """The variables w, in the layout's order and units, as `Knots`."""
    count, d = layout.knots, layout.foot_coordinates
    force_unit = task.mass * GRAVITY / layout.contacts
    position, velocity = (
        np.tile(start, (count, 1)) for start in (task.start_position, task.start_velocity)
    )
    quat, momentum = (
        np.tile(start, (count, 1)) for start in (task.start_quat, task.start_momentum)
    )
    force = np.zeros((count, layout.contacts, 3))
    rate = np.zeros((count - 1, 3))
    air_feet, knot_rate = np.full((2, count, layout.legs, d), np.nan)
    air_rate = np.full((count - 1, layout.legs, d), np.nan)
    durations = np.zeros(layout.phases)
    for k, role in enumerate(layout.roles):
        value = {name: w[place] for name, place in layout.variables(k).items()}
        position[k] = value.get("position", position[k])
        quat[k] = value.get("quat", quat[k])
        velocity[k] = value.get("velocity", velocity[k])
        if "momentum" in value:
            momentum[k] = value["momentum"] * task.mass
        if role.in_contact:
            of_legs = force[k].reshape(layout.legs, layout.corners, 3)
            standing = list(role.standing)
            of_legs[standing] = value["force"].reshape(-1, layout.corners, 3) * force_unit
        if "rotation_rate" in value:
            rate[k] = value["rotation_rate"]
        if role.in_air and not role.terminal:
            in_air = list(role.in_air)
            for into, name in ((air_feet, "feet"), (knot_rate, "feet_velocity")):
                found = value[name] if name in value else getattr(task.motion, name)
                into[k, in_air] = found.reshape(-1, d)
        if "feet_step" in value:
            swinging = list(role.swinging)
            air_rate[k, swinging] = knot_rate[k, swinging] + value["feet_step"].reshape(-1, d)
        if role.first:
            durations[role.phase] = value["duration"][0]
    starts = np.concatenate([[0.0], np.cumsum(durations)])
    return Knots(
        task=task,
        model=model,
        layout=layout,
        durations=durations,
        time=starts[layout.phase] + layout.progress * durations[layout.phase],
        position=position,
        velocity=velocity,
        quat=quat / np.linalg.norm(quat, axis=1, keepdims=True),
        momentum=momentum,
        force=force,
        rotation_rate=rate,
        air_feet=air_feet,
        air_rate=air_rate,
        knot_rate=knot_rate,
        shift=value.get(SHIFT, np.zeros(2)),
    )
