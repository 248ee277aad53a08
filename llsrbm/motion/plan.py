"""`Plan`: the planned jump, one array a quantity, N + 1 knots; its file, npz of llsrbm.plan/2."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import Field, FiniteFloat, PlainSerializer, PlainValidator

from llsrbm.arrays import Array, BoolArray, IntArray
from llsrbm.errors import FileFormatError, printable
from llsrbm.files.native import (
    Meta,
    StatedCertificate,
    check_phases,
    check_schema,
    check_times,
    native_arrays,
    read_meta,
)
from llsrbm.files.npz import Arrays, checked, read_archive, write_archive
from llsrbm.files.quantity import (
    CONTACT,
    ERROR,
    HIP,
    JOINT,
    LEG,
    ROW,
    TIME,
    VARIABLE,
    Between,
    Quantity,
    attitude,
    coded,
    inertia_tensor,
    names,
    of_joints,
    quantities,
    vector,
)
from llsrbm.motion.of_robot import OfRobot
from llsrbm.motion.solve_report import NEAREST, Effort, Refinement, SolveReport, Violation
from llsrbm.ocp.horizon import Iterate
from llsrbm.request.jump import Jump
from llsrbm.request.obstacle import Obstacle
from llsrbm.request.schedule import Schedule
from llsrbm.request.tuning import Tuning


@dataclass(frozen=True, eq=False, repr=False)
class Plan(OfRobot):
    """A planned jump at N + 1 knots: T = N + 1, L legs, C contacts, J joints.

    The meaning of each array stands beside it; see `llsrbm.files.quantity`.

    Attributes:
        robot_parameters: the numbers of the robot that were used, as plain data.
        violations: constraint name -> largest violation, recomputed with NumPy.
        tuning: weights and limits that were requested in place of the robot's.
        limits: name -> value in SI units of every limit that it was planned under: the request's,
            else the jump type's, else the robot's (`llsrbm.planning.problem.limits`). Files that
            were written before files held them have the request's alone.
        solution: of the solver, for plans that start from this one; None of a plan that failed.
        refinement: of the second stage, if there was one. Knots of a refined plan are those of its
            intervals and the middles between them; `report` and `solution` are of the first stage.
        certificate: findings of `llsrbm.certify`, once `llsrbm.certified` has added them.
        feedback_gain: likewise of `llsrbm.with_feedback`, which says what it is.

    Velocities and torques of the joints are None in a plan that failed so badly that its motion has
    none.
    """

    jump: Jump
    robot_parameters: dict[str, Any]
    report: SolveReport
    violations: dict[str, Violation]
    schedule: Schedule
    time: Annotated[Array, Quantity((TIME,), "s", "strictly increasing", Between.LINEAR)]
    phase: Annotated[
        IntArray,
        coded(
            "phase of the interval that begins there, as in the schedule", coded_by="phase_names"
        ),
    ]
    com: Annotated[Array, vector("m", "centre of mass", Between.BALLISTIC)]
    com_velocity: Annotated[Array, vector("m/s", "velocity of the CoM", rate=True)]
    base_quat: Annotated[Array, attitude("attitude of the URDF's root link")]
    base_position: Annotated[Array, vector("m", "origin of the URDF's root link", Between.FROM_COM)]
    angular_velocity: Annotated[Array, vector("rad/s", "angular velocity of the base", rate=True)]
    linear_momentum: Annotated[Array, vector("kg m/s", "linear momentum", rate=True)]
    angular_momentum: Annotated[
        Array, vector("kg m2/s", "angular momentum about the CoM", Between.BALLISTIC, rate=True)
    ]
    inertia: Annotated[Array, inertia_tensor("centroidal, as the model has it", Between.IN_BASE)]
    foot_position: Annotated[
        Array,
        vector("m", "contact point of a point foot, middle of a sole", Between.STANDING, of=LEG),
    ]
    foot_quat: Annotated[
        Array, attitude("attitude of soles, which are level; identity for point feet", of=LEG)
    ]
    contact_point: Annotated[
        Array, vector("m", "contact points, legs x corners", Between.CARRIED, of=CONTACT)
    ]
    contact_force: Annotated[
        Array,
        vector("N", "at a contact, over the interval that begins there", Between.HELD, of=CONTACT),
    ]
    leg_mass: Annotated[Array, Quantity((LEG,), "kg", "mass of a leg, lumped", listed=False)]
    base_mass: Annotated[float, Quantity((), "kg", "mass of the base", listed=False)]
    leg_com: Annotated[
        Array, vector("m", "where the model puts a leg's point mass", Between.FROM_COM, of=LEG)
    ]
    joint_position: Annotated[
        Array,
        of_joints(
            "rad", "posture whose feet, by base and joints, are on foot_position", Between.JOINTS
        ),
    ]
    joint_names: Annotated[tuple[str, ...], names(JOINT, "order of the joints")]
    foot_in_hip: Annotated[
        Array,
        Quantity(
            (TIME, LEG, HIP),
            "m",
            "in the leg's mirrored hip frame as the model sees it, with the yaw (rad) of a sole",
            Between.LINEAR,
            "hip",
            listed=False,
        ),
    ]
    joint_velocity: Annotated[
        Array | None,
        of_joints("rad/s", "velocity, zero at both ends", Between.JOINT_RATES, rate=True),
    ] = None
    # By inverse dynamics of the whole body (`llsrbm.body.joint_loads`).
    joint_torque: Annotated[
        Array | None,
        of_joints("Nm", "in the middle of the interval; the last are of standing", Between.HELD),
    ] = None
    joint_torque_limit: Annotated[
        Array | None,
        of_joints("Nm", "of the drives at that speed, in the torque's direction", Between.HELD),
    ] = None
    feedback_gain: Annotated[
        Array | None,
        Quantity(
            (TIME, JOINT, ERROR),
            "Nm",
            "what a torque falls by for each part of the state's error, one of each SI unit",
            Between.HELD,
            "base",
            listed=False,
        ),
    ] = None
    tuning: Tuning = field(default_factory=Tuning)
    limits: Mapping[str, float] = field(default_factory=dict)
    solution: Iterate | None = None
    obstacle: Obstacle | None = None
    refinement: Refinement | None = None
    certificate: StatedCertificate | None = None

    @property
    def friction(self) -> float:
        """Coefficient of friction that it was planned with."""
        own = self.robot_parameters.get("limits") or {}
        return float(self.limits.get("friction", own.get("friction", DEFAULT_FRICTION)))

    @property
    def refined(self) -> bool:
        """True if the motion is one of the whole body's equations of motion."""
        return self.refinement is not None and self.refinement.status == "solved"

    @property
    def certified(self) -> bool:
        """True if it carries a certificate that holds in every check; see `llsrbm.certified`."""
        findings = (self.certificate or {}).values()
        return bool(findings) and all(found["holds"] for found in findings)

    @property
    def solved(self) -> bool:
        """True if every constraint is satisfied."""
        return self.report.status == "solved"

    @property
    def effort(self) -> Effort:
        """Iterations and times of draft and whole body together."""
        return Effort.of(self.report, self.refinement)

    @property
    def cost(self) -> float:
        """Value of the objective whose motion this is: the whole body's, else the draft's."""
        refinement = self.refinement
        return self.report.cost if refinement is None or not self.refined else refinement.cost

    @property
    def is_nearest(self) -> bool:
        """True if it was planned in place of another request, which is not feasible."""
        return self.report.guess == NEAREST

    @property
    def duration(self) -> float:
        """Length of the motion, s."""
        return float(self.time[-1])

    @cached_property
    def phase_start(self) -> Array:
        """(P + 1,) s: start of each of the schedule's phases, and the end."""
        first = [int(np.argmax(self.phase == p)) for p in range(len(self.schedule))]
        return np.append(self.time[first], self.time[-1])

    @property
    def contact(
        self,
    ) -> Annotated[
        BoolArray,
        coded("whether it stands in the interval from there", *("in the air", "touches"), of=LEG),
    ]:
        """(N+1, L) whether a foot stands over the interval that begins at a knot."""
        return self.schedule.stands[self.phase]

    @property
    def lift_off(self) -> float:
        """s: when the first flight begins: no foot stands any more."""
        return float(self.phase_start[self.schedule.flights[0]])

    @property
    def touchdown(self) -> float:
        """s: when the last flight ends, as the first foot lands."""
        return float(self.phase_start[self.schedule.flights[-1] + 1])

    @property
    def airborne(self) -> float:
        """s without a foot on the ground, all flights together."""
        return float(np.diff(self.phase_start)[[*self.schedule.flights]].sum())

    def save(self, path: str | Path) -> None:
        """Write the native npz file (schema llsrbm.plan/2); see `llsrbm.load`.

        Raises:
            InputError: the file cannot be written.
            Error: the plan holds numbers that are not finite.
        """
        write_archive(path, self.arrays())

    def arrays(self) -> Arrays:
        """The content of the plan's file; raises `Error` for numbers that are not finite."""
        stated = {name: getattr(self, name) for name in _STATED}
        meta = _Meta(request=self.jump, model=self.jump.model, **stated)
        arrays = native_arrays(SCHEMA, meta, self, quantities(Plan))
        if self.solution is not None:
            arrays |= {key: getattr(self.solution, name) for name, key in _SOLUTION.items()}
        return arrays

    @staticmethod
    def from_arrays(arrays: Arrays, path: str | Path) -> Plan:
        """The plan in an archive that has been read; `path` is for messages. Raises
        `FileFormatError`: of another schema, or a key is missing or holds something else.
        """
        check_schema(arrays, path, SCHEMA)
        meta = read_meta(_Meta, arrays, path)
        layout = quantities(Plan)
        for optional in (_LOADS, OPTIONAL):
            if not any(key in arrays for key in optional):
                layout = {key: each for key, each in layout.items() if key not in optional}
        values: dict[str, Any] = checked(arrays, layout, path)
        _check(values, meta.schedule, path)
        _check_stones(meta.request, meta.schedule, path)
        values["base_mass"] = float(values["base_mass"])
        values["joint_names"] = tuple(str(name) for name in values["joint_names"])
        solution = None
        if any(key in arrays for key in _SOLUTION_LAYOUT):
            found = checked(arrays, _SOLUTION_LAYOUT, path)
            solution = Iterate(**{name: found[key] for name, key in _SOLUTION.items()})
        stated = {name: getattr(meta, name) for name in _STATED}
        stated["limits"] = meta.limits or dict(meta.tuning.limits)
        if meta.refinement is not None and meta.refinement.status == "solved":
            _check_refined(values, path)
        return Plan(jump=meta.request, solution=solution, **stated, **values)


