"""What the table says of a jump: one row a jump and seed; SI units, radians.

`COLUMNS` is the schema of jumps.parquet. After its columns come the limits that the spec varies, as
`limit_<name>`. Where a figure does not apply, it is null: durations of a jump that was not planned,
outcomes of one that was not simulated. Names are those of `plan --json` and `simulate --json`.

Rows are the same whatever the number of workers and the order in which they work, columns of
`TIMES` aside; with `diagnose`, which gives up after some seconds, also those of `DIAGNOSED`; with
`replan`, where an answer counts from when it is there, also outcomes. Nothing is rounded. Another
processor, or a machine without a compiler, may change the last bits.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple

from llsrbm.motion.rollout import Outcome

if TYPE_CHECKING:
    import pyarrow as pa

PLANNED, NOT_PLANNED, REFUSED, FAILED = "planned", "not planned", "refused", "failed"
STATUSES = (PLANNED, NOT_PLANNED, REFUSED, FAILED)
"""A plan satisfies every constraint; none does; the request is out of range or contradictory; none
of these, such as a worker that died of it. What is simulated, is planned."""

TEXT, WHOLE, NUMBER, FLAG, NUMBERS, NAMED = "text", "whole", "number", "flag", "numbers", "named"


class Column(NamedTuple):
    """One column.

    Attributes:
        name: lower case.
        kind: what it holds; `NAMED`: name -> number.
        unit: SI; "" of what has none.
        meaning: one sentence without its full stop.
    """

    name: str
    kind: str
    unit: str
    meaning: str


_REQUEST = (
    Column("index", WHOLE, "", "the row's place in the sweep, from 0 on"),
    Column("jump", WHOLE, "", "the jump's place; rows of one jump differ in their seeds alone"),
    Column("id", TEXT, "", "the same for the same request, limits and drives in every sweep"),
    Column("robot", TEXT, "", "name or path of the robot file"),
    Column("model", TEXT, "", "what the planner believes of the robot's inertia"),
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
    Column("drive_torque", NUMBER, "1", "torque of the drives, times the robot file's"),
    Column("drive_speed", NUMBER, "1", "speed of the drives, times the robot file's"),
    Column("seed", WHOLE, "", "of the simulation's disturbance; null: undisturbed"),
)
_PLAN = (
    Column("status", TEXT, "", f"one of: {', '.join(STATUSES)}"),
    Column("stopped_by", TEXT, "", "limit or constraint that stops the jump"),
    Column("constraint", TEXT, "", "the constraint that the nearest try violates most"),
    Column("stop_limit", TEXT, "", "diagnosed: the limit that would have to change"),
    Column("stop_value", NUMBER, "SI", "diagnosed: what that limit is"),
    Column("stop_needed", NUMBER, "SI", "diagnosed: what it would have to be"),
    Column("message", TEXT, "", "what went wrong, in words"),
    Column("iterations", WHOLE, "", "of the solve that counts"),
    Column("attempts", WHOLE, "", "how many guesses were tried"),
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
    Column(
        "joint_margin", NUMBER, "rad", "distance of a joint from its stop at knots, m if it slides"
    ),
    Column("margin_joint", TEXT, "", "whose that is"),
    Column("friction_share", NUMBER, "1", "largest tangential / normal force of a loaded contact"),
    Column("friction_margin", NUMBER, "1", "coefficient of friction minus that"),
    Column("peak_force", NUMBER, "N", "largest force at a contact"),
    Column("violation", NUMBER, "SI", "the largest violation, in its constraint's unit"),
    Column("violations", NAMED, "SI", "constraint -> its largest violation, where not planned"),
)
_PLAN_TIMES = (
    Column("solve_time_s", NUMBER, "s", "inside the solver, the same in all rows of a jump"),
    Column("plan_time_s", NUMBER, "s", "from request to plan, likewise"),
)
# How outcomes are called and typed is said by `Outcome`; what they mean, too.
_OUTCOME_UNITS = {
    "final_yaw_error": "rad",
    "final_position_error": "m",
    "final_tilt": "rad",
    "final_speed": "m/s",
    "yaw_error_at_touchdown": "rad",
    "foot_error_at_touchdown": "m",
    "foot_error": "m",
    "peak_tilt": "rad",
    "takeoff_joint_speed": "rad/s",
    "peak_torque_ratio": "1",
    "peak_speed_ratio": "1",
    "saturated_fraction": "1",
    "real_time_factor": "1",
    "control_rate_hz": "Hz",
}
_RENAMED = {"status": "landed", "reason": "fall"}
_LEFT_OUT = ("foot_touchdown_s",)
_KINDS = {"str": TEXT, "bool": FLAG, "int": WHOLE, "float": NUMBER}


def _outcome_columns() -> tuple[Column, ...]:
    columns = [Column("landed", FLAG, "", "whether the robot stands at the end")]
    for field in fields(Outcome):
        name = _RENAMED.get(field.name, field.name)
        if name == "landed" or field.name in _LEFT_OUT:
            continue
        unit = "s" if name.endswith("_s") else _OUTCOME_UNITS.get(name, "")
        kind = _KINDS[str(field.type).partition(" | ")[0]]
        columns.append(Column(name, kind, unit, f"see Outcome.{field.name}"))
    return tuple(columns)


_ORIGIN = (
    Column("simulation_time_s", NUMBER, "s", "wall time of the simulation"),
    Column("version", TEXT, "", "of llsrbm"),
    Column("robot_hash", TEXT, "", "of the robot file and its URDF"),
)

COLUMNS = (*_REQUEST, *_PLAN, *_PLAN_TIMES, *_outcome_columns(), *_ORIGIN)

TIMES = (
    *("solve_time_s", "plan_time_s", "simulation_time_s"),
    *("tick_median_s", "tick_p99_s", "real_time_factor", "replan_median_s", "replan_p95_s"),
)
"""Columns that differ from run to run."""

DIAGNOSED = ("stopped_by", "stop_limit", "stop_value", "stop_needed", "message")
"""Columns that a diagnosis, which is given up after some seconds, may fill or not."""

LIMIT = "limit_"
"""What the names of columns of varied limits begin with."""


@cache
def schema(limits: tuple[str, ...]) -> pa.Schema:
    """Of a sweep's table, units and meanings beside the fields.

    Args:
        limits: names of those that the spec varies.
    """
    import pyarrow as pa

    types = {
        TEXT: pa.string(),
        WHOLE: pa.int64(),
        NUMBER: pa.float64(),
        FLAG: pa.bool_(),
        NUMBERS: pa.list_(pa.float64()),
        NAMED: pa.map_(pa.string(), pa.float64()),
    }
    asked = [Column(LIMIT + name, NUMBER, "SI", f"the limit {name}") for name in limits]
    return pa.schema(
        [
            pa.field(
                column.name,
                types[column.kind],
                metadata={"unit": column.unit, "meaning": column.meaning},
            )
            for column in (*COLUMNS, *asked)
        ]
    )


def table_of(rows: Sequence[Mapping[str, Any]], limits: tuple[str, ...]) -> pa.Table:
    """Rows as a table; what a row does not name is null.

    Raises:
        KeyError: a row names a column that there is not.
    """
    import pyarrow as pa

    wanted = schema(limits)
    for row in rows:
        if unknown := row.keys() - {*wanted.names}:
            raise KeyError(f"no such columns: {sorted(unknown)}")
    columns = {name: [_plain(row.get(name)) for row in rows] for name in wanted.names}
    return pa.table(columns, schema=wanted)


def _plain(value: Any) -> Any:
    """Of names with numbers, pairs."""
    return list(value.items()) if isinstance(value, Mapping) else value
