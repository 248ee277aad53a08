"""Motions of the whole robot, in one form whatever they come from: a plan, a rollout, a file.

Formats of other tools are written from it, foreign files are read into it, and the page draws it.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pinocchio as pin
from scipy.spatial.transform import Rotation

from llsrbm.arrays import Array, BoolArray, IntArray, stretches
from llsrbm.body.momentum import base_velocities, centroidal_states
from llsrbm.errors import InputError
from llsrbm.files.quantity import TIME, quantities
from llsrbm.mechanics import apply, cross, rotation_matrices, sign_continuous
from llsrbm.motion.plan import Plan
from llsrbm.motion.realised import realised
from llsrbm.motion.robot import robot_of
from llsrbm.motion.rollout import Rollout
from llsrbm.motion.sampling import evenly, resample, with_events
from llsrbm.robots import Robot
from llsrbm.robots.feet import foot_contacts

_STILL = 0.15  # m/s: a foot that is slower ...
_LONG = 0.1  # s: ... for that long stands; at the top of a flight it is so for a third of that
# m from the height at which the foot stands before or after; plans put ANYmal's balls 9 mm off.
_LEVEL = 0.01
_SLIPS = 0.3  # m/s: the fastest that a foot that low may be; it wobbles and slips as it lands


@dataclass(frozen=True, eq=False, repr=False)
class WholeBodyMotion:
    """A robot's motion at K instants: L legs, J joints in `Robot.joint_names`' order; world frame.

    Attributes:
        origin: what it was made from: "plan", "rollout", or the name of a file's format.
        time: (K,) s from 0 on; fps: None where events have instants of their own.
        base_position: (K, 3) m, base_quat: (K, 4) w, x, y, z without jumps of sign: root link.
        base_velocity: (K, 3) m/s of the root link's origin; angular_velocity: (K, 3) rad/s of it.
        joint_position, joint_velocity: (K, J) rad or m, and per s.
        com: (K, 3) m; linear_momentum, angular_momentum: (K, 3) kg m/s, kg m2/s about the CoM.
        inertia: (K, 3, 3) kg m2 about the CoM: the model's of a plan, otherwise the whole body's.
        foot_position: (K, L, 3) m: contact point of a point foot, middle of a sole.
        contact: (K, L) whether a foot stands.
        foot_force: (K, L, 3) N, the sum over a foot; pressed_at: (K, L, 3) m: where it acts, a
            sole's centre of pressure if that is known.
        joint_torque, joint_torque_limit: (K, J) Nm or N.
        phase: (K,) index into the schedule's phases.
        remarks: sentences on what a file of another tool cannot mean as it stands.
    """

    robot: Robot
    origin: str
    time: Array
    fps: float | None
    base_position: Array
    base_quat: Array
    base_velocity: Array
    angular_velocity: Array
    joint_position: Array
    joint_velocity: Array
    com: Array
    linear_momentum: Array
    angular_momentum: Array
    inertia: Array
    foot_position: Array
    contact: BoolArray
    foot_force: Array | None = None
    pressed_at: Array | None = None
    joint_torque: Array | None = None
    joint_torque_limit: Array | None = None
    phase: IntArray | None = None
    remarks: tuple[str, ...] = ()

    def __repr__(self) -> str:
        lasts = f"{len(self.time)} instants in {self.time[-1]:.2f} s"
        return f"<WholeBodyMotion of {self.robot.name}, {self.origin}; {lasts}>"

    @property
    def qpos(self) -> Array:
        """(K, 7 + J) in MuJoCo's convention, joints in `Robot.joint_names`' order."""
        return np.hstack([self.base_position, self.base_quat, self.joint_position])

    @property
    def qvel(self) -> Array:
        """(K, 6 + J) in MuJoCo's: linear velocity in the world's axes, angular in the base's."""
        R = rotation_matrices(self.base_quat)
        omega = np.einsum("kji,kj->ki", R, self.angular_velocity)
        return np.hstack([self.base_velocity, omega, self.joint_velocity])


