"""The native file of a `Rollout`: npz without pickle, schema llsrbm.rollout/1."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pydantic import Field

from llsrbm.errors import FileFormatError
from llsrbm.motion.archive import LARGEST_NUMBER, Arrays, checked, read_archive
from llsrbm.motion.native_file import (
    Meta,
    check_attitudes,
    check_numbers,
    check_schema,
    check_times,
    read_meta,
    write_native,
)
from llsrbm.motion.quantity import quantities
from llsrbm.motion.rollout import Conditions, Disturbance, Outcome, Rollout
from llsrbm.version import package_version

SCHEMA = "llsrbm.rollout/1"

LAYOUT = quantities(Rollout)

_FREE_JOINT = {"qpos": 7, "qvel": 6}  # numbers before those of the joints


class _Meta(Meta):
    conditions: Conditions
    disturbance: Disturbance
    outcome: Outcome
    control_parameters: dict[str, Any] = Field(default_factory=dict)


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
        conditions=rollout.conditions,
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
    check_schema(arrays, path, (SCHEMA,))
    return rollout_from_arrays(arrays, path)


def rollout_from_arrays(arrays: Arrays, path: str | Path) -> Rollout:
    """The rollout in an archive that has been read; `path` is for messages.

    Raises:
        FileFormatError: a key is missing or holds something else.
    """
    meta = read_meta(_Meta, arrays, path)
    values: dict[str, Any] = checked(arrays, LAYOUT, path)
    check_numbers(values, LAYOUT, path)
    _check_values(values, path)
    if not 0 < meta.outcome.control_rate_hz <= LARGEST_NUMBER:
        raise FileFormatError(f'{path}: key "meta": outcome.control_rate_hz: expected a rate')
    values["detection_threshold"] = float(values["detection_threshold"])
    values["joint_names"] = tuple(str(name) for name in values["joint_names"])
    return Rollout(
        jump=meta.request,
        robot_parameters=meta.robot_parameters,
        control_parameters=meta.control_parameters,
        conditions=meta.conditions,
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
    check_attitudes(values["qpos"][:, 3:7], f'{path}: key "qpos"')
