"""Any motion at 1 kHz: states, accelerations, forces and torques, as far as they are known.

A plan is sampled as exports sample it (`llsrbm.motion.sampling`), and on both sides of each knot,
where accelerations and forces jump; a rollout and a foreign motion are straight between their
instants, which are sampled as well. Accelerations are differences of the velocities over ten
microseconds that lie within one interval.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import pinocchio as pin
from scipy.spatial.transform import Rotation, Slerp

from llsrbm.arrays import Array, BoolArray
from llsrbm.body.efforts import inverse_dynamics, of_contacts
from llsrbm.errors import InputError
from llsrbm.motion.grounds import foot_normals
from llsrbm.motion.plan import Plan
from llsrbm.motion.realised import realised_states
from llsrbm.motion.robot import robot_of
from llsrbm.motion.rollout import Rollout
from llsrbm.motion.sampling import resample
from llsrbm.motion.whole_body import WholeBodyMotion, motion_at, pinocchio_states
from llsrbm.robots import Robot
from llsrbm.robots.drives.torques import friction_torque
from llsrbm.robots.placements import placements

AnyMotion = Plan | Rollout | WholeBodyMotion

RATE = 1000.0  # Hz
AT_ONCE = 1000  # instants of a stretch: places of all links take ten times as much memory as states
_FIRST = 3e-4  # s: the first instant; with it none falls on a tick of 400, 500 or 1000 Hz
_STEP = 5e-6  # s to either side, of differences
_BESIDE = 1e-5  # s from a knot: what is known on that side of it

NO_FORCES = "the motion has no contact forces"
NO_TORQUES = "the motion has no torques, and without contact forces none follow"


@dataclass(frozen=True, eq=False)
class SampledMotion:
    """A motion at K instants; L legs of c contacts, J joints in `Robot.joint_names`' order.

    Attributes:
        source: the motion; robot: that moves.
        model: Pinocchio's, with the trunk's mass as simulated.
        time: (K,) s of the motion's own time.
        q, v, a: (K, nq), (K, nv), (K, nv) in Pinocchio's convention, SI units.
        contact: (K, L) whether a foot stands.
        points, forces: (K, L, c, 3) m, N, world frame; None: not known.
        recorded_torque: (K, J) Nm or N; None: torque follows from the forces.
        friction: coefficient that feet have; whole_feet: whether a force is the sum over a foot,
            which acts somewhere in its sole.
        mean_joint_velocity: (K, J) rad/s or m/s from the frame before to the frame after, which the
            joint has at some instant in between; None: `v` has all that is known.
    """

    source: AnyMotion
    robot: Robot
    model: pin.Model
    time: Array
    q: Array
    v: Array
    a: Array
    contact: BoolArray
    points: Array | None
    forces: Array | None
    recorded_torque: Array | None
    friction: float
    whole_feet: bool
    mean_joint_velocity: Array | None = None

    @staticmethod
    def of(motion: Plan | Rollout, robot: Robot | None = None) -> SampledMotion:
        """Sample the whole of a motion; `robot`: the one that a plan names, with other drives.

        Raises as `sampled`.
        """
        if isinstance(motion, Plan):
            return _of_plan(motion, robot or robot_of(motion))
        return _of_rollout(motion)

    def stretches(self) -> Iterator[SampledMotion]:
        """It in stretches, each from the last instant of the one before."""
        per_instant = ("time", "q", "v", "a", "contact", "points", "forces", "recorded_torque")
        for part in _parts(len(self.time)):
            own: dict[str, Any] = {}
            for name in per_instant:
                values = getattr(self, name)
                own[name] = None if values is None else values[part]
            yield replace(self, **own)

    @property
    def joint_position(self) -> Array:
        """(K, J) rad or m."""
        return self.q[:, 7:]

    @property
    def joint_velocity(self) -> Array:
        """(K, J) rad/s or m/s."""
        return self.v[:, 6:]

    @property
    def lost(self) -> int | None:
        """The number of the first instant at which the state is no number; None: there is none."""
        missing = ~np.isfinite(self.q).all(axis=1)
        return int(missing.argmax()) if missing.any() else None

    @cached_property
    def normals(self) -> Array:
        """(K, L, 3) unit normals of what the feet stand on; of foreign motions it is level."""
        plan = self.source.plan if isinstance(self.source, Rollout) else self.source
        if isinstance(plan, Plan):
            return foot_normals(plan, self.time)
        return np.broadcast_to([0.0, 0.0, 1.0], (*self.contact.shape, 3))

    @cached_property
    def weight(self) -> float:
        """N."""
        return float(pin.computeTotalMass(self.model)) * abs(float(self.model.gravity.linear[2]))

    @cached_property
    def effort(self) -> Array | None:
        """(K, nv) N, Nm: generalised forces beside those of the contacts; None: not known.

        M(q) a + h(q, v) - J^T f: six rows of the base, which has no drive, base axes, and the
        joints' torques.
        """
        if self.points is None or self.forces is None:
            return None
        contacts = of_contacts(self.robot, self.placed, self.points, self.forces)
        return inverse_dynamics(self.model, self.q, self.v, self.a) - contacts

    @cached_property
    def placed(self) -> tuple[Array, Array]:
        """Turns (K, joints, 3, 3) and origins (K, joints, 3) m of all joints, world."""
        return placements(self.model, self.q)

    @cached_property
    def torque(self) -> Array | None:
        """(K, J) Nm or N of the drives: recorded, or by inverse dynamics; None: not known."""
        if self.recorded_torque is not None or self.effort is None:
            return self.recorded_torque
        return self.effort[:, 6:] + friction_torque(self.robot, self.joint_velocity)


def sampled(motion: AnyMotion, robot: Robot | None = None) -> Iterator[SampledMotion]:
    """A motion in stretches, each from the last instant of the one before.

    Other tools' motions, which may last for minutes, are sampled stretch by stretch, so that the
    memory this takes does not grow with their length. `robot`: the one that a plan names, with
    other drives.

    Raises:
        InputError: its robot has other joints by now; no motion at all.
        RobotFileError: the robot is not there.
    """
    if isinstance(motion, WholeBodyMotion):
        yield from _of_states(motion)
    elif isinstance(motion, Plan | Rollout):
        yield from SampledMotion.of(motion, robot).stretches()
    else:
        raise InputError(
            "motion: expected a Plan, a Rollout or a WholeBodyMotion (`llsrbm.load_motion` opens a "
            f"file as one), got {type(motion).__name__}"
        )


def _parts(count: int) -> Iterator[slice]:
    """Slices of at most `AT_ONCE` of so many instants, each from the last one of the slice before.

    There is one at least.
    """
    for first in range(0, max(count - 1, 1), AT_ONCE - 1):
        yield slice(first, first + AT_ONCE)


def _instants(knots: Array, *, both_sides: bool) -> Array:
    """Instants at `RATE` between the first and the last knot, and beside the knots, s."""
    start, end = knots[0], knots[-1]
    times = np.arange(start + _FIRST, end, 1 / RATE)
    after = np.clip(np.searchsorted(knots, times), 1, len(knots) - 1)
    apart = np.minimum(times - knots[after - 1], knots[after] - times)
    sides = [knots[:-1] + _BESIDE]
    if both_sides:
        sides.append(knots[1:] - _BESIDE)
    return np.unique(np.concatenate([times[apart > _BESIDE], *sides]))


def _states(motion: WholeBodyMotion) -> tuple[Array, Array]:
    return pinocchio_states(motion.qpos, motion.qvel)


def _of_plan(plan: Plan, robot: Robot) -> SampledMotion:
    times = _instants(plan.time, both_sides=True)
    (_, before), (q, v), (_, after) = (
        realised_states(plan, robot, at) or _states(motion_at(plan, at))
        for at in (times - _STEP, times, times + _STEP)
    )
    sampled = resample(plan, times)
    feet = (len(times), len(robot.legs), -1, 3)
    return SampledMotion(
        source=plan,
        robot=robot,
        model=robot.model,
        time=times,
        q=q,
        v=v,
        a=(after - before) / (2 * _STEP),
        contact=sampled.contact.astype(bool),
        points=sampled.contact_point.reshape(feet),
        forces=sampled.contact_force.reshape(feet),
        recorded_torque=None,
        friction=plan.friction,
        whole_feet=False,
    )


def _of_rollout(rollout: Rollout) -> SampledMotion:
    robot = robot_of(rollout)
    times = _instants(rollout.time, both_sides=False)
    before, at, after = (motion_at(rollout, times + step) for step in (-_STEP, 0.0, _STEP))
    (_, slower), (q, v), (_, faster) = map(_states, (before, at, after))
    assert at.foot_force is not None
    assert at.pressed_at is not None
    return SampledMotion(
        source=rollout,
        robot=robot,
        model=rollout.disturbance.model(robot),
        time=times,
        q=q,
        v=v,
        # Pinocchio's accelerations are the derivatives of its velocities, in the base's axes.
        a=(faster - slower) / (2 * _STEP),
        contact=at.contact,
        points=at.pressed_at[:, :, None],
        forces=at.foot_force[:, :, None],
        recorded_torque=at.joint_torque,
        friction=rollout.disturbance.friction,
        whole_feet=not robot.file.foot.is_point,
    )


def _of_states(motion: WholeBodyMotion) -> Iterator[SampledMotion]:
    """Straight between frames, torques and forces those of the frame before.

    Between frames a foot stands that does in both: of one that leaves or lands in between it is not
    known when. Where there are forces it stands as long as these last.
    """
    knots, robot = motion.time, motion.robot
    instants = _instants(knots, both_sides=False)
    turning = Slerp(knots, Rotation.from_quat(motion.base_quat, scalar_first=True))
    rates = pinocchio_states(motion.qpos, motion.qvel)[1]
    accelerations = np.diff(rates, axis=0) / np.diff(knots)[:, None]
    means = np.diff(motion.joint_position, axis=0) / np.diff(knots)[:, None]
    for part in _parts(len(instants)):
        times = instants[part]
        frame = np.searchsorted(knots, times, side="right") - 1
        share = ((times - knots[frame]) / (knots[frame + 1] - knots[frame]))[:, None]
        qpos, qvel = (
            values[frame] + share * (values[frame + 1] - values[frame])
            for values in (motion.qpos, motion.qvel)
        )
        qpos[:, 3:7] = turning(times).as_quat(scalar_first=True)
        q, v = pinocchio_states(qpos, qvel)
        forces, points, torque = motion.foot_force, motion.pressed_at, motion.joint_torque
        contact = motion.contact[frame]
        if forces is None:
            contact &= motion.contact[frame + 1]
        yield SampledMotion(
            source=motion,
            robot=robot,
            model=robot.model,
            time=times,
            q=q,
            v=v,
            a=accelerations[frame],
            contact=contact,
            points=None if points is None else points[frame][:, :, None],
            forces=None if forces is None else forces[frame][:, :, None],
            recorded_torque=None if torque is None else torque[frame],
            friction=robot.file.limits.friction,
            whole_feet=not robot.file.foot.is_point,
            mean_joint_velocity=means[frame],
        )
