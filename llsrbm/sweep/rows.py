"""The table's columns: one row a jump and seed; SI units, radians.

`COLUMNS` is the schema of jumps.parquet. After its columns come the limits that the spec varies, as
`limit_<name>`, and with `trajectories = true` those of `motion_columns`. Where a figure does not
apply, it is null: durations of a jump that was not planned, outcomes of one that was not simulated.
Names are those of `plan --json` and `simulate --json`.

Rows are the same whatever the number of workers and the order in which they work, columns of
`TIMES` and rows that timed out aside; with `diagnose`, which gives up after some seconds, also
those of `DIAGNOSED`; with `replan`, where an answer counts from when it is there, also outcomes.
Nothing is rounded. Another processor, or a machine without a compiler, may change the last bits.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from typing import TYPE_CHECKING, Any, NamedTuple

from llsrbm.cache import content_key
from llsrbm.installed import package_version
from llsrbm.motion.outcome import Outcome
from llsrbm.sweep.spec import Spec

if TYPE_CHECKING:
    import pyarrow as pa

    from llsrbm.motion.plan import Plan

TableRow = dict[str, Any]
"""Column name -> value; a name that is missing is null."""

PLANNED, NOT_PLANNED, REFUSED = "planned", "not planned", "refused"
NOT_CERTIFIED, TIMED_OUT, FAILED = "not certified", "timed out", "failed"
STATUSES = (PLANNED, NOT_PLANNED, NOT_CERTIFIED, REFUSED, TIMED_OUT, FAILED)
"""A plan satisfies every constraint; none was found; there is one that is not certified, and drafts
are not asked for: it is neither simulated nor kept; the request is out of range or
contradictory; no result within the limit of time; anything else, such as a process that died. A
simulated jump is planned."""

TEXT, WHOLE, NUMBER, FLAG, NUMBERS, NAMED = "text", "whole", "number", "flag", "numbers", "named"
TEXTS = "texts"


class Column(NamedTuple):
    """One column; `kind` is the type of its values, `NAMED`: name -> number."""

    name: str
    kind: str
    unit: str
    meaning: str


_REQUEST = (
    Column("index", WHOLE, "", "the row's place in the sweep, from 0 on"),
    Column("jump", WHOLE, "", "the jump's place; rows of one jump differ in their seeds alone"),
    Column("id", TEXT, "", "the same for the same request, limits and drives in every sweep"),
    Column("robot", TEXT, "", "name or path of the robot file"),
    Column("model", TEXT, "", "model of the robot's inertia in the planner"),
    Column("type", TEXT, "", "jump type"),
    Column("twist", NUMBER, "rad", "turn about the vertical, positive to the left"),
    Column("forward", NUMBER, "m", "displacement along x"),
    Column("lateral", NUMBER, "m", "displacement along y, positive to the left"),
    Column("height", NUMBER, "m", "landing surface above the ground at the start"),
    Column("roll", NUMBER, "rad", "whole turns about the body's x axis"),
    Column("pitch", NUMBER, "rad", "whole turns about the body's y axis"),
    Column("speed", NUMBER, "m/s", "forward speed at the start"),
    Column("end_speed", NUMBER, "m/s", "forward speed at the end"),
    Column("hops", WHOLE, "", "jumps in a row"),
    Column("slope", NUMBER, "rad", "landing surface, by which it rises ahead"),
    Column("cross_slope", NUMBER, "rad", "landing surface, by which it rises to the left"),
    Column("takeoff_slope", NUMBER, "rad", "take-off surface, by which it rises ahead"),
    Column("takeoff_cross_slope", NUMBER, "rad", "take-off surface, by which it rises to the left"),
    Column("gap", NUMBER, "m", "width of the gap that the whole robot passes over"),
    Column("bar", NUMBER, "m", "height of the bar that the whole robot passes over"),
    Column("arms", TEXT, "", "of a robot that has some: free or held"),
    Column("drive_torque", NUMBER, "1", "torque of the drives, times the robot file's"),
    Column("drive_speed", NUMBER, "1", "speed of the drives, times the robot file's"),
    Column("seed", WHOLE, "", "of the simulation's disturbance; null: undisturbed"),
)
_PLAN = (
    Column("status", TEXT, "", f"one of: {', '.join(STATUSES)}"),
    Column("stopped_by", TEXT, "", "limit or constraint that stops the jump"),
    Column("constraint", TEXT, "", "the constraint that the nearest try violates most"),
    Column("stop_limit", TEXT, "", "diagnosed: the limit that would have to change"),
    Column("stop_value", NUMBER, "SI", "diagnosed: the value of that limit"),
    Column(
        "stop_needed", NUMBER, "SI", "diagnosed: the value that it would need, if one alone does"
    ),
    Column("message", TEXT, "", "the error"),
    Column("iterations", WHOLE, "", "of draft and whole body, those that count"),
    Column("attempts", WHOLE, "", "guesses of the draft; 0: begun from solved jumps"),
    Column("cost", NUMBER, "", "of the plan"),
    Column("duration_s", NUMBER, "s", "of the motion"),
    Column("takeoff_s", NUMBER, "s", "until no foot stands for the first time"),
    Column("flight_s", NUMBER, "s", "without a foot on the ground, all flights"),
    Column("landing_s", NUMBER, "s", "from the last touchdown to the end"),
    Column("lift_off_s", NUMBER, "s", "when the first flight begins"),
    Column("touchdown_s", NUMBER, "s", "when the last flight ends"),
    Column("phase_durations_s", NUMBERS, "s", "of each phase"),
    Column("final_yaw", NUMBER, "rad", "turn of the base"),
    Column("peak_yaw_rate", NUMBER, "rad/s", "largest |angular velocity about z|"),
    Column("apex", NUMBER, "m", "highest point of the CoM above its height at the start"),
    Column("joint_torque_ratio", NAMED, "1", "largest share of the torque available at its speed"),
    Column("torque_share", NUMBER, "1", "the largest of them"),
    Column("torque_joint", TEXT, "", "whose that is"),
    Column("torque_phase", TEXT, "", "the phase in which that is"),
    Column("speed_share", NUMBER, "1", "largest joint speed, share of its limit, at knots"),
    Column("speed_joint", TEXT, "", "whose that is"),
    Column("joint_margin", NUMBER, "rad", "joint to its stop at knots, m if it slides"),
    Column("margin_joint", TEXT, "", "whose that is"),
    Column("friction_share", NUMBER, "1", "largest tangential / normal force of a loaded contact"),
    Column("friction_margin", NUMBER, "1", "coefficient of friction minus that"),
    Column("peak_force", NUMBER, "N", "largest force at a contact"),
    Column("certified", FLAG, "", "whether a certificate holds, null of drafts"),
    Column("uncertified", TEXTS, "", "checks of the certificate that do not hold, likewise"),
    Column("violation", NUMBER, "SI", "the largest violation, in its constraint's unit"),
    Column("violations", NAMED, "SI", "constraint -> its largest violation, where not planned"),
    Column("solve_time_s", NUMBER, "s", "inside the solver, the same in all rows of a jump"),
    Column("plan_time_s", NUMBER, "s", "from request to plan, likewise"),
)
# Names and types of outcomes are those of `Outcome`.
_OUTCOMES_OF_UNITS = {
    "rad": (
        *("final_yaw_error", "final_tilt", "peak_tilt", "yaw_error_at_touchdown"),
        *("yaw_error_at_lift_off", "yaw_error_in_flight", "yaw_error_at_planned_touchdown"),
    ),
    "m": ("final_position_error", "foot_error_at_touchdown", "foot_error"),
    "m/s": ("final_speed",),
    "rad/s": ("takeoff_joint_speed",),
    "1": ("peak_torque_ratio", "peak_speed_ratio", "saturated_fraction", "real_time_factor"),
    "Hz": ("control_rate_hz",),
}
_OUTCOME_UNITS = {name: unit for unit, names in _OUTCOMES_OF_UNITS.items() for name in names}
_KINDS = {"str": TEXT, "bool": FLAG, "int": WHOLE, "float": NUMBER}
_OF_OUTCOME = (
    Column("landed", FLAG, "", "whether the robot stands at the end"),
    *(
        Column(
            "fall" if field.name == "reason" else field.name,
            _KINDS[str(field.type).partition(" | ")[0]],
            "s" if field.name.endswith("_s") else _OUTCOME_UNITS.get(field.name, ""),
            f"see Outcome.{field.name}",
        )
        for field in fields(Outcome)
        if field.name not in ("status", "foot_touchdown_s")
    ),
)

_ORIGIN = (
    Column("simulation_time_s", NUMBER, "s", "wall time of the simulation"),
    Column("version", TEXT, "", "of llsrbm"),
    Column("robot_hash", TEXT, "", "of the robot file and its URDF"),
)

COLUMNS = (*_REQUEST, *_PLAN, *_OF_OUTCOME, *_ORIGIN)

_MOTION_PREFIX = "motion_"
_MOTION = (
    *("time", "phase", "com", "com_velocity", "base_position", "base_quat", "angular_velocity"),
    *("angular_momentum", "foot_position", "contact_force"),
    *("joint_position", "joint_velocity", "joint_torque"),
)


def motion_columns() -> tuple[Column, ...]:
    """The planned motion, in the first row of each planned jump.

    `numpy.reshape(value, (knots, -1))` has a row a knot.
    """
    from llsrbm.files.quantity import quantities
    from llsrbm.motion.plan import Plan

    known = quantities(Plan)
    numbers = (
        Column(_MOTION_PREFIX + n, NUMBERS, known[n].unit, f"`{n}` of plan.npz, knot after knot")
        for n in _MOTION
    )
    names = "joints, in the order of the columns above"
    return (
        *numbers,
        Column(_MOTION_PREFIX + "joint_names", TEXTS, "", names),
        Column(_MOTION_PREFIX + "leg_names", TEXTS, "", "legs, likewise"),
    )


TIMES = (
    *("solve_time_s", "plan_time_s", "simulation_time_s"),
    *("tick_median_s", "tick_p99_s", "real_time_factor", "replan_median_s", "replan_p95_s"),
)
"""Columns that differ from run to run."""

DIAGNOSED = ("stopped_by", "stop_limit", "stop_value", "stop_needed", "message")
"""Columns that a diagnosis, which is given up after some seconds, may fill or not."""

LIMIT = "limit_"
"""Prefix of the columns of varied limits."""


def schema(spec: Spec) -> pa.Schema:
    """Schema of a sweep's table, with units and meanings beside the fields."""
    import pyarrow as pa

    types = {
        TEXT: pa.string(),
        WHOLE: pa.int64(),
        NUMBER: pa.float64(),
        FLAG: pa.bool_(),
        NUMBERS: pa.list_(pa.float64()),
        TEXTS: pa.list_(pa.string()),
        NAMED: pa.map_(pa.string(), pa.float64()),
    }
    limits = [Column(LIMIT + name, NUMBER, "SI", f"the limit {name}") for name in spec.limits]
    columns = (*COLUMNS, *limits, *(motion_columns() if spec.trajectories else ()))
    return pa.schema(
        [
            pa.field(name, types[kind], metadata={"unit": unit, "meaning": meaning})
            for name, kind, unit, meaning in columns
        ]
    )


