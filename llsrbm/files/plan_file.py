"""The native file of a `Plan`: npz without pickle, schema llsrbm.plan/2.

Files of schema 1 have no velocities and torques of the joints. They are computed when such a file
is read, if the robot is one of the project's own and still the same; otherwise they are not known.
Plans without them (among them some that failed) are written as schema 1. Files from before there
were schedules have none in `meta`: theirs is `together`. Only plans over an obstacle have
one there.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from llsrbm.errors import Error, FileFormatError, InputError, printable
from llsrbm.files.archive import Arrays, checked, read_archive, text, write_archive
from llsrbm.files.native_file import (
    Meta,
    check_numbers,
    check_schema,
    check_times,
    native_arrays,
    read_meta,
)
from llsrbm.installed import package_version
from llsrbm.motion.plan import Plan, SolveReport, Violation, leg_names
from llsrbm.motion.quantity import ROW, VARIABLE, Quantity, quantities
from llsrbm.ocp.problem import Iterate
from llsrbm.request.obstacle import Obstacle
from llsrbm.request.schedule import Schedule, together
from llsrbm.request.tuning import Tuning

SCHEMA = "llsrbm.plan/2"
FIRST_SCHEMA = "llsrbm.plan/1"
SCHEMAS = (SCHEMA, FIRST_SCHEMA)

_LOADS = ("joint_velocity", "joint_torque", "joint_torque_limit")
LAYOUT = quantities(Plan)
FIRST_LAYOUT = {name: quantity for name, quantity in LAYOUT.items() if name not in _LOADS}

# The solver's own numbers, which later solves start from; not every file has them.
_SOLUTION = {"variables": "solution_variables", "multipliers": "solution_multipliers"}
_SOLUTION_LAYOUT = {
    "solution_variables": Quantity((VARIABLE,), "", "the solver's variables"),
    "solution_multipliers": Quantity((ROW,), "", "the multipliers of its constraints"),
}

_LONGEST_MESSAGE = 300  # characters that a file's own words may take of a message
_MOST_KNOTS = 1000  # a knot's loads take a millisecond; plans have 49

# Of a robot's numbers those on which torques and their limits depend.
_OF_LOADS = ("mass", "com", "inertia", "feet", "hips", "joint_names")
_LIMITS_OF_LOADS = ("torque", "joint_speed")


class _Meta(Meta):
    report: SolveReport
    violations: dict[str, Violation]
    tuning: Tuning = Tuning()  # files of 0.1 have none
    schedule: dict[str, Any] | None = None
    obstacle: dict[str, Any] | None = None


def save_plan(plan: Plan, path: str | Path) -> None:
    """Write `plan` at exactly that path, atomically.

    Raises:
        InputError: the file cannot be written.
        Error: the plan holds numbers that are not finite.
    """
    write_archive(path, plan_arrays(plan))


def plan_arrays(plan: Plan) -> Arrays:
    """What a file holds of a plan.

    Raises:
        Error: the plan holds numbers that are not finite.
    """
    meta = _Meta(
        request=plan.jump,
        model=plan.jump.model,
        robot_parameters=plan.robot_parameters,
        report=plan.report,
        violations=plan.violations,
        tuning=plan.tuning,
        schedule=plan.schedule.as_dict(),
        obstacle=None if plan.obstacle is None else plan.obstacle.as_dict(),
        package_version=package_version(),
    )
    known = all(getattr(plan, name) is not None for name in _LOADS)
    schema, layout = (SCHEMA, LAYOUT) if known else (FIRST_SCHEMA, FIRST_LAYOUT)
    arrays = native_arrays(schema, meta, plan, layout)
    if plan.solution is not None:
        arrays |= {key: getattr(plan.solution, name) for name, key in _SOLUTION.items()}
    return arrays


def load_plan(path: str | Path) -> Plan:
    """Read a plan's file.

    Raises:
        FileFormatError: unreadable, damaged, of another schema, or not a plan.
    """
    arrays = read_archive(path)
    check_schema(arrays, path, SCHEMAS)
    return plan_from_arrays(arrays, path)


def plan_from_arrays(arrays: Arrays, path: str | Path) -> Plan:
    """The plan in an archive of either schema that has been read; `path` is for messages.

    Raises:
        FileFormatError: a key is missing or holds something else.
    """
    meta = read_meta(_Meta, arrays, path)
    first = text(arrays, "schema", path) == FIRST_SCHEMA
    layout = FIRST_LAYOUT if first else LAYOUT
    values: dict[str, Any] = checked(arrays, layout, path)
    check_numbers(values, layout, path)
    _check_body(values, path)
    schedule = _schedule(meta, len(values["leg_mass"]), path)
    _check_phases(values, schedule, path)
    values["base_mass"] = float(values["base_mass"])
    values["joint_names"] = tuple(str(name) for name in values["joint_names"])
    plan = Plan(
        jump=meta.request,
        robot_parameters=meta.robot_parameters,
        report=meta.report,
        violations=meta.violations,
        tuning=meta.tuning,
        solution=_solution(arrays, path),
        schedule=schedule,
        obstacle=_obstacle(meta, path),
        **values,
    )
    return _with_loads(plan) if first else plan


def _solution(arrays: Arrays, path: str | Path) -> Iterate | None:
    if not any(key in arrays for key in _SOLUTION_LAYOUT):
        return None
    values = checked(arrays, _SOLUTION_LAYOUT, path)
    return Iterate(**{name: values[key] for name, key in _SOLUTION.items()})


def _with_loads(plan: Plan) -> Plan:
    """With velocities and torques of the joints, if the robot is the one that it was made with."""
    from llsrbm.body.joint_loads import KnotMotion, joint_loads
    from llsrbm.robots import load_robot, names

    # A path would have a stranger's file choose what is read on this machine.
    if plan.jump.robot not in names() or len(plan.time) > _MOST_KNOTS:
        return plan
    try:
        robot = load_robot(plan.jump.robot)
    except Error:
        return plan
    if not _same(_of_loads(robot.parameters()), _of_loads(plan.robot_parameters)):
        return plan
    legs = len(robot.legs)
    contacts = legs * len(robot.corners)
    shapes = (plan.foot_position.shape[1], plan.contact_point.shape[1], plan.joint_names)
    if shapes != (legs, contacts, robot.joint_names):
        return plan
    return replace(plan, **joint_loads(robot, KnotMotion.of_plan(plan)).at_knots())


def _of_loads(parameters: dict[str, Any]) -> list[Any]:
    limits = parameters.get("limits")
    bounds = limits if isinstance(limits, dict) else {}
    return [parameters.get(n) for n in _OF_LOADS] + [bounds.get(n) for n in _LIMITS_OF_LOADS]


def _same(a: Any, b: Any) -> bool:
    """Whether two numbers, texts, or lists of them agree, numbers within rounding."""
    if isinstance(a, list | tuple) and isinstance(b, list | tuple):
        return len(a) == len(b) and all(map(_same, a, b))
    if isinstance(a, float | int) and isinstance(b, float | int):
        return bool(np.isclose(a, b, rtol=1e-6, atol=1e-9))
    return bool(a == b)


def _schedule(meta: _Meta, legs: int, path: str | Path) -> Schedule:
    """The schedule in a file of a plan with that many legs."""
    if meta.schedule is None:
        return together(leg_names(meta.robot_parameters, legs))
    where = f'{path}: key "meta"'
    try:
        schedule = Schedule.from_dict(meta.schedule)
    except InputError as error:
        raise FileFormatError(f"{where}: {printable(str(error), _LONGEST_MESSAGE)}") from error
    if len(schedule.legs) != legs:
        told = printable(", ".join(schedule.legs), 100)
        raise FileFormatError(
            f'{where}: schedule: it has the legs {told}; expected {legs}, as "leg_mass" has'
        )
    return schedule


def _obstacle(meta: _Meta, path: str | Path) -> Obstacle | None:
    if meta.obstacle is None:
        return None
    try:
        return Obstacle.from_dict(meta.obstacle)
    except InputError as error:
        told = printable(str(error), _LONGEST_MESSAGE)
        raise FileFormatError(f'{path}: key "meta": {told}') from error


def _check_phases(values: Arrays, schedule: Schedule, path: str | Path) -> None:
    """Each phase has an interval, and the last knot, which begins none, is in the last phase."""
    check_times(values["time"], path)
    phase, last = values["phase"], len(schedule) - 1
    steps = np.diff(phase[:-1], prepend=-1)
    if not np.isin(steps, (0, 1)).all() or steps[0] != 1 or (phase[-2:] != last).any():
        names = ", ".join(f"{number} ({name})" for number, name in enumerate(schedule.names))
        raise FileFormatError(
            f'{path}: key "phase": expected {printable(names, _LONGEST_MESSAGE)}, each of them '
            "with an interval, in that order"
        )


def _check_body(values: Arrays, path: str | Path) -> None:
    if values["base_mass"] <= 0 or (values["leg_mass"] < 0).any():
        raise FileFormatError(f'{path}: keys "base_mass", "leg_mass": expected masses, in kg')
    legs, contacts = len(values["leg_mass"]), values["contact_point"].shape[1]
    if contacts % legs:
        raise FileFormatError(
            f'{path}: key "contact_point": expected as many contacts for each of {legs} legs, got '
            f"{contacts}"
        )