def whole_body_motion(
    trajectory: Plan | Rollout, fps: float, pad: float = 0.0, *, events: bool = False
) -> WholeBodyMotion:
    """Sample a plan or a rollout evenly, with `pad` s of standing still before and after.

    `events`: have the instants at which contacts change as well; nothing is padded then.

    Raises:
        InputError: a rate or a pad that makes no sense, or a robot that has other joints by now.
        RobotFileError: the robot is not there.
    """
    times = with_events(trajectory, fps) if events else evenly(trajectory, fps, pad)
    return motion_at(trajectory, times, None if events else float(fps))


def motion_at(
    trajectory: Plan | Rollout, times: Array, fps: float | None = None
) -> WholeBodyMotion:
    """A plan or a rollout at increasing instants `times` (K,) s, `fps` if they are even.

    Raises:
        InputError: the robot has other joints by now.
        RobotFileError: the robot is not there.
    """
    robot, order = _robot_and_order(trajectory)
    if isinstance(trajectory, Plan):
        return _of_plan(trajectory, robot, times, order, fps)
    return _of_rollout(resample(trajectory, times), robot, times, order, fps)


def motion_at_ticks(rollout: Rollout, ticks: IntArray) -> WholeBodyMotion:
    """A rollout at some of its own ticks (K,), increasing, or at all of them.

    Raises:
        InputError: the robot has other joints by now.
        RobotFileError: the robot is not there.
    """
    robot, order = _robot_and_order(rollout)
    values = {
        name: getattr(rollout, name)[ticks]
        for name, quantity in quantities(Rollout).items()
        if TIME in quantity.axes
    }
    return _of_rollout(replace(rollout, **values), robot, values["time"], order, None)


def _robot_and_order(trajectory: Plan | Rollout) -> tuple[Robot, list[int]]:
    """The robot as it is now, and where its joints are among the trajectory's."""
    robot = robot_of(trajectory)
    if sorted(trajectory.joint_names) != sorted(robot.joint_names):
        raise InputError(
            f"the motion's joints are {', '.join(trajectory.joint_names)}, but {robot.path} has "
            f"{', '.join(robot.joint_names)}; expected the robot that the motion was made with"
        )
    feet = trajectory.foot_position.shape[1]
    if feet != len(robot.legs):
        raise InputError(
            f"the motion has {feet} feet, but {robot.path} has {len(robot.legs)}; expected the "
            "robot that the motion was made with"
        )
    return robot, [trajectory.joint_names.index(name) for name in robot.joint_names]


_ALIKE = (
    *("base_position", "angular_velocity", "com", "linear_momentum", "angular_momentum"),
    *("inertia", "foot_position", "phase"),
)
"""What plans, rollouts and whole-body motions have under the same names."""


def _of_plan(
    plan: Plan, robot: Robot, times: Array, order: list[int], fps: float | None
) -> WholeBodyMotion:
    sampled = realised(plan, robot, times)
    assert sampled.joint_velocity is not None  # sampled plans have it
    joint_velocity = sampled.joint_velocity[:, order]
    joint_position = sampled.joint_position[:, order]
    # At its last knot a plan has no force any more: no interval starts there.
    force = np.where(
        (times >= plan.time[-1])[:, None, None], plan.contact_force[-2], sampled.contact_force
    )
    foot_force, pressed_at = resultants(sampled.contact_point, force, len(robot.legs))
    return WholeBodyMotion(
        robot=robot,
        origin="plan",
        time=times - times[0],
        fps=fps,
        base_quat=sampled.base_quat,
        base_velocity=_base_velocity(robot, sampled, joint_position, joint_velocity),
        joint_position=joint_position,
        joint_velocity=joint_velocity,
        contact=sampled.contact,
        foot_force=foot_force,
        pressed_at=pressed_at,
        joint_torque=_ordered(sampled.joint_torque, order),
        joint_torque_limit=_ordered(sampled.joint_torque_limit, order),
        **{name: getattr(sampled, name) for name in _ALIKE},
    )


