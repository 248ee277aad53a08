"""The native file of a `Rollout`: npz without pickle, schema llsrbm.rollout/1."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pydantic import Field, model_validator

from llsrbm.errors import FileFormatError
from llsrbm.motion.archive import Arrays, Entry, checked, read_archive, text
from llsrbm.motion.native_file import (
    Meta,
    check_quaternions,
    check_times,
    read_meta,
    write_native,
)
from llsrbm.motion.plan import Phase
from llsrbm.motion.rollout import Disturbance, Mode, Outcome, Rollout
from llsrbm.scenario import Scenario, with_scenario
from llsrbm.version import package_version

SCHEMA = "llsrbm.rollout/1"

# T ticks, L legs, J joints, Q = 7 + J, V = 6 + J.
LAYOUT: dict[str, Entry] = {
    "time": Entry(("T",)),
    "qpos": Entry(("T", "Q")),
    "qvel": Entry(("T", "V")),
    "joint_names": Entry(("J",), "text"),
    "torque": Entry(("T", "J")),
    "torque_limit": Entry(("T", "J")),
    "com": Entry(("T", 3)),
    "base_quat": Entry(("T", 4)),
    "base_position": Entry(("T", 3)),
    "linear_momentum": Entry(("T", 3)),
    "angular_momentum": Entry(("T", 3)),
    "inertia": Entry(("T", 3, 3)),
    "foot_position": Entry(("T", "L", 3)),
    "contact": Entry(("T", "L"), "whole"),
    "contact_force": Entry(("T", "L", 3)),
    "average_spatial_velocity_norm": Entry(("T",)),
    "detection_signal": Entry(("T",)),
    "detection_threshold": Entry(()),
    "mode": Entry(("T",), "whole"),
    "phase": Entry(("T",), "whole"),
    "reference_com": Entry(("T", 3)),
    "reference_base_quat": Entry(("T", 4)),
    "reference_foot_position": Entry(("T", "L", 3)),
    "reference_angular_momentum": Entry(("T", 3)),
}

_FREE_JOINT = {"qpos": 7, "qvel": 6}  # numbers before those of the joints
_NUMBERED = {
    "contact": ((0, 1), "0 (no), 1 (touches)"),
    "mode": (tuple(Mode), "0 (tracking), 1 (force)"),
    "phase": (tuple(Phase), "0 (take-off), 1 (flight), 2 (landing)"),
}


class _Meta(Meta):
    scenario: Scenario
    disturbance: Disturbance
    outcome: Outcome
    control_parameters: dict[str, Any] = Field(default_factory=dict)

    @model_validator(mode="before")
    @classmethod
    def _of_any_age(cls, meta: Any) -> Any:
        return with_scenario(meta) if isinstance(meta, dict) else meta


def save_rollout(rollout: Rollout, path: str | Path) -> None:
    """Write `rollout` at exactly that path, atomically.

    Raises:
        InputError: the file cannot be written.
        Error: the rollout holds numbers that are not finite.
    """
    meta = _Meta(
        request=rollout.jump,
        model=rollout.jump.model,
        robot_parameters=rollout.robot_parameters,
        control_parameters=rollout.control_parameters,
        scenario=rollout.scenario,
        disturbance=rollout.disturbance,
        outcome=rollout.outcome,
        package_version=package_version(),
    )
    write_native(path, SCHEMA, meta, rollout, LAYOUT)


def load_rollout(path: str | Path) -> Rollout:
    """Read a rollout's file.

    Raises:
        FileFormatError: unreadable, damaged, of another schema, or not a rollout.
    """
    arrays = read_archive(path)
    schema = text(arrays, "schema", path)
    if schema != SCHEMA:
        raise FileFormatError(f'{path}: schema "{schema}"; expected "{SCHEMA}"')
    return rollout_from_arrays(arrays, path)


def rollout_from_arrays(arrays: Arrays, path: str | Path) -> Rollout:
    """The rollout in an archive that has been read; `path` is for messages.

    Raises:
        FileFormatError: a key is missing or holds something else.
    """
    meta = read_meta(_Meta, arrays, path)
    values: dict[str, Any] = checked(arrays, LAYOUT, path)
    _check_values(values, path)
    values["detection_threshold"] = float(values["detection_threshold"])
    values["joint_names"] = tuple(str(name) for name in values["joint_names"])
    return Rollout(
        jump=meta.request,
        robot_parameters=meta.robot_parameters,
        control_parameters=meta.control_parameters,
        scenario=meta.scenario,
        disturbance=meta.disturbance,
        outcome=meta.outcome,
        **values,
    )


def _check_values(values: Arrays, path: str | Path) -> None:
    check_times(values["time"], path)
    joints = len(values["joint_names"])
    for key, base in _FREE_JOINT.items():
        if values[key].shape[1] != base + joints:
            raise FileFormatError(
                f'{path}: key "{key}": expected {base} + {joints} columns, as "joint_names" has '
                f"{joints} names, got {values[key].shape[1]}"
            )
    for key, (numbers, meaning) in _NUMBERED.items():
        if not set(values[key].ravel().tolist()) <= set(numbers):
            raise FileFormatError(f'{path}: key "{key}": expected {meaning}')
    check_quaternions(values, ("base_quat", "reference_base_quat"), path)
