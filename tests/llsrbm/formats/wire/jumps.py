"""The jumps of the tests here, and states at a rollout's own ticks."""

import csv
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


def read_table(path: Path) -> dict[str, np.ndarray]:
    """Columns by their names in the header."""
    with path.open(newline="") as file:
        header, *rows = csv.reader(file)
    return dict(zip(header, np.array(rows, dtype=np.float64).T, strict=True))


def torques_of(trajectory, joint: str, times: np.ndarray) -> np.ndarray:
    """What a plan or a rollout has for a joint in the interval, or the tick, that holds an instant;
    an instant on an edge belongs to what begins there."""
    values = trajectory.joint_torque if hasattr(trajectory, "joint_torque") else trajectory.torque
    at = np.searchsorted(trajectory.time, times + trajectory.time[0] + 1e-9, side="right") - 1
    return values[at, trajectory.joint_names.index(joint)]
