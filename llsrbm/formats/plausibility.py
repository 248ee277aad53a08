"""Remarks on motions of other tools: what their numbers look like where the motion cannot be meant.

A file may have another convention than its format says: w first, degrees, centimetres, y up. Each
such kind has one sentence that names the evidence and the likely cause; nothing is converted.
"""

from collections.abc import Iterator

import numpy as np
import pinocchio as pin

from llsrbm.arrays import Array
from llsrbm.mechanics import rotation_matrices
from llsrbm.motion.whole_body import velocities
from llsrbm.robots import Robot
from llsrbm.robots.feet import foot_contacts

_MOSTLY = 0.9  # share of frames that counts as all of them
_UPRIGHT = 0.7  # of the cosine of the base's tilt
_BEYOND = 0.1  # rad or m beyond a stop
_FULL_TURNS = 7.0  # rad: joints of robots turn by less, whatever their stops
_ABOUT_ONE = 0.99  # of a quaternion's number
_HIGH = 5.0  # times the root's height when it stands
_SUNK = 0.1  # m under the ground; motions that were retargeted sink in by less
_LEAST_RATE, _MOST_RATE = 5.0, 2000.0  # frames/s
_NO_DERIVATIVE = 0.5  # of the typical speed, by which velocities differ from differences
_SLOW = 0.1  # m/s, rad/s: below, differences are mostly rounding
_PROBED = 200  # frames in which feet are looked for
# Times as far that the slowest feet move with w elsewhere: 1.1 to 6.7 in 50 planned motions.
_MORE = 1.2
_NORM = 1e-3  # by which a quaternion's may miss 1 in single precision


def remarks(
    robot: Robot, time: Array, qpos: Array, qvel: Array | None = None, w_first: bool = True
) -> tuple[str, ...]:
    """Sentences on what a robot's states cannot mean, most telling first.

    Args:
        time: (K,) s.
        qpos: (K, 7 + J) as the file has them, in MuJoCo's convention, joints in the robot's order;
            qvel: (K, 6 + J), None: the file has none.
        w_first: whether the file's quaternions have w first.
    """
    found = [*_of_rate(time), *_of_quaternions(qpos[:, 3:7])]
    placed = [*_of_attitude(robot, qpos, w_first), *_of_height(robot, qpos[:, 2])]
    joints = [*_of_joints(robot, qpos[:, 7:])]
    found += [*placed, *joints]
    if not placed and not joints:
        found += _of_feet(robot, qpos)
    if qvel is not None and len(time) > 2:
        found += _of_velocities(time, qpos, qvel)
    return tuple(found)


def _of_rate(time: Array) -> Iterator[str]:
    rate = (len(time) - 1) / (time[-1] - time[0])
    if rate < _LEAST_RATE:
        yield (
            f"It has {rate:.3g} frames per second and lasts {time[-1] - time[0]:.4g} s: is its "
            "time in ms, or its rate wrong?"
        )
    elif rate > _MOST_RATE:
        yield f"It has {rate:.5g} frames per second: is its rate wrong?"


def _of_quaternions(quat: Array) -> Iterator[str]:
    norm = np.linalg.norm(quat, axis=1)
    off = np.abs(norm - 1)
    if off.max() > _NORM:
        frame = int(off.argmax())
        yield f"Its quaternions have norms up to {norm[frame]:.4g} (frame {frame}): made unit ones."
    flips = np.flatnonzero(np.sum(quat[1:] * quat[:-1], axis=1) < 0)
    if len(flips):
        yield (
            f"Its quaternions change sign {len(flips)} times, first after frame {flips[0]}, which "
            "is the same attitude: made continuous."
        )


def _of_attitude(robot: Robot, qpos: Array, w_first: bool) -> Iterator[str]:
    quat = qpos[:, 3:7]
    quat = quat / np.linalg.norm(quat, axis=1, keepdims=True)
    up = rotation_matrices(quat)[:, :, 2]  # the base's z axis in the world
    upright = up[:, 2] > _UPRIGHT
    if np.mean(up[:, 1] > _UPRIGHT) >= _MOSTLY:
        yield "The robot's vertical is along y in every frame: is y up in the file?"
        return
    # What the file would mean if its four numbers were in the other order. Read with w first, a
    # robot that stands in a file with w last has turned by 180 deg.
    other = quat[:, [3, 0, 1, 2]] if w_first else quat[:, [1, 2, 3, 0]]
    suspect = not upright[0] or (w_first and abs(quat[0, 3]) > _ABOUT_ONE)
    stands = rotation_matrices(other)[:, 2, 2] > _UPRIGHT
    likely = suspect and stands[0] and np.mean(stands) >= _MOSTLY
    which = f"is w {'last' if w_first else 'first'} in its quaternions?"
    if likely and np.mean(upright) < _MOSTLY:
        turned = "upside down in every frame" if (up[:, 2] < 0).all() else "not upright"
        yield f"The robot is {turned}: {which}"
    elif likely and (here := _slid(robot, qpos)) > _MORE * (there := _slid(robot, qpos, other)):
        # One that hardly turns is upright either way, and looks backward.
        yield f"Its slowest feet move by {here:.2g} m in all, by {there:.2g} m otherwise: {which}"
    elif np.mean(up[:, 2] < -_UPRIGHT) >= _MOSTLY:
        yield "The robot is upside down in every frame."


