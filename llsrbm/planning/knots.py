"""A vector of all variables, unpacked: the planner's solution as arrays over the knots."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from llsrbm.analysis.joint_loads import JointLoads, KnotMotion, joint_loads
from llsrbm.models.base import CentroidalModel
from llsrbm.motion.plan import Phase
from llsrbm.planning.headings import heading_rates, headings, relative_yaw_rates, relative_yaws
from llsrbm.planning.layout import Layout
from llsrbm.planning.stage import GRAVITY
from llsrbm.planning.task import Task, contact_points
from llsrbm.postures import Postures, solve_postures

Array = NDArray[np.float64]


def rotations(quat_wxyz: Array) -> Array:
    """(K, 3, 3) R_world_base of (K, 4) quaternions w, x, y, z."""
    return Rotation.from_quat(quat_wxyz, scalar_first=True).as_matrix()


@dataclass(frozen=True, eq=False)
class Knots:
    """N + 1 knots and the N intervals between them; world frame, SI units.

    Attributes:
        durations: (3,) s.
        time: (N+1,) s; phase: (N+1,).
        position, velocity: (N+1, 3) m, m/s, CoM; quat: (N+1, 4); momentum: (N+1, 3) kg m2/s.
        force: (N+1, C, 3) N.
        rotation_rate: (N, 3) rad/s, base axes.
        flight_feet: (F+1, L, d) m, rad: x at the knots from lift-off to touchdown.
        flight_feet_velocity: (F+2, L, d) m/s, rad/s: xdot at lift-off, at rest on the ground, over
            each interval, and at touchdown, at rest again.
        near_angles: (N+1, J) joint angles close to the postures, where they are known.
    """

    task: Task
    model: CentroidalModel
    durations: Array
    time: Array
    phase: NDArray[np.int64]
    position: Array
    velocity: Array
    quat: Array
    momentum: Array
    force: Array
    rotation_rate: Array
    flight_feet: Array
    flight_feet_velocity: Array
    near_angles: Array | None = None

    @cached_property
    def R_world_base(self) -> Array:
        """(N+1, 3, 3)."""
        return rotations(self.quat)

    @cached_property
    def dt(self) -> Array:
        """(N,) s."""
        return np.diff(self.time)

    @cached_property
    def flight(self) -> slice:
        """Knots from lift-off to touchdown, both included."""
        first = int(np.argmax(self.phase == Phase.FLIGHT))
        return slice(first, first + len(self.flight_feet))

    @cached_property
    def in_contact(self) -> NDArray[np.bool_]:
        """(N,) whether forces act over the interval."""
        return self.phase[:-1] != Phase.FLIGHT

    @cached_property
    def acceleration(self) -> Array:
        """(N, 3) m/s2 of the CoM over each interval (eq. 1)."""
        return self.force[:-1].sum(axis=1) / self.task.mass - [0.0, 0.0, GRAVITY]

    @cached_property
    def standing_feet(self) -> Array:
        """(N+1, L, 3) m: where the feet stand, or stood last."""
        landed = (self.phase == Phase.LANDING)[:, None, None]
        return np.where(landed, self.task.goal_feet, self.task.start_feet)

    @cached_property
    def standing_yaw(self) -> Array:
        """(N+1, L) rad: where standing feet look, or looked last."""
        landed = (self.phase == Phase.LANDING)[:, None]
        return np.where(landed, self.task.goal_yaw, self.task.start_yaw)

    @cached_property
    def standing_contacts(self) -> Array:
        """(N+1, C, 3) m: contact points of standing feet, or where they were last."""
        landed = (self.phase == Phase.LANDING)[:, None, None]
        return np.where(landed, self.task.goal_contacts, self.task.start_contacts)

    @cached_property
    def feet_in_hip(self) -> Array:
        """(N+1, L, d) m, rad: x, from the variables in flight, from r and R in stance."""
        x = feet_in_stance(
            self.model, self.R_world_base, self.position, self.standing_feet, self.standing_yaw
        )
        x[self.flight] = self.flight_feet
        return x

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
        x = feet_in_stance(self.model, R, r, self.standing_feet[:-1], self.standing_yaw[:-1])
        beta_rate = -np.einsum("kji,kj->ki", R, v)[:, None] - np.cross(
            self.rotation_rate[:, None],
            np.einsum("kji,klj->kli", R, self.standing_feet[:-1] - r[:, None]),
        )
        if self.model.coordinates > 3:
            turn = relative_yaw_rates(R, self.standing_yaw[:-1], self.rotation_rate)
            beta_rate = np.concatenate([beta_rate, turn[..., None]], axis=-1)
        xdot = self.model.stance_rate(beta_rate)
        flight = slice(self.flight.start, self.flight.stop - 1)
        x[flight] = (self.flight_feet[:-1] + self.flight_feet[1:]) / 2
        xdot[flight] = self.flight_feet_rate
        return x, xdot

    @property
    def flight_feet_rate(self) -> Array:
        """(F, L, d) m/s, rad/s: xdot over the flight's intervals."""
        return self.flight_feet_velocity[1:-1]

    @cached_property
    def foot_velocity_at_rest(self) -> Array:
        """(2, L, d) m/s, rad/s at lift-off and touchdown, base axes: zero, and so are turns."""
        ends = [self.flight.start, self.flight.stop - 1]
        R, v, omega = self.R_world_base[ends], self.velocity[ends], self.rotation_rate[ends]
        x, xdot = self.flight_feet[[0, -1]], self.flight_feet_velocity[[0, -1]]
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
        feet = self.standing_feet.copy()
        inner = slice(self.flight.start + 1, self.flight.stop - 1)
        feet[inner] = self.flying_feet[1:-1]
        return feet

    @cached_property
    def flying_feet(self) -> Array:
        """(F+1, L, 3) m: the feet's places from lift-off to touchdown, as the model sees them."""
        at = self.flight
        offset, x = self.evaluated[0][at], self.flight_feet[..., :3]
        beta = offset[:, None] + self.model.hips + self.model.mirrors * x
        return self.position[at, None] + np.einsum("kij,klj->kli", self.R_world_base[at], beta)

    @cached_property
    def flying_headings(self) -> Array:
        """(F+1, L) rad: where the feet look from lift-off to touchdown, continuous in time."""
        if self.model.coordinates == 3:
            return np.zeros(self.flight_feet.shape[:2])
        yaw = self.model.turn_mirrors * self.flight_feet[..., 3]
        found = headings(self.R_world_base[self.flight], yaw)
        # atan2 knows no whole turns, the start's heading does.
        return found + 2 * np.pi * np.round((self.task.start_yaw - found[0]) / (2 * np.pi))

    @cached_property
    def foot_heading(self) -> Array:
        """(N+1, L) rad: as the plan has them in flight, as they stand in contact."""
        yaw = self.standing_yaw.copy()
        yaw[self.flight.start + 1 : self.flight.stop - 1] = self.flying_headings[1:-1]
        return yaw

    @cached_property
    def contact_point(self) -> Array:
        """(N+1, C, 3) m: corners of the feet, wherever they are."""
        return contact_points(self.foot_position, self.foot_heading, self.task.corners)

    @cached_property
    def foot_velocity_base(self) -> Array:
        """(F, L, 3) m/s: the feet's velocity in the world over flight intervals, base axes."""
        R, _, v = self.mid
        x, xdot = self.feet_mid
        flight = slice(self.flight.start, self.flight.stop - 1)
        return self._foot_velocity(
            R[flight], v[flight], self.rotation_rate[flight], x[flight], xdot[flight]
        )

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
            phase=self.phase.astype(np.int64),
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


