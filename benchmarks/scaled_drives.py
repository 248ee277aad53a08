"""Drives of another strength for a solver that was built for those of the robot's file.

Rows know the file's torque T and speed W. With |t| / T and |w| / W as shares, drives that are S
times as fast and k times as strong,

    |t| <= k,   |0.3 t / k + w / S| <= 1,   |w| <= S,

are rows with other bounds: |t| <= S (k / S), |0.3 t / (k / S) + w| <= S. `torque_share` is k / S
then, times what plans may use of it.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from llsrbm.planning.problem.constraints import drives
from llsrbm.planning.problem.constraints.drive_rows import DriveConstraint
from llsrbm.planning.problem.task import Task

Array = NDArray[np.float64]


def with_scaled(task: Task, torque: float, speed: float) -> Task:
    """The task with so many times the drives' torque and speed; `scale_lines` has been called."""
    own = task.robot.file.limits
    shares = {
        "torque_share": own.torque_share * torque / speed,
        "speed_share": own.speed_share * speed,
    }
    return replace(task, limits=task.limits.model_copy(update=shares))


def scale_lines() -> None:
    """Let rows and checks of drives mean `with_scaled`, for the rest of this process."""

    def torque_tops(_: Any, task: Task) -> Array:
        return np.full(2, _speed(task) * task.limits.torque_share)

    def line_tops(_: Any, task: Task) -> Array:
        return np.full(2, _speed(task))

    drives.JointTorque.tops = torque_tops  # type: ignore[method-assign]
    drives.TorqueAtSpeed.tops = line_tops  # type: ignore[method-assign]
    # By the rows' sum: the torque that is available is that of the file's drives.
    drives.TorqueAtSpeed.excess = DriveConstraint.excess  # type: ignore[method-assign]


def _speed(task: Task) -> float:
    return task.limits.speed_share / task.robot.file.limits.speed_share