def table_of(rows: Sequence[TableRow], wanted: pa.Schema) -> pa.Table:
    """Rows as a table. Raises `KeyError`: a row names a column that the schema does not have."""
    import pyarrow as pa

    for row in rows:
        if unknown := row.keys() - {*wanted.names}:
            raise KeyError(f"no such columns: {sorted(unknown)}")
    return pa.Table.from_pylist([*rows], schema=wanted)


def motion_of(plan: Plan) -> TableRow:
    """The columns of `motion_columns`."""
    arrays = {name: getattr(plan, name) for name in _MOTION}
    row = {n: None if a is None else a.astype(float).ravel() for n, a in arrays.items()}
    row |= {name: list(getattr(plan, name)) for name in ("joint_names", "leg_names")}
    return {_MOTION_PREFIX + name: value for name, value in row.items()}


def origin(spec: Spec) -> dict[str, str]:
    """Versions that rows depend on: robot -> hash of its files, "llsrbm" -> version."""
    return {"llsrbm": package_version(), **{robot: robot_hash(robot) for robot in spec.robots}}


def robot_hash(name_or_path: str) -> str:
    """Hash of a robot's file and its URDF as they are now. Raises `InputError`: no such robot, or a
    `RobotFileError`: its file is wrong.
    """
    from llsrbm.robots import load_robot

    robot = load_robot(name_or_path)
    return content_key(robot.path, robot.urdf.content).hex()[:16]
