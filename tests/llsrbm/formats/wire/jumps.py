"""The jumps of the tests here, and states at a rollout's own ticks."""

import json
from pathlib import Path

import numpy as np

from tests.llsrbm.formats.jumps import planned, simulated

KINDS = ("plan", "rollout")


def jump(robot: str, kind: str):
    return planned(robot) if kind == "plan" else simulated(robot)


def rate_of(robot: str) -> float:
    """Half the control rate: every second tick of a rollout is a row."""
    return simulated(robot).outcome.control_rate_hz / 2


def beside(path: Path) -> dict:
    return json.loads(path.with_name(path.name + ".meta.json").read_text())


def torques_of(trajectory, joint: str, times: np.ndarray) -> np.ndarray:
    """What a plan or a rollout has for a joint in the interval, or the tick, that holds an instant;
    an instant on an edge belongs to what begins there."""
    values = trajectory.joint_torque if hasattr(trajectory, "joint_torque") else trajectory.torque
    at = np.searchsorted(trajectory.time, times + trajectory.time[0] + 1e-9, side="right") - 1
    return values[at, trajectory.joint_names.index(joint)]


def check_joint(robot, kind, joint, time, q, dq, tau, torque_tolerance=1e-4):
    """A joint's commands (K,) at instants: a rollout's own states, either's ends and torques."""
    trajectory = jump(robot, kind)
    column = trajectory.joint_names.index(joint)
    position = trajectory.joint_position[:, column]
    if kind == "rollout":
        rows = slice(0, len(position[::2]))
        np.testing.assert_allclose(q[rows], position[::2], atol=1e-6)
        velocity = trajectory.joint_velocity[::2, column]
        np.testing.assert_allclose(dq[rows], velocity, atol=1e-5)
    np.testing.assert_allclose(q[[0, -1]], position[[0, -1]], atol=1e-6)
    inside = time < trajectory.time[-1] - trajectory.time[0]
    wanted = torques_of(trajectory, joint, time[inside])
    np.testing.assert_allclose(tau[inside], wanted, atol=torque_tolerance)
