"""Drafts: centroidal plans of the first stage, of the robot without what it carries."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from numbers import Integral, Real

from llsrbm.errors import NotConverged
from llsrbm.motion.plan import Plan
from llsrbm.planning.answer.planner import planner_of
from llsrbm.planning.solve.watch import Progress
from llsrbm.request.jump import Jump
from llsrbm.request.messages import check_functions, check_kind
from llsrbm.robots.payload import with_payload
from llsrbm.robots.robot import Robot


@dataclass(frozen=True)
class Drafting:
    """How drafts are made: those of `llsrbm.plan`'s arguments that its first stage takes.

    Raises `InputError`: one is of another type.
    """

    solver: str
    intervals: int
    weights: Mapping[str, float] | None
    limits: Mapping[str, float] | None
    near: Plan | None
    patient: bool
    explains: bool
    hurried: bool
    cancelled: Callable[[], bool] | None
    progress: Progress | None

    def __post_init__(self) -> None:
        check_kind("intervals", self.intervals, Integral, "a whole number")
        check_kind("near", self.near, Plan | None, "a Plan or None")
        check_functions(cancelled=self.cancelled, progress=self.progress)
        for what, given in (("weights", self.weights), ("limits", self.limits)):
            check_kind(what, given, Mapping | None, "names with numbers")
            for name, value in (given or {}).items():
                check_kind(f"{what}: {name}", value, Real, "a number")

    def draft(self, jump: Jump, robot: Robot) -> Plan:
        """The draft of a jump of its type, whose payload it names and has not.

        Raises `NotConverged` with drafts of its own for what was reached and for the nearest jump.
        """
        bare = replace(jump, payload=())  # solvers have the robot's own mass
        start = time.perf_counter()
        planner = planner_of(
            bare, self.solver, self.intervals, cancelled=self.cancelled, limits=self.limits
        )
        built = time.perf_counter() - start
        try:
            found = planner.plan(
                bare,
                weights=self.weights,
                limits=self.limits,
                near=self.near and _as_start(self.near, robot),
                patient=self.patient,
                explains=self.explains,
                hurried=self.hurried,
                cancelled=self.cancelled,
                progress=self.progress,
            )
        except NotConverged as error:
            nearest = error.nearest and _carrying(error.nearest, jump)
            raise error.with_plans(_carrying(error.plan, jump), nearest) from None
        found = replace(found, report=replace(found.report, build_time_s=built))
        return _carrying(found, jump)


def _carrying(plan: Plan, jump: Jump) -> Plan:
    return replace(plan, jump=replace(plan.jump, payload=jump.payload))


def _as_start(near: Plan, robot: Robot) -> Plan | None:
    """A plan as that of the robot without its payload; none if it was made without a draft."""
    if near.report.attempts == 0:
        return None
    if not near.jump.payload:
        return near
    carried = with_payload(robot, near.jump.payload).parameters()
    numbers = robot.parameters() if near.robot_parameters == carried else near.robot_parameters
    return replace(near, jump=replace(near.jump, payload=()), robot_parameters=numbers)