def feet_in_stance(
    model: CentroidalModel, R: Array, position: Array, feet: Array, yaw: Array
) -> Array:
    """x (K, L, d) m, rad of feet (K, L, 3) with headings (K, L), from R (K, 3, 3), r (K, 3)."""
    beta = np.einsum("kji,klj->kli", R, feet - position[:, None])
    if model.coordinates > 3:
        beta = np.concatenate([beta, relative_yaws(R, yaw)[..., None]], axis=-1)
    return model.stance_feet(beta)


def unpack(w: Array, layout: Layout, task: Task, model: CentroidalModel) -> Knots:
    """The variables w, in the layout's order and units, as `Knots`."""
    count = layout.knots
    force_unit = task.mass * GRAVITY / layout.contacts
    position, velocity = np.tile(task.start_position, (count, 1)), np.zeros((count, 3))
    quat, momentum = np.tile([1.0, 0, 0, 0], (count, 1)), np.zeros((count, 3))
    force = np.zeros((count, layout.contacts, 3))
    rate = np.zeros((count - 1, 3))
    feet, feet_velocity = [], []
    durations = np.zeros(3)
    for k, role in enumerate(layout.roles):
        value = {name: w[place] for name, place in layout.variables(k).items()}
        position[k] = value.get("position", position[k])
        quat[k] = value.get("quat", quat[k])
        velocity[k] = value.get("velocity", velocity[k])
        momentum[k] = value.get("momentum", momentum[k]) * task.mass
        if role.in_contact:
            force[k] = value["force"].reshape(-1, 3) * force_unit
        if "rotation_rate" in value:
            rate[k] = value["rotation_rate"]
        if "feet" in value:
            feet.append(value["feet"].reshape(layout.legs, -1))
            # The first landing knot's, after the last of the flight.
            if role.first:
                feet_velocity.append(value["feet_velocity"])
            if "feet_step" in value:
                feet_velocity.append(value["feet_velocity"] + value["feet_step"])
        if role.first:
            durations[role.phase] = value["duration"][0]
    phase = np.array([role.phase for role in layout.roles])
    starts = np.concatenate([[0.0], np.cumsum(durations)])
    return Knots(
        task=task,
        model=model,
        durations=durations,
        time=starts[phase] + layout.progress * durations[phase],
        phase=phase,
        position=position,
        velocity=velocity,
        quat=quat / np.linalg.norm(quat, axis=1, keepdims=True),
        momentum=momentum,
        force=force,
        rotation_rate=rate,
        flight_feet=np.array(feet),
        flight_feet_velocity=np.array(feet_velocity).reshape(len(feet_velocity), layout.legs, -1),
    )