SCHEMA = "llsrbm.plan/2"
DEFAULT_FRICTION = 0.5  # of robots whose numbers do not say it


# What stands at `meta` under its own name.
_STATED = (
    "robot_parameters",
    "report",
    "violations",
    "tuning",
    "limits",
    "schedule",
    "obstacle",
    "refinement",
    "certificate",
)
_LOADS = ("joint_velocity", "joint_torque", "joint_torque_limit")
OPTIONAL = ("feedback_gain",)  # arrays of plans that somebody has asked for
_SOLUTION = {"variables": "solution_variables", "multipliers": "solution_multipliers"}
_SOLUTION_LAYOUT = {
    "solution_variables": Quantity((VARIABLE,), "", "the solver's variables"),
    "solution_multipliers": Quantity((ROW,), "", "the multipliers of its constraints"),
}


class _Meta(Meta):
    report: SolveReport
    violations: dict[str, Violation]
    tuning: Tuning
    limits: Annotated[dict[str, FiniteFloat], Field(max_length=1000)] = Field(default_factory=dict)
    schedule: Annotated[
        Schedule,
        PlainValidator(lambda t: t if isinstance(t, Schedule) else Schedule.from_dict(t)),
        PlainSerializer(Schedule.as_dict),
    ]
    obstacle: Annotated[
        Obstacle | None,
        PlainValidator(lambda t: t if isinstance(t, Obstacle | None) else Obstacle.from_dict(t)),
        PlainSerializer(lambda obstacle: obstacle and obstacle.as_dict()),
    ] = None
    refinement: Refinement | None = None


