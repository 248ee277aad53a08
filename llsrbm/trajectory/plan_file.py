"""The native file of a `Plan`: npz without pickle, schema llsrbm.plan/1."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from pydantic import BaseModel, ConfigDict, ValidationError

from llsrbm.errors import Error, FileFormatError, InputError
from llsrbm.jump import Jump
from llsrbm.trajectory.archive import Arrays, Entry, checked, read_archive, text, write_archive
from llsrbm.trajectory.plan import Phase, Plan, SolveReport, Violation
from llsrbm.version import package_version

SCHEMA = "llsrbm.plan/1"

# N knots, L legs, C contacts, J joints.
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
    "foot_in_hip": Entry(("N", "L", 3)),
    "contact_point": Entry(("N", "C", 3)),
    "contact_force": Entry(("N", "C", 3)),
    "joint_names": Entry(("J",), "text"),
    "joint_position": Entry(("N", "J")),
}

_UNIT_QUATERNION = 1e-3  # largest deviation of a norm from 1 that still is an attitude


class _Meta(BaseModel):
    """The JSON at `meta`: where the arrays come from."""

    # JSON has no NaN, which the cost of a plan that did not converge may be.
    model_config = ConfigDict(ser_json_inf_nan="strings")

    request: Jump
    model: str
    robot_parameters: dict[str, Any]
    report: SolveReport
    violations: dict[str, Violation]
    package_version: str


def save_plan(plan: Plan, path: str | Path) -> None:
    """Write `plan` at exactly that path, atomically.

    Raises:
        InputError: the file cannot be written.
        Error: the plan holds numbers that are not finite.
    """
    arrays: dict[str, Any] = {key: np.asarray(getattr(plan, key)) for key in LAYOUT}
    arrays["joint_names"] = np.array(plan.joint_names, dtype=np.str_)
    for key, value in arrays.items():
        if value.dtype.kind == "f" and not np.isfinite(value).all():
            raise Error(f"plan.{key} holds numbers that are not finite; it is not written")
    meta = _Meta(
        request=plan.jump,
        model=plan.jump.model,
        robot_parameters=plan.robot_parameters,
        report=plan.report,
        violations=plan.violations,
        package_version=package_version(),
    )
    write_archive(
        path,
        {"schema": np.array(SCHEMA), "meta": np.array(meta.model_dump_json()), **arrays},
    )


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
    meta = _read_meta(text(arrays, "meta", path), path)
    values: dict[str, Any] = checked(arrays, LAYOUT, path)
    _check_values(values, path)
    values["base_mass"] = float(values["base_mass"])
    values["joint_names"] = tuple(str(name) for name in values["joint_names"])
    return Plan(
        jump=meta.request,
        robot_parameters=meta.robot_parameters,
        report=meta.report,
        violations=meta.violations,
        **values,
    )


def _read_meta(content: str, path: str | Path) -> _Meta:
    where = f'{path}: key "meta"'
    try:
        return _Meta.model_validate_json(content)
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(str(part) for part in first["loc"]) or "JSON"
        raise FileFormatError(f"{where}: {place}: {first['msg']}") from error
    except InputError as error:  # the request's own checks
        raise FileFormatError(f"{where}: request: {error}") from error


def _check_values(values: Arrays, path: str | Path) -> None:
    time, phase = values["time"], values["phase"]
    if len(time) < 2 or (np.diff(time) <= 0).any():
        raise FileFormatError(f'{path}: key "time": expected 2 or more strictly increasing times')
    if (np.diff(phase) < 0).any() or not set(phase.tolist()) <= set(Phase):
        raise FileFormatError(
            f'{path}: key "phase": expected 0 (take-off), 1 (flight), 2 (landing) in that order'
        )
    for key in ("base_quat", "foot_quat"):
        if (np.abs(np.linalg.norm(values[key], axis=-1) - 1) > _UNIT_QUATERNION).any():
            raise FileFormatError(f'{path}: key "{key}": expected unit quaternions w, x, y, z')