def _of_height(robot: Robot, height: Array) -> Iterator[str]:
    usual, median = float(robot.posture[2]), float(np.median(height))
    if median < _HIGH * usual:
        return
    units = {"centimetres": 100.0, "millimetres": 1000.0}
    fits = [name for name, scale in units.items() if usual / 3 < median / scale < 3 * usual]
    unit = f"is it in {fits[0]}" if fits else "is it in another unit"
    yield f"The root is {median:.3g} m high, {usual:.2g} m when the robot stands: {unit}?"


def _of_joints(robot: Robot, position: Array) -> Iterator[str]:
    lower, upper = robot.joint_stops
    turning = np.array([name not in robot.sliding_joints for name in robot.joint_names])
    beyond = np.maximum(lower - position, position - upper)  # (K, J)
    largest = np.abs(position[:, turning]).max(initial=0.0)
    radians = np.where(turning, np.radians(position), position)
    as_degrees = np.maximum(lower - radians, radians - upper)
    if largest > _FULL_TURNS and (as_degrees.max(axis=1) < _BEYOND).mean() >= _MOSTLY:
        yield f"Joints are at up to {largest:.3g} rad: are they in degrees?"
        return
    always = (beyond > _BEYOND).mean(axis=0)
    if (beyond.max(axis=1) > _BEYOND).mean() >= _MOSTLY:
        joint = int(always.argmax())
        at = float(np.median(position[:, joint]))
        yield (
            f"In every frame joints are beyond their stops, {robot.joint_names[joint]} at "
            f"{at:.3g} ({lower[joint]:.3g} to {upper[joint]:.3g}): are the joints in another order?"
        )


def _slid(robot: Robot, qpos: Array, quat: Array | None = None) -> float:
    """How far, m, the slowest foot from each frame to the next goes in all; `quat`: (K, 4)."""
    if quat is not None:
        qpos = np.hstack([qpos[:, :3], quat, qpos[:, 7:]])
    # Frames side by side, some of many.
    pairs = np.unique(np.linspace(0, len(qpos) - 2, _PROBED).astype(int))
    ways = _places(robot, qpos[pairs + 1]) - _places(robot, qpos[pairs])
    return float(np.linalg.norm(ways, axis=-1).min(axis=1).sum() * (len(qpos) - 1) / len(pairs))


def _places(robot: Robot, qpos: Array) -> Array:
    """(K, L, 3) m: where the frames of the feet are."""
    model, data = robot.model, robot.model.createData()
    found = np.empty((len(qpos), len(robot.legs), 3))
    for k, q in enumerate(qpos):
        pin.framesForwardKinematics(model, data, np.r_[q[:3], q[4:7], q[3], q[7:]])
        found[k] = [data.oMf[leg.foot_frame_id].translation for leg in robot.legs]
    return found


def _of_feet(robot: Robot, qpos: Array) -> Iterator[str]:
    model, data = robot.model, robot.model.createData()
    contacts = foot_contacts(robot)

    def lowest_point(q: Array) -> float:
        pin.framesForwardKinematics(model, data, np.r_[q[:3], q[4:7], q[3], q[7:]])
        return min(
            float(data.oMf[leg.foot_frame_id].act(centre)[2] - contact.radius)
            for leg, contact in zip(robot.legs, contacts, strict=True)
            for centre in contact.centres
        )

    lowest = [lowest_point(q) for q in qpos[:: max(1, len(qpos) // _PROBED)]]
    depth = -max(float(np.median(lowest)), lowest[0])  # a jump down from a box begins above it
    if depth > _SUNK:
        yield (
            f"The feet are {depth:.2g} m under the ground: is the root's height that above the "
            "ground, and the root the right link?"
        )


def _of_velocities(time: Array, qpos: Array, qvel: Array) -> Iterator[str]:
    wanted = velocities(time, qpos)[1:-1]
    parts = {"root's linear": np.s_[:3], "root's angular": np.s_[3:6], "joints'": np.s_[6:]}
    wrong = []
    for name, part in parts.items():
        off = np.linalg.norm(qvel[1:-1, part] - wanted[:, part], axis=1)
        size = np.linalg.norm(wanted[:, part], axis=1)
        given = np.linalg.norm(qvel[1:-1, part], axis=1)
        moves = np.maximum(size, given) > _SLOW
        if moves.sum() > 2 and np.median((off / np.maximum(size, _SLOW))[moves]) > _NO_DERIVATIVE:
            wrong.append(name)
    if wrong:
        yield (
            f"The {' and '.join(wrong)} velocities are no derivatives of the positions: is the "
            "rate wrong, or are they in other units or axes?"
        )
