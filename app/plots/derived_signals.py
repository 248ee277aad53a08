"""The signals that follow from several quantities: angles, moments of inertia, shares of limits."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from app.plots.choice import ALL_JOINTS
from app.plots.course import Course, principal_moments, whole_body_inertia
from app.plots.signal import Component, Level, Samples, Signal, joint_kinds, joint_tags
from llsrbm.body.peak_loads import torque_share
from llsrbm.mechanics import rotation_matrices, yaw

Array = NDArray[np.float64]

_INERTIAS = 400  # at most, of a motion; they change slowly, and eigenvalues take their time


def _scalar(unit: str, of: Callable[[Course], Array | None]) -> Callable[[Course], Samples | None]:
    def samples(course: Course) -> Samples | None:
        values = of(course)
        if values is None:
            return None
        return Samples(course.time, (Component("", unit),), values[:, None])

    return samples


def _base_angles(course: Course) -> Samples:
    R = rotation_matrices(course.motion.base_quat)
    angles = {
        "yaw": yaw(course.motion.base_quat),
        "pitch": -np.arcsin(np.clip(R[:, 2, 0], -1, 1)),
        "roll": np.unwrap(np.arctan2(R[:, 2, 1], R[:, 2, 2])),
    }
    components = tuple(Component(name, "°") for name in angles)
    return Samples(course.time, components, np.degrees(np.column_stack([*angles.values()])))


def _vertical_force(course: Course) -> Array | None:
    force = course.motion.foot_force
    if force is None:
        return None
    total: Array = force[..., 2].sum(axis=1)
    return total


def _moments(course: Course) -> Samples:
    motion = course.motion
    kept = slice(None, None, 1 + len(motion.time) // _INERTIAS)
    moments = principal_moments(motion.robot, motion.inertia[kept], motion.base_quat[kept])
    return Samples(motion.time[kept], _MOMENTS, moments)


def _whole_body_moments(course: Course) -> Samples:
    time, inertia, quat = whole_body_inertia(course.motion)
    return Samples(time, _MOMENTS, principal_moments(course.robot, inertia, quat))


_MOMENTS = tuple(Component(name, "kg m²") for name in ("roll", "pitch", "yaw"))


def _detection(course: Course) -> Array | None:
    rollout = course.rollout
    return None if rollout is None else rollout.detection_signal / abs(rollout.detection_threshold)


def _threshold(course: Course) -> float | None:
    rollout = course.rollout
    return None if rollout is None else float(np.sign(rollout.detection_threshold))


def _yaw_error(course: Course) -> Array | None:
    plan = course.planned
    if plan is None:
        return None
    followed = np.interp(course.time, plan.time, yaw(plan.base_quat))
    return np.degrees(yaw(course.motion.base_quat) - followed)


# Shares of J joints, (K, J), or None.
_PerJoint = Callable[[Course], Array | None]


def _torque_share(course: Course) -> Array | None:
    torque = course.motion.joint_torque
    if torque is None:
        return None
    return torque_share(torque, np.broadcast_to(course.robot.torque_limit, torque.shape))


def _saturation(course: Course) -> Array | None:
    torque, limit = course.motion.joint_torque, course.motion.joint_torque_limit
    return None if torque is None or limit is None else torque_share(torque, limit)


def _speed_share(course: Course) -> Array | None:
    speed = course.motion.joint_velocity
    return torque_share(speed, np.broadcast_to(course.robot.speed_limit, speed.shape))


def _joint_power(course: Course) -> Array | None:
    torque = course.motion.joint_torque
    return None if torque is None else torque * course.motion.joint_velocity


def _joint_by_joint(unit: str, of: _PerJoint) -> Callable[[Course], Samples | None]:
    def samples(course: Course) -> Samples | None:
        values = of(course)
        if values is None:
            return None
        tags = joint_tags(course.robot).items()
        return Samples(course.time, tuple(Component(name, unit, of_) for name, of_ in tags), values)

    return samples


def _over_joints(
    unit: str, of: _PerJoint, together: Callable[[Array], Array]
) -> Callable[[Course], Samples | None]:
    """Of each kind of joints one number: the largest, or the sum."""

    def samples(course: Course) -> Samples | None:
        values = of(course)
        if values is None:
            return None
        tags = [*joint_tags(course.robot).values()]
        kinds = joint_kinds(course.robot)
        columns = [
            together(values[:, [kind == ALL_JOINTS or kind in of_ for of_ in tags]])
            for kind in kinds
        ]
        components = tuple(Component(kind, unit) for kind in kinds)
        return Samples(course.time, components, np.column_stack(columns))

    return samples


def _largest(values: Array) -> Array:
    largest: Array = values.max(axis=1)
    return largest


def _sum(values: Array) -> Array:
    total: Array = values.sum(axis=1)
    return total


_LIMIT = Level("limit", lambda _course: 1.0)
_SHARE_SHOWN = 2.0  # of a limit; a plan that failed may need torque where there is none
_SIGNAL_SHOWN = 3.0  # thresholds; how far an impact goes beyond matters no more
_POWER = 10.0  # W, in view at least

_SHARES: Mapping[str, tuple[str, str, _PerJoint]] = {
    "torque_share": ("Torque / limit", "|torque| as a share of the largest", _torque_share),
    "saturation": (
        "Torque / limit at its speed",
        "|torque| as a share of the most that the drive gives at its speed",
        _saturation,
    ),
    "speed_share": ("Joint speed / limit", "|speed| as a share of the largest", _speed_share),
}


def derived_signals() -> Iterator[Signal]:
    """The base's angles, forces, inertias, loads of the joints, the landing."""
    yield Signal("base_angle", "Base angle", "yaw, pitch, roll of the base", _base_angles, 2.0)
    yield Signal(
        "vertical_force",
        "Vertical force, all feet",
        "sum over the feet",
        _scalar("N", _vertical_force),
    )
    yield Signal(
        "principal_inertia",
        "Principal inertia",
        "moments of inertia about the CoM, nearest to the base's axes",
        _moments,
        also=_whole_body_moments,
        also_title="whole body as planned",
    )
    for key, (title, meaning, of) in _SHARES.items():
        yield Signal(
            f"largest_{key}",
            f"Largest {title[0].lower()}{title[1:]}",
            f"{meaning}: the largest of some joints",
            _over_joints("", of, _largest),
            most=_SHARE_SHOWN,
            level=_LIMIT,
        )
    yield Signal(
        "power",
        "Power of the drives",
        "sum of torque times speed over some joints",
        _over_joints("W", _joint_power, _sum),
        _POWER,
    )
    for key, (title, meaning, of) in _SHARES.items():
        yield Signal(key, title, meaning, _joint_by_joint("", of), most=_SHARE_SHOWN, level=_LIMIT)
    yield Signal(
        "joint_power", "Joint power", "torque times speed", _joint_by_joint("W", _joint_power)
    )
    yield Signal(
        "average_spatial_velocity_norm",
        "Spatial velocity ‖v_G‖",
        "norm of the average spatial velocity",
        _scalar("", lambda course: course.average_spatial_velocity_norm),
    )
    yield Signal(
        "detection",
        "Detection signal / |threshold|",
        "the contact detector's signal",
        _scalar("", _detection),
        most=_SIGNAL_SHOWN,
        level=Level("threshold", _threshold),
    )
    yield Signal(
        "yaw_error", "Yaw − planned yaw", "against the plan", _scalar("°", _yaw_error), 1.0
    )
