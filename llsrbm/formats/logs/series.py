"""The numbers of a motion that log viewers plot."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from llsrbm.arrays import Array
from llsrbm.look.shown_motion import ShownMotion, mass_of, shown_motion
from llsrbm.motion.rollout import Rollout
from llsrbm.motion.sampling import resample
from llsrbm.motion.trajectory import Trajectory
from llsrbm.motion.whole_body import whole_body_motion

GHOST = 0.3  # opacity of a plan beside what was made of it
GROUND_SIZE = (4.0, 4.0, 0.01)  # m; its top is the ground
_XYZ, _WXYZ = ("x", "y", "z"), ("w", "x", "y", "z")
_LEAST_LIMIT = 1e-6  # Nm or N; a drive beyond its speed can give nothing


@dataclass(frozen=True, eq=False)
class Series:
    """Numbers over K instants that belong into one plot.

    Attributes:
        name: what they are; a slash makes a tree of names.
        unit: of all of them, "" for none.
        parts: (n,) a name each; values: (K, n).
    """

    name: str
    unit: str
    parts: tuple[str, ...]
    values: Array


def logged(trajectory: Trajectory, fps: float, start: float | None = None) -> ShownMotion:
    """A plan or a rollout with the instants of its events, and with forces of that instant.

    `start`: s of its time at which the file begins; None: with the motion.

    Raises:
        InputError: a rate that makes no sense, or a robot that has other joints by now.
        RobotFileError: the robot is not there.
    """
    motion = whole_body_motion(trajectory, fps, events=True)
    own = float(trajectory.time[0])
    time = motion.time + (own - (own if start is None else start))
    return shown_motion(
        motion, trajectory.schedule, mass=mass_of(trajectory, motion.robot), time=time
    )


def logged_plan(trajectory: Trajectory, fps: float) -> ShownMotion | None:
    """The plan that a rollout followed, on the rollout's time; None of a plan."""
    if isinstance(trajectory, Rollout):
        return logged(trajectory.plan, fps, float(trajectory.time[0]))
    return None


def reference_series(rollout: Rollout, shown: ShownMotion) -> tuple[Series, ...]:
    """The controller's reference, at the instants of the rollout's motion.

    A landing strategy may have changed what the plan says.
    """
    sampled = resample(rollout, shown.motion.time + rollout.time[0])
    return (
        Series("com", "m", _XYZ, sampled.reference_com),
        Series("base_quat", "", _WXYZ, sampled.reference_base_quat),
        *(
            Series(f"foot_position/{leg}", "m", _XYZ, sampled.reference_foot_position[:, i])
            for i, leg in enumerate(shown.robot.leg_names)
        ),
        Series("angular_momentum", "kg m2/s", _XYZ, sampled.reference_angular_momentum),
    )


def series_of(shown: ShownMotion) -> Iterator[Series]:
    """Everything that is plotted of a plan or a rollout."""
    motion, mass = shown.motion, shown.mass
    legs, joints = motion.robot.leg_names, motion.robot.joint_names
    yield Series("com", "m", _XYZ, motion.com)
    yield Series("com_velocity", "m/s", _XYZ, motion.linear_momentum / mass)
    yield Series("linear_momentum", "kg m/s", _XYZ, motion.linear_momentum)
    yield Series("angular_momentum", "kg m2/s", _XYZ, motion.angular_momentum)
    moments: Array = np.linalg.eigvalsh(motion.inertia).astype(np.float64)
    yield Series("principal_moments", "kg m2", ("smallest", "middle", "largest"), moments)
    yield Series("base_position", "m", _XYZ, motion.base_position)
    yield Series("base_quat", "", _WXYZ, motion.base_quat)
    yield Series("base_velocity", "m/s", _XYZ, motion.base_velocity)
    yield Series("angular_velocity", "rad/s", _XYZ, motion.angular_velocity)
    for i, leg in enumerate(legs):
        yield Series(f"foot_position/{leg}", "m", _XYZ, motion.foot_position[:, i])
    yield Series("contact", "", legs, motion.contact.astype(np.float64))
    assert motion.phase is not None  # plans and rollouts have it
    yield Series("phase", "", ("phase",), motion.phase[:, None].astype(np.float64))
    assert motion.foot_force is not None
    for i, leg in enumerate(legs):
        yield Series(f"foot_force/{leg}", "N", _XYZ, motion.foot_force[:, i])
    yield Series("joint_position", "rad or m", joints, motion.joint_position)
    yield Series("joint_velocity", "rad/s or m/s", joints, motion.joint_velocity)
    if motion.joint_torque is not None:
        yield Series("joint_torque", "Nm or N", joints, motion.joint_torque)
        if motion.joint_torque_limit is not None:
            limit = np.maximum(motion.joint_torque_limit, _LEAST_LIMIT)
            yield Series("torque_share", "", joints, motion.joint_torque / limit)