def _of_rollout(
    sampled: Rollout, robot: Robot, times: Array, order: list[int], fps: float | None
) -> WholeBodyMotion:
    return WholeBodyMotion(
        robot=robot,
        origin="rollout",
        time=times - times[0],
        fps=fps,
        base_quat=sign_continuous(sampled.base_quat),
        base_velocity=sampled.base_velocity,
        joint_position=sampled.joint_position[:, order],
        joint_velocity=sampled.joint_velocity[:, order],
        contact=sampled.contact.astype(bool),
        foot_force=sampled.contact_force,
        # Where in a sole it acts is not recorded.
        pressed_at=sampled.foot_position,
        joint_torque=sampled.torque[:, order],
        joint_torque_limit=sampled.torque_limit[:, order],
        **{name: getattr(sampled, name) for name in _ALIKE},
    )


def pinocchio_states(qpos: Array, qvel: Array) -> tuple[Array, Array]:
    """Pinocchio's coordinates (K, 7 + J) and velocities (K, 6 + J) of MuJoCo's."""
    q, v = qpos.copy(), qvel.copy()
    q[:, 3:7] = qpos[:, [4, 5, 6, 3]]
    v[:, :3] = np.einsum("kji,kj->ki", rotation_matrices(qpos[:, 3:7]), qvel[:, :3])
    return q, v


def resultants(points: Array, forces: Array, feet: int) -> tuple[Array, Array]:
    """Forces on L feet, (K, L, 3) N, and the centres of pressure, (K, L, 3) m.

    Of forces (K, C, 3) N at points (K, C, 3) m, feet x contacts of a foot.
    """
    points, forces = (values.reshape(len(values), feet, -1, 3) for values in (points, forces))
    total = forces.sum(axis=2)
    vertical = forces[..., 2:]
    pushed = total[..., 2:] > 0
    weighted = (vertical * points).sum(axis=2) / np.where(pushed, total[..., 2:], 1.0)
    return total, np.where(pushed, weighted, points.mean(axis=2))


def _base_velocity(robot: Robot, plan: Plan, joint_position: Array, joint_velocity: Array) -> Array:
    R = rotation_matrices(plan.base_quat)
    omega = np.einsum("kji,kj->ki", R, plan.angular_velocity)
    pose = plan.base_position, plan.base_quat
    return base_velocities(robot, plan.com_velocity, *pose, omega, joint_position, joint_velocity)


def _ordered(values: Any, order: list[int]) -> Array | None:
    return None if values is None else values[:, order]


# ---- motions of which only states are known


def motion_of_states(
    robot: Robot,
    origin: str,
    time: Array,
    qpos: Array,
    qvel: Array,
    fps: float | None = None,
) -> WholeBodyMotion:
    """A motion of which only the states are known; momenta and inertia by Pinocchio.

    Which feet stand follows from how they move: see `standing`.

    Args:
        robot, origin: that moves, and the format of the file.
        time: (K,) s from 0 on; fps: of evenly spaced instants.
        qpos, qvel: (K, 7 + J), (K, 6 + J) in MuJoCo's convention, joints in the robot's order.
    """
    qpos = np.hstack([qpos[:, :3], sign_continuous(qpos[:, 3:7]), qpos[:, 7:]])
    q, v = pinocchio_states(qpos, qvel)
    com, inertia, momentum = centroidal_states(robot.model, q, v)
    feet, speed = _feet(robot, q, v)
    return WholeBodyMotion(
        robot=robot,
        origin=origin,
        time=time,
        fps=fps,
        base_position=qpos[:, :3],
        base_quat=qpos[:, 3:7],
        base_velocity=qvel[:, :3],
        angular_velocity=np.einsum("kij,kj->ki", rotation_matrices(qpos[:, 3:7]), qvel[:, 3:6]),
        joint_position=qpos[:, 7:],
        joint_velocity=qvel[:, 6:],
        com=com,
        linear_momentum=momentum[:, :3],
        angular_momentum=momentum[:, 3:],
        inertia=inertia,
        foot_position=feet,
        contact=standing(time, speed, feet[..., 2]),
    )