def _check(values: Arrays, schedule: Schedule, path: str | Path) -> None:
    """Raise `FileFormatError` unless masses, legs, contacts, times and phases fit each other."""
    if values["base_mass"] <= 0 or (values["leg_mass"] < 0).any():
        raise FileFormatError(f'{path}: keys "base_mass", "leg_mass": expected masses, in kg')
    legs, contacts = len(values["leg_mass"]), values["contact_point"].shape[1]
    if contacts % legs:
        raise FileFormatError(
            f'{path}: key "contact_point": expected as many contacts for each of {legs} legs, got '
            f"{contacts}"
        )
    if len(schedule.legs) != legs:
        names = printable(", ".join(schedule.legs), 100)
        raise FileFormatError(
            f'{path}: key "meta": schedule: it has the legs {names}; expected {legs}, as '
            '"leg_mass" has'
        )
    check_times(values["time"], path)
    # Each phase has an interval, and the last knot, which begins none, is in the last phase.
    phase, last = values["phase"], len(schedule) - 1
    steps = np.diff(phase[:-1], prepend=-1)
    if not np.isin(steps, (0, 1)).all() or steps[0] != 1 or (phase[-2:] != last).any():
        check_phases(phase, schedule.names, path, ", each of them with an interval, in that order")


def _check_stones(jump: Jump, schedule: Schedule, path: str | Path) -> None:
    """Raise `FileFormatError` unless the request's stones are of legs that land."""
    for leg in (stone.leg for stone in jump.stones):
        if leg not in schedule.legs:
            raise FileFormatError(
                f'{path}: key "meta": stones: no leg "{printable(leg)}"; expected some of '
                f"{printable(', '.join(schedule.legs), 100)}"
            )


def _check_refined(values: Arrays, path: str | Path) -> None:
    """Raise `FileFormatError` unless intervals come in pairs, with torques (`sampling`)."""
    if len(values["time"]) % 2 == 0 or values.get("joint_torque") is None:
        raise FileFormatError(
            f'{path}: key "meta": it is of a refined plan; expected an odd number of knots and '
            'the key "joint_torque"'
        )


def load_plan(path: str | Path) -> Plan:
    """Read a plan's file (`llsrbm.load` reads rollouts as well); raises `FileFormatError`."""
    return Plan.from_arrays(read_archive(path), path)
