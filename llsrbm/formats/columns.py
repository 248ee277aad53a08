"""Columns of a table: what a plan and what a rollout have to tell, named with their units.

A quantity that both have has the same name in both. The slash makes a tree of the names in
PlotJuggler.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from llsrbm.motion.plan import Plan, leg_names
from llsrbm.motion.resample import resample, uniform_times
from llsrbm.motion.rollout import Rollout
from llsrbm.motion.rollout_resample import resample_rollout, rollout_times
from llsrbm.motion.rotation import rotation_matrices

Array = NDArray[np.float64]
Column = tuple[str, Array]

_XYZ = ("x", "y", "z")
_WXYZ = ("w", "x", "y", "z")
_TENSOR = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}
_PHASE = "phase [0 take-off, 1 flight, 2 landing]"


def plan_columns(plan: Plan, fps: float) -> Iterator[Column]:
    """Rows 1/fps apart, and one exactly at each lift-off and touch-down."""
    motion = resample(plan, uniform_times(plan, fps, phase_edges=True))
    legs, joints = plan.leg_names, motion.joint_names
    yield "time [s]", motion.time
    yield _PHASE, motion.phase.astype(np.float64)
    yield from _split("base_position", "m", motion.base_position)
    yield from _split("base_quat", "", motion.base_quat, _WXYZ)
    yield from _split("com", "m", motion.com)
    yield from _split("com_velocity", "m/s", motion.com_velocity)
    yield from _split("angular_velocity", "rad/s", motion.angular_velocity)
    yield from _split("linear_momentum", "kg m/s", motion.linear_momentum)
    yield from _split("angular_momentum", "kg m2/s", motion.angular_momentum)
    yield from _tensor("inertia", "kg m2", motion.inertia)
    yield from _points("foot_position", "m", legs, motion.foot_position)
    contacts = _contact_names(legs, motion.contact_force.shape[1])
    yield from _points("contact_force", "N", contacts, motion.contact_force)
    yield from _named("joint_position", "rad or m", joints, motion.joint_position)
    yield from _named("joint_velocity", "rad/s or m/s", joints, motion.joint_velocity)
    if motion.joint_torque is not None and motion.joint_torque_limit is not None:
        yield from _named("joint_torque", "Nm or N", joints, motion.joint_torque)
        yield from _named("joint_torque_limit", "Nm or N", joints, motion.joint_torque_limit)


def rollout_columns(rollout: Rollout, fps: float) -> Iterator[Column]:
    """Rows 1/fps apart, and one at each change of phase, of mode, or between ground and air.

    Forces and torques are those of the control tick that a row falls into, not means over a row.
    """
    motion = resample_rollout(rollout, rollout_times(rollout, fps))
    joints = motion.joint_names
    legs = leg_names(rollout.robot_parameters, motion.foot_position.shape[1])
    R_world_base = rotation_matrices(motion.base_quat)
    yield "time [s]", motion.time
    yield _PHASE, motion.phase.astype(np.float64)
    yield "mode [0 tracking, 1 force]", motion.mode.astype(np.float64)
    yield from _split("base_position", "m", motion.base_position)
    yield from _split("base_quat", "", motion.base_quat, _WXYZ)
    yield from _split("base_velocity", "m/s", motion.qvel[:, :3])
    yield from _split(
        "angular_velocity", "rad/s", np.einsum("kij,kj->ki", R_world_base, motion.qvel[:, 3:6])
    )
    yield from _split("com", "m", motion.com)
    yield from _split("linear_momentum", "kg m/s", motion.linear_momentum)
    yield from _split("angular_momentum", "kg m2/s", motion.angular_momentum)
    yield from _tensor("inertia", "kg m2", motion.inertia)
    yield from _points("foot_position", "m", legs, motion.foot_position)
    yield from _named("contact", "0 or 1", legs, motion.contact.astype(np.float64))
    yield from _points("contact_force", "N", legs, motion.contact_force)
    yield from _named("joint_position", "rad or m", joints, motion.qpos[:, 7:])
    yield from _named("joint_velocity", "rad/s or m/s", joints, motion.qvel[:, 6:])
    yield from _named("joint_torque", "Nm or N", joints, motion.torque)
    yield from _named("joint_torque_limit", "Nm or N", joints, motion.torque_limit)
    yield (
        "average_spatial_velocity_norm [m/s and rad/s]",
        motion.average_spatial_velocity_norm,
    )
    yield "detection_signal [the detector's]", motion.detection_signal
    yield from _split("reference_base_quat", "", motion.reference_base_quat, _WXYZ)
    yield from _split("reference_com", "m", motion.reference_com)
    yield from _split("reference_angular_momentum", "kg m2/s", motion.reference_angular_momentum)
    yield from _points("reference_foot_position", "m", legs, motion.reference_foot_position)


def _split(name: str, unit: str, values: Array, axes: Sequence[str] = _XYZ) -> Iterator[Column]:
    for i, axis in enumerate(axes):
        yield f"{name}/{axis} [{unit}]" if unit else f"{name}/{axis}", values[:, i]


def _points(name: str, unit: str, which: Sequence[str], values: Array) -> Iterator[Column]:
    for i, point in enumerate(which):
        yield from _split(f"{name}/{point}", unit, values[:, i])


def _named(name: str, unit: str, which: Sequence[str], values: Array) -> Iterator[Column]:
    for i, item in enumerate(which):
        yield f"{name}/{item} [{unit}]", values[:, i]


def _tensor(name: str, unit: str, values: Array) -> Iterator[Column]:
    for entry, (row, column) in _TENSOR.items():
        yield f"{name}/{entry} [{unit}]", values[:, row, column]


def _contact_names(legs: Sequence[str], count: int) -> list[str]:
    """Point feet are called as their legs; a planar foot's corners are numbered."""
    if count == len(legs):
        return list(legs)
    if count % len(legs):
        return [f"contact{i}" for i in range(count)]
    return [f"{leg}_{corner}" for leg in legs for corner in range(count // len(legs))]
