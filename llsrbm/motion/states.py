"""Motions of which only states are known: velocities, contacts, and the momenta by Pinocchio."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from llsrbm.mechanics import rotation_matrices, sign_continuous
from llsrbm.motion.whole_body import WholeBodyMotion, pinocchio_states
from llsrbm.robots import Robot
from llsrbm.robots.feet import foot_contacts

Array = NDArray[np.float64]

_STILL = 0.15  # m/s: a foot that is slower ...
_LONG = 0.1  # s: ... for that long stands; at the top of a flight it is so for a third of that
_LEVEL = 0.005  # m from the height at which the foot stands before or after
_SLIPS = 0.3  # m/s: the fastest that a foot that low may be; it wobbles and slips as it lands


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
    model, data = robot.model, robot.model.createData()
    com, linear, angular = np.empty((3, len(time), 3))
    inertia = np.empty((len(time), 3, 3))
    feet = np.empty((len(time), len(robot.legs), 3))
    speed = np.empty(feet.shape[:2])
    for k, (q, v) in enumerate(zip(*pinocchio_states(qpos, qvel), strict=True)):
        pin.ccrba(model, data, q, v)
        com[k], inertia[k] = data.com[0], data.Ig.inertia
        linear[k], angular[k] = data.hg.linear, data.hg.angular
        pin.forwardKinematics(model, data, q, v)
        pin.updateFramePlacements(model, data)
        feet[k], speed[k] = _feet(robot, data)
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
        linear_momentum=linear,
        angular_momentum=angular,
        inertia=inertia,
        foot_position=feet,
        contact=standing(time, speed, feet[..., 2]),
    )


def _feet(robot: Robot, data: pin.Data) -> tuple[Array, Array]:
    """Lowest points of the feet (L, 3) m, and their speeds (L,) m/s."""
    points, speeds = np.empty((len(robot.legs), 3)), np.empty(len(robot.legs))
    for i, (leg, contact) in enumerate(zip(robot.legs, foot_contacts(robot), strict=True)):
        placement = data.oMf[leg.foot_frame_id]
        spheres = np.array([placement.act(centre) for centre in contact.centres])
        points[i] = spheres.mean(axis=0) - [0.0, 0.0, contact.radius]
        velocity = pin.getFrameVelocity(
            robot.model, data, leg.foot_frame_id, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        )
        # A ball rolls about its lowest point; a plan's foot turns about its frame.
        arm = points[i] - placement.translation
        rolling = velocity.linear + np.cross(velocity.angular, arm)
        speeds[i] = min(np.linalg.norm(velocity.linear), np.linalg.norm(rolling))
    return points, speeds


def velocities(time: Array, qpos: Array) -> Array:
    """(K, 6 + J) of states (K, 7 + J) at times (K,) s, both in MuJoCo's convention, K of 2 or more.

    Differences over the two intervals around an instant, exact for constant accelerations however
    long the intervals are. What changes at once, at an impact, is smeared over these two.
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


def standing(time: Array, speed: Array, height: Array) -> NDArray[np.bool_]:
    """(K, L) whether feet stand, from their contact points' speed (K, L) m/s and height (K, L) m.

    A foot that hardly moves for a tenth of a second stands, wherever: on the ground or on a box.
    That gives the heights at which it stands. It also stands at instants at which it is as high as
    at the nearest of those times and not fast.
    """
    stands = np.zeros(speed.shape, dtype=np.bool_)
    for foot in range(speed.shape[1]):
        level = np.full(len(time), np.inf)
        away = np.full(len(time), np.inf)
        for first, last in _runs(speed[:, foot] < _STILL):
            if time[last] - time[first] < _LONG:
                continue
            until = np.maximum(np.maximum(time[first] - time, time - time[last]), 0.0)
            nearest = until < away
            away[nearest] = until[nearest]
            level[nearest] = np.median(height[first : last + 1, foot])
        low = np.abs(height[:, foot] - level) < _LEVEL
        stands[:, foot] = low & (speed[:, foot] < _SLIPS)
    return stands


def _runs(flags: NDArray[np.bool_]) -> list[tuple[int, int]]:
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8)))
    return [(int(first), int(end) - 1) for first, end in edges.reshape(-1, 2)]
