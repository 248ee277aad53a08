"""A plan or a rollout: reading its native file, and describing it as plain data."""

import math
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from llsrbm.files.native import check_schema
from llsrbm.files.npz import LARGEST, Arrays, read_archive
from llsrbm.installed import package_version
from llsrbm.motion.plan import SCHEMA as PLAN_SCHEMA
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import SCHEMA as ROLLOUT_SCHEMA
from llsrbm.motion.rollout import Rollout
from llsrbm.motion.whole_body import WholeBodyMotion

Trajectory = Plan | Rollout

_READERS: dict[str, Callable[[Arrays, str | Path], Trajectory]] = {
    PLAN_SCHEMA: Plan.from_arrays,
    ROLLOUT_SCHEMA: Rollout.from_arrays,
}
_WORLD = "x forward, y left, z up; origin on the ground under the standing robot"


def load(path: str | Path, *, largest: int = LARGEST) -> Trajectory:
    """Read a native file (`Plan.save`, `Rollout.save`).

    A stranger's file may be opened: nothing in it is run, no other file is read that it names, and
    it and its arrays may have at most `largest` bytes. Raises `FileFormatError`: unreadable,
    damaged, or of no schema this version knows.
    """
    arrays = read_archive(path, largest=largest)
    return _READERS[check_schema(arrays, path, *_READERS)](arrays, path)


def description(trajectory: Trajectory) -> dict[str, Any]:
    """Request, tuning, scenario, robot as it ran, model, solver, version and conventions.

    Plain data that JSON can hold: numbers that are not finite are null.
    """
    sliding = trajectory.sliding_joints
    common: dict[str, Any] = {
        "kind": "plan" if isinstance(trajectory, Plan) else "rollout",
        "package_version": package_version(),
        "request": trajectory.jump.as_dict(),
        "model": trajectory.jump.model,
        "robot": trajectory.robot_parameters,
        "world_frame": _WORLD,
        "units": "SI; angles in rad",
        "legs": list(trajectory.leg_names),
        "joints": list(trajectory.joint_names),
        **({} if trajectory.certificate is None else {"certificate": trajectory.certificate}),
        "joint_units": ["m" if name in sliding else "rad" for name in trajectory.joint_names],
    }
    if isinstance(trajectory, Plan):
        of_it = _of_plan(trajectory)
    else:
        of_it = {
            "control": trajectory.control_parameters,
            "scenario": asdict(trajectory.scenario),
            "disturbance": asdict(trajectory.disturbance),
            "outcome": asdict(trajectory.outcome),
            **_of_plan(trajectory.plan),
        }
    return json_value(common | of_it)


def motion_description(motion: WholeBodyMotion) -> dict[str, Any]:
    """The same of a motion that is neither: robot, origin, version and conventions."""
    robot = motion.robot
    return {
        "kind": "motion",
        "package_version": package_version(),
        "origin": motion.origin,
        "robot": {"name": robot.name},
        "world_frame": "z up",
        "units": "SI; angles in rad",
        "legs": list(robot.leg_names),
        "joints": list(robot.joint_names),
        "joint_units": [
            "m" if name in robot.sliding_joints else "rad" for name in robot.joint_names
        ],
    }


def _of_plan(plan: Plan) -> dict[str, Any]:
    return {
        "tuning": {"weights": dict(plan.tuning.weights), "limits": dict(plan.tuning.limits)},
        "limits": dict(plan.limits),
        "solver": asdict(plan.report),
        "violations": {name: asdict(violation) for name, violation in plan.violations.items()},
        "phases": [
            {"name": phase.name, "feet": list(phase.feet), "start_s": start, "end_s": end}
            for phase, start, end in zip(
                plan.schedule,
                plan.phase_start[:-1].tolist(),
                plan.phase_start[1:].tolist(),
                strict=True,
            )
        ],
    }


def json_value(value: Any) -> Any:
    """The same as JSON can hold it: null for numbers that are not finite."""
    if isinstance(value, dict):
        return {key: json_value(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [json_value(item) for item in value]
    if isinstance(value, np.generic):
        return json_value(value.item())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if isinstance(value, Path):
        return str(value)
    return value