def _feet(robot: Robot, q: Array, v: Array) -> tuple[Array, Array]:
    """Contact points (K, L, 3) m and their speeds (K, L) m/s, of states as Pinocchio has them."""
    model, data, contacts = robot.model, robot.model.createData(), foot_contacts(robot)
    place, linear, angular = np.empty((3, len(q), len(contacts), 3))
    R = np.empty((len(q), len(contacts), 3, 3))
    for k in range(len(q)):
        pin.forwardKinematics(model, data, q[k], v[k])
        for i, leg in enumerate(robot.legs):
            frame = leg.foot_frame_id
            placement = pin.updateFramePlacement(model, data, frame)
            moves = pin.getFrameVelocity(model, data, frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
            place[k, i], R[k, i] = placement.translation, placement.rotation
            linear[k, i], angular[k, i] = moves.linear, moves.angular
    points = place + apply(R, np.array([contact.middle for contact in contacts]))
    points[..., 2] -= [contact.radius for contact in contacts]
    # A ball rolls about its lowest point; a plan's foot turns about its frame.
    rolling = linear + cross(angular, points - place)
    return points, np.minimum(np.linalg.norm(linear, axis=2), np.linalg.norm(rolling, axis=2))


def velocities(time: Array, qpos: Array) -> Array:
    """(K, 6 + J) of states (K, 7 + J) at times (K,) s, both in MuJoCo's convention, K of 2 or more.

    Differences over the two intervals around an instant, exact for constant accelerations however
    long the intervals are. A sudden change, as at an impact, is smeared over these two.
    """
    dt = np.diff(time)[:, None]
    attitude = Rotation.from_quat(qpos[:, 3:7], scalar_first=True)
    turned = (attitude[:-1].inv() * attitude[1:]).as_rotvec()  # in the base's axes
    moved = np.diff(np.delete(qpos, np.s_[3:7], axis=1), axis=0)
    rate = np.hstack([moved[:, :3], turned, moved[:, 3:]]) / dt  # of the intervals' middles
    if len(rate) == 1:
        return np.repeat(rate, 2, axis=0)
    inside = (dt[1:] * rate[:-1] + dt[:-1] * rate[1:]) / (dt[1:] + dt[:-1])
    # To either end on the straight line through the middle of its interval.
    return np.vstack([2 * rate[0] - inside[0], inside, 2 * rate[-1] - inside[-1]])


def standing(time: Array, speed: Array, height: Array) -> BoolArray:
    """(K, L) whether feet stand, from their contact points' speed (K, L) m/s and height (K, L) m.

    A foot that hardly moves for a tenth of a second stands, wherever: on the ground or on a box.
    That gives the heights at which it stands. It also stands at instants at which it is as high as
    at the nearest of those times and not fast.
    """
    stands = np.zeros(speed.shape, dtype=np.bool_)
    for foot in range(speed.shape[1]):
        level = np.full(len(time), np.inf)
        away = np.full(len(time), np.inf)
        for first, end in stretches(speed[:, foot] < _STILL):
            last = end - 1
            if time[last] - time[first] < _LONG:
                continue
            until = np.maximum(np.maximum(time[first] - time, time - time[last]), 0.0)
            nearest = until < away
            away[nearest] = until[nearest]
            level[nearest] = np.median(height[first:end, foot])
        low = np.abs(height[:, foot] - level) < _LEVEL
        stands[:, foot] = low & (speed[:, foot] < _SLIPS)
    return stands
