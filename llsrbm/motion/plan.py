"""`Plan`: the planned jump, one array a quantity, N + 1 knots."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from llsrbm.motion.quantity import (
    CONTACT,
    HIP,
    JOINT,
    LEG,
    TENSOR,
    TIME,
    WXYZ,
    XYZ,
    Array,
    Between,
    Kind,
    Quantity,
)
from llsrbm.ocp.problem import Iterate
from llsrbm.request.jump import Jump
from llsrbm.request.obstacle import Obstacle
from llsrbm.request.schedule import Schedule, together
from llsrbm.request.tuning import Tuning


@dataclass(frozen=True)
class Violation:
    """By how much one named constraint is violated, recomputed from the result.

    Attributes:
        amount: largest violation, in `unit`; 0 when satisfied.
        unit: SI unit of the amount.
        phase: name of the schedule's phase in which it is largest.
        time: when, s.
    """

    amount: float
    unit: str
    phase: str
    time: float


@dataclass(frozen=True)
class SolveReport:
    """How the solver got there.

    Attributes:
        status: "solved" or "not-converged".
        solver: name of the solver ("fatrop", "ipopt").
        iterations: interior-point iterations of the attempt that is returned.
        attempts: initial guesses tried, 1 when the analytic one was enough.
        solve_time_s: wall time inside the solver, all attempts.
        total_time_s: wall time from request to `Plan`, solver already built.
        build_time_s: wall time to build or load the solver for this request, 0 when it was at hand.
        cost: value of the objective.
        guess: from where the attempt that is returned began, in words; "" in files of before.
    """

    status: str
    solver: str
    iterations: int
    attempts: int
    solve_time_s: float
    total_time_s: float
    build_time_s: float
    cost: float
    guess: str = ""


@dataclass(frozen=True, eq=False)
class Plan:
    """A planned jump at N + 1 knots: T = N + 1, L legs, C contacts, J joints.

    What each array is stands beside it; `llsrbm.motion.quantity` explains the words.

    Attributes:
        jump: the request.
        robot_parameters: the numbers of the robot that were used, as plain data.
        report: solver status and times.
        violations: constraint name -> largest violation, recomputed with NumPy.
        tuning: weights and limits that were asked for in place of the robot's.
        schedule: the phases and which feet stand in them; None, of files that have none, becomes
            the schedule `together`.
        solution: of the solver, for plans that start from this one; None of a plan that failed, and
            of one that was read from a file that was written before files held it.
        obstacle: what is jumped over, if anything.

    Velocities and torques of the joints are None where they are not known: in a plan of an old file
    whose robot is not there any more, and in one that failed so badly that its motion has none.
    """

    jump: Jump
    robot_parameters: dict[str, Any]
    report: SolveReport
    violations: dict[str, Violation]
    time: Annotated[Array, Quantity((TIME,), "s", "strictly increasing", Between.LINEAR)]
    phase: Annotated[
        NDArray[np.int64],
        Quantity(
            (TIME,),
            "",
            "phase of the interval that begins there, counted as in the schedule",
            Between.HELD,
            kind=Kind.WHOLE,
            coded_by="phase_names",
        ),
    ]
    com: Annotated[Array, Quantity((TIME, XYZ), "m", "centre of mass", Between.BALLISTIC, "world")]
    com_velocity: Annotated[
        Array,
        Quantity((TIME, XYZ), "m/s", "velocity of the CoM", Between.LINEAR, "world", rate=True),
    ]
    base_quat: Annotated[
        Array,
        Quantity((TIME, WXYZ), "", "attitude of the URDF's root link", Between.TURNING, "world"),
    ]
    base_position: Annotated[
        Array,
        Quantity((TIME, XYZ), "m", "origin of the URDF's root link", Between.FROM_COM, "world"),
    ]
    angular_velocity: Annotated[
        Array,
        Quantity(
            (TIME, XYZ), "rad/s", "angular velocity of the base", Between.LINEAR, "world", rate=True
        ),
    ]
    linear_momentum: Annotated[
        Array,
        Quantity((TIME, XYZ), "kg m/s", "linear momentum", Between.LINEAR, "world", rate=True),
    ]
    angular_momentum: Annotated[
        Array,
        Quantity(
            (TIME, XYZ),
            "kg m2/s",
            "angular momentum about the CoM",
            Between.BALLISTIC,
            "world",
            rate=True,
        ),
    ]
    inertia: Annotated[
        Array,
        Quantity(
            (TIME, TENSOR),
            "kg m2",
            "centroidal inertia, as the model has it",
            Between.IN_BASE,
            "world",
        ),
    ]
    foot_position: Annotated[
        Array,
        Quantity(
            (TIME, LEG, XYZ),
            "m",
            "contact point of a point foot, middle of a sole",
            Between.STANDING,
            "world",
        ),
    ]
    foot_quat: Annotated[
        Array,
        Quantity(
            (TIME, LEG, WXYZ),
            "",
            "attitude of soles, which are level; identity for point feet",
            Between.TURNING,
            "world",
        ),
    ]
    contact_point: Annotated[
        Array,
        Quantity(
            (TIME, CONTACT, XYZ), "m", "contact points, legs x corners", Between.CARRIED, "world"
        ),
    ]
    contact_force: Annotated[
        Array,
        Quantity(
            (TIME, CONTACT, XYZ),
            "N",
            "force at a contact, constant over the interval that begins there",
            Between.HELD,
            "world",
        ),
    ]
    leg_mass: Annotated[Array, Quantity((LEG,), "kg", "mass of a leg, lumped", listed=False)]
    base_mass: Annotated[float, Quantity((), "kg", "mass of the base", listed=False)]
    leg_com: Annotated[
        Array,
        Quantity(
            (TIME, LEG, XYZ),
            "m",
            "where the model puts a leg's point mass",
            Between.FROM_COM,
            "world",
        ),
    ]
    joint_position: Annotated[
        Array,
        Quantity(
            (TIME, JOINT),
            "rad",
            "posture that realises the plan: with base_position and base_quat its forward "
            "kinematics puts every foot on foot_position",
            Between.JOINTS,
        ),
    ]
    joint_names: Annotated[
        tuple[str, ...],
        Quantity((JOINT,), "", "order of the joints", kind=Kind.TEXT, listed=False),
    ]
    foot_in_hip: Annotated[
        Array,
        Quantity(
            (TIME, LEG, HIP),
            "m",
            "foot in the leg's mirrored hip frame as the model sees it, with the yaw (rad) of a "
            "sole",
            Between.LINEAR,
            "hip",
            listed=False,
        ),
    ]
    joint_velocity: Annotated[
        Array | None,
        Quantity(
            (TIME, JOINT), "rad/s", "velocity, zero at both ends", Between.JOINT_RATES, rate=True
        ),
    ] = None
    joint_torque: Annotated[
        Array | None,
        Quantity(
            (TIME, JOINT),
            "Nm",
            "by inverse dynamics of the whole body in the middle of the interval that begins "
            "there (`llsrbm.body.joint_loads`); the last instant's are those of standing",
            Between.HELD,
        ),
    ] = None
    joint_torque_limit: Annotated[
        Array | None,
        Quantity(
            (TIME, JOINT),
            "Nm",
            "the most that the drives can give there, at that speed in the torque's direction",
            Between.HELD,
        ),
    ] = None
    tuning: Tuning = field(default_factory=Tuning)
    solution: Iterate | None = field(default=None, repr=False)
    schedule: Schedule = None  # type: ignore[assignment]
    obstacle: Obstacle | None = None

    def __post_init__(self) -> None:
        if not self.schedule:
            object.__setattr__(self, "schedule", together(self.leg_names))

    @property
    def solved(self) -> bool:
        """Whether every constraint is satisfied."""
        return self.report.status == "solved"

    @property
    def duration(self) -> float:
        """Length of the motion, s."""
        return float(self.time[-1])

    @property
    def sliding_joints(self) -> frozenset[str]:
        """Names of the joints whose position is in metres."""
        return sliding_joints(self.robot_parameters)

    @property
    def leg_names(self) -> tuple[str, ...]:
        """As in the robot file, when the plan says which robot it is of."""
        return leg_names(self.robot_parameters, len(self.leg_mass))

    @cached_property
    def phase_start(self) -> Array:
        """(P + 1,) s: start of each of the schedule's phases, and the end."""
        first = [int(np.argmax(self.phase == p)) for p in range(len(self.schedule))]
        return np.append(self.time[first], self.time[-1])

    @property
    def phase_names(self) -> tuple[str, ...]:
        """(P,) what the numbers of `phase` stand for."""
        return self.schedule.names

    @property
    def contact(
        self,
    ) -> Annotated[
        NDArray[np.bool_],
        Quantity(
            (TIME, LEG),
            "",
            "whether the foot stands over the interval that begins there",
            Between.HELD,
            kind=Kind.WHOLE,
            codes=("in the air", "touches"),
        ),
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

    def save(self, path: str | Path) -> None:
        """Write the native npz file (schema llsrbm.plan/2); see `llsrbm.load`."""
        from llsrbm.files.plan_file import save_plan

        save_plan(self, path)


def leg_names(robot_parameters: dict[str, Any], count: int) -> tuple[str, ...]:
    """As in the robot file, where a trajectory's numbers of the robot hold them."""
    legs = tuple(robot_parameters.get("legs", ()))
    return legs if len(legs) == count else tuple(f"leg{i}" for i in range(count))


def sliding_joints(robot_parameters: dict[str, Any]) -> frozenset[str]:
    """Of a trajectory's robot; where an old file does not say, of the robot of that name."""
    from llsrbm.errors import Error
    from llsrbm.robots import load_robot, names

    if "sliding_joints" in robot_parameters:
        return frozenset(robot_parameters["sliding_joints"])
    name = robot_parameters.get("name")
    if name not in names():  # of the project's own: what a file names as a path is not opened
        return frozenset()
    try:
        return load_robot(name).sliding_joints
    except Error:
        return frozenset()
