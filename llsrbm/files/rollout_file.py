"""The native file of a `Rollout`: npz without pickle, schema llsrbm.rollout/1.

It holds the plan that was followed as well, so that a page that opens it can go on from there, and
what was planned anew under way.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from pydantic import Field

from llsrbm.errors import FileFormatError, printable
from llsrbm.files.archive import LARGEST_NUMBER, Arrays, checked, read_archive, write_archive
from llsrbm.files.native_file import (
    Meta,
    check_attitudes,
    check_numbers,
    check_schema,
    check_times,
    native_arrays,
    read_meta,
)
from llsrbm.files.plan_file import SCHEMAS as PLAN_SCHEMAS
from llsrbm.files.plan_file import plan_arrays, plan_from_arrays
from llsrbm.files.replan_file import replan_arrays, replans_from_arrays
from llsrbm.installed import package_version
from llsrbm.motion.plan import Plan
from llsrbm.motion.quantity import quantities
from llsrbm.motion.rollout import Disturbance, Outcome, Rollout
from llsrbm.request.scenario import Scenario

SCHEMA = "llsrbm.rollout/1"

LAYOUT = quantities(Rollout)

_PLAN = "plan/"  # what the keys of the plan that was followed begin with
_FREE_JOINT = {"qpos": 7, "qvel": 6}  # numbers before those of the joints


class _Meta(Meta):
    scenario: Scenario
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
        scenario=rollout.scenario,
        disturbance=rollout.disturbance,
        outcome=rollout.outcome,
        package_version=package_version(),
    )
    arrays = native_arrays(SCHEMA, meta, rollout, LAYOUT) | replan_arrays(rollout.replans)
    if rollout.plan is not None:
        arrays |= {_PLAN + key: value for key, value in plan_arrays(rollout.plan).items()}
    write_archive(path, arrays)


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
    rollout = Rollout(
        jump=meta.request,
        robot_parameters=meta.robot_parameters,
        control_parameters=meta.control_parameters,
        scenario=meta.scenario,
        disturbance=meta.disturbance,
        outcome=meta.outcome,
        plan=_followed(arrays, path, meta, values),
        replans=replans_from_arrays(arrays, values["foot_position"].shape[1], path),
        **values,
    )
    _check_phases(rollout, path)
    return rollout


def _followed(arrays: Arrays, path: str | Path, meta: _Meta, rollout: Arrays) -> Plan | None:
    """The plan in a rollout's file; None in files that were written before they had it."""
    own = {key.removeprefix(_PLAN): a for key, a in arrays.items() if key.startswith(_PLAN)}
    if not own:
        return None
    where = f"{path}: {_PLAN}"
    check_schema(own, where, PLAN_SCHEMAS)
    plan = plan_from_arrays(own, where)
    of_plan = plan.jump, sorted(plan.joint_names), plan.foot_position.shape[1]
    of_rollout = meta.request, sorted(rollout["joint_names"]), rollout["foot_position"].shape[1]
    if of_plan != of_rollout:
        raise FileFormatError(f"{where} is of another jump or robot than the rollout itself")
    return plan


def _check_phases(rollout: Rollout, path: str | Path) -> None:
    """Those of the schedule that was followed; one that fell may lack the last ones."""
    names = rollout.phase_names
    if not np.isin(rollout.phase, range(len(names))).all():
        listed = ", ".join(f"{number} ({name})" for number, name in enumerate(names))
        raise FileFormatError(f'{path}: key "phase": expected {printable(listed, 300)}')


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
