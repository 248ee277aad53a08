"""The native file of a `Plan`: npz without pickle, schema llsrbm.plan/1."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from llsrbm.errors import FileFormatError
from llsrbm.trajectory.archive import Arrays, Entry, checked, read_archive, text
from llsrbm.trajectory.native_file import (
    Meta,
    check_quaternions,
    check_times,
    read_meta,
    write_native,
)
from llsrbm.trajectory.plan import Phase, Plan, SolveReport, Violation
from llsrbm.tuning import Tuning
from llsrbm.version import package_version

SCHEMA = "llsrbm.plan/1"

# N knots, L legs, C contacts, J joints, D coordinates of a foot.
LAYOUT: dict[str, Entry] = {
    "time": Entry(("N",)),
    "phase": Entry(("N",), "whole"),
    "com": Entry(("N", 3)),
    "com_velocity": Entry(("N", 3)),
    "base_quat": Entry(("N", 4)),
    "base_position": Entry(("N", 3)),
    "angular_velocity": Entry(("N", 3)),
    "linear_momentum": Entry(("N", 3)),
    "angular_momentum": Entry(("N", 3)),
    "inertia": Entry(("N", 3, 3)),
    "leg_mass": Entry(("L",)),
    "base_mass": Entry(()),
    "leg_com": Entry(("N", "L", 3)),
    "foot_position": Entry(("N", "L", 3)),
    "foot_quat": Entry(("N", "L", 4)),
    "foot_in_hip": Entry(("N", "L", "D")),
    "contact_point": Entry(("N", "C", 3)),
    "contact_force": Entry(("N", "C", 3)),
    "joint_names": Entry(("J",), "text"),
    "joint_position": Entry(("N", "J")),
}


class _Meta(Meta):
    report: SolveReport
    violations: dict[str, Violation]
    tuning: Tuning = Tuning()  # files of 0.1 have none


def save_plan(plan: Plan, path: str | Path) -> None:
    """Write `plan` at exactly that path, atomically.

    Raises:
        InputError: the file cannot be written.
        Error: the plan holds numbers that are not finite.
    """
    meta = _Meta(
        request=plan.jump,
        model=plan.jump.model,
        robot_parameters=plan.robot_parameters,
        report=plan.report,
        violations=plan.violations,
        tuning=plan.tuning,
        package_version=package_version(),
    )
    write_native(path, SCHEMA, meta, plan, LAYOUT)


def load_plan(path: str | Path) -> Plan:
    """Read a plan's file.

    Raises:
        FileFormatError: unreadable, damaged, of another schema, or not a plan.
    """
    arrays = read_archive(path)
    schema = text(arrays, "schema", path)
    if schema != SCHEMA:
        raise FileFormatError(f'{path}: schema "{schema}"; expected "{SCHEMA}"')
    return plan_from_arrays(arrays, path)


def plan_from_arrays(arrays: Arrays, path: str | Path) -> Plan:
    """The plan in an archive that has been read; `path` is for messages.

    Raises:
        FileFormatError: a key is missing or holds something else.
    """
    meta = read_meta(_Meta, arrays, path)
    values: dict[str, Any] = checked(arrays, LAYOUT, path)
    _check_values(values, path)
    values["base_mass"] = float(values["base_mass"])
    values["joint_names"] = tuple(str(name) for name in values["joint_names"])
    return Plan(
        jump=meta.request,
        robot_parameters=meta.robot_parameters,
        report=meta.report,
        violations=meta.violations,
        tuning=meta.tuning,
        **values,
    )


def _check_values(values: Arrays, path: str | Path) -> None:
    check_times(values["time"], path)
    phase = values["phase"]
    if (np.diff(phase) < 0).any() or not set(phase.tolist()) <= set(Phase):
        raise FileFormatError(
            f'{path}: key "phase": expected 0 (take-off), 1 (flight), 2 (landing) in that order'
        )
    check_quaternions(values, ("base_quat", "foot_quat"), path)
