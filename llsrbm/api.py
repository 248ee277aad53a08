"""The functions that scripts, the command line and the page call."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from llsrbm.certified_nearest import all_or_less, gives_up, less_alone, whole_or_nearest
from llsrbm.certified_plan import CertifiedPlanner
from llsrbm.drafting import Drafting
from llsrbm.errors import InputError, NotConverged
from llsrbm.largest_jump import Largest, largest_jump
from llsrbm.motion.plan import Plan
from llsrbm.motion.robot import robot_of
from llsrbm.motion.rollout import Rollout
from llsrbm.ocp.solvers import names as solver_names
from llsrbm.planning.problem.placement import make_task
from llsrbm.planning.problem.task import Task
from llsrbm.planning.solve.jump_layout import INTERVALS
from llsrbm.planning.solve.watch import PlanningProgress
from llsrbm.request.jump import Jump, not_feasible
from llsrbm.request.jump_types import of_its_type
from llsrbm.request.messages import check_functions
from llsrbm.request.scenario import Scenario
from llsrbm.robots import load_robot
from llsrbm.robots.payload import with_payload
from llsrbm.robots.robot import Robot


def plan(
    jump: Jump,
    *,
    solver: str = solver_names()[0],
    intervals: int = INTERVALS,
    weights: Mapping[str, float] | None = None,
    limits: Mapping[str, float] | None = None,
    near: Plan | None = None,
    guesses: bool = True,
    patient: bool = True,
    explains: bool = True,
    hurried: bool = False,
    draft: bool = False,
    cancelled: Callable[[], bool] | None = None,
    progress: Callable[[PlanningProgress], None] | None = None,
) -> Plan:
    """Plan a jump; the solvers of each robot and model are built once and kept.

    The plan is the whole body's, with its certificate; `Plan.certified`: it holds. It begins from
    jumps nearby that were solved before, if the robot has a table of some and its certificate holds
    so; else from a draft, the centroidal plan of the first stage. Where no certificate holds, nor
    one of less of the request, it is what was found, at least the draft: `Plan.certified`,
    `Plan.refined` and `refinement` say so.

    Args:
        jump: the request.
        solver: "fatrop" or "ipopt".
        intervals: N, shared evenly by the three phases.
        weights: cost name -> weight, in place of the defaults (`llsrbm.planning.problem.costs`).
        limits: limit name -> value, in place of the robot's (`llsrbm.planning.problem.limits`).
        near: a plan of a nearby request to the same robot and model to start drafts from, for
            speed; one that had no draft is left.
        guesses: begin from jumps of the robot's table (`llsrbm robot learn`), where it has one.
        patient: look for the nearest jump that can be planned where the request cannot at once,
            now and then the request itself. Otherwise the first attempts are all.
        explains: whether what the request would need is found out, by further solves.
        hurried: for a slider that moves: the first nearer jump, unexplained, in half the time.
        draft: the centroidal plan of the first stage alone, in a fraction of the time. Its drives
            were looked at in knots only; it carries no certificate, and no payload.
        cancelled: asked all the while, also while solvers are built; True: `Cancelled` in 0.1 s.
        progress: told what is being tried, and iteration and residual at most every 0.1 s.

    Raises:
        InputError: an argument of another type, an unknown name, a request that no robot here comes
            near to, a limit out of range, or a plan to start from that is of another robot, model
            or version, or that failed.
        RobotFileError: the robot file is wrong.
        NotConverged: no attempt satisfied every constraint. With patience and the default solver
            its `nearest` is the plan of the nearest jump, and its `reason` what stops the rest.
    """
    jump = of_its_type(jump)
    robot = load_robot(jump.robot)
    drafting = Drafting(
        solver, intervals, weights, limits, near, patient, explains, hurried, cancelled, progress
    )
    # A request that cannot be builds no solver.
    task = make_task(jump, with_payload(robot, jump.payload), weights, limits)
    if draft:
        return drafting.draft(jump, robot)
    return _whole_body_plan(task, robot, drafting, guesses)


def _whole_body_plan(task: Task, robot: Robot, drafting: Drafting, guesses: bool) -> Plan:
    """From a table's jumps where there are some and the certificate holds so; else from a draft."""
    planner = CertifiedPlanner(
        guesses=guesses and drafting.solver == solver_names()[0],
        cancelled=drafting.cancelled,
        progress=drafting.progress,
    )
    near = all_or_less(planner, task, drafting.intervals, less=drafting.patient)
    if near is not None and near.plan.jump == task.jump:
        return near.plan
    if near is not None:  # what stops the rest is known
        if gives_up(near, task):
            raise less_alone(near, task.jump)
        drafting = replace(drafting, patient=False, explains=False)
    try:
        draft = drafting.draft(task.jump, robot)
    except NotConverged as error:
        if near is not None:
            raise less_alone(near, task.jump) from None
        if error.nearest is None:
            raise
        less = whole_or_nearest(planner, error.nearest, task.jump, None)
        message = not_feasible(error.reason, task.jump, less.jump)
        raise NotConverged(message, error.plan, error.stops, less, error.reason) from None
    return whole_or_nearest(planner, draft, task.jump, near)


def largest(
    jump: Jump,
    component: str,
    *,
    weights: Mapping[str, float] | None = None,
    limits: Mapping[str, float] | None = None,
    cancelled: Callable[[], bool] | None = None,
    progress: Callable[[PlanningProgress], None] | None = None,
) -> Largest:
    """The largest jump in one direction that is planned, everything else as requested.

    What stops it is a limit: of the drives, of joints, of friction, of time, or of links that come
    near to each other. Only jumps of the whole
    body whose certificate holds count. It is what a search by steps of up to 5 cm or 10 degrees
    comes to, each plan begun from the one before: nothing proves that no larger jump exists.

    Args:
        jump: the request; a component that it asks for in that direction is the least.
        component: "twist" or "lateral" (to the left), "twist-right", "lateral-right", "forward",
            "backward", "up" or "down".
        weights, limits, cancelled, progress: as of `plan`.

    Raises:
        InputError: as of `plan`, a component that is none, a route, and a jump that turns over.
        NotConverged: the request has no plan whose certificate holds, from which to begin.
    """
    plain = Drafting(
        solver=solver_names()[0],
        intervals=INTERVALS,
        weights=weights,
        limits=limits,
        near=None,
        patient=True,
        explains=True,
        hurried=False,
        cancelled=cancelled,
        progress=progress,
    )
    return largest_jump(of_its_type(jump), component, plain)


def simulate(
    plan: Plan,
    scenario: Scenario | None = None,
    *,
    cancelled: Callable[[], bool] | None = None,
    progress: Callable[[float], None] | None = None,
    so_far: Callable[[NDArray[np.float64], NDArray[np.float64]], None] | None = None,
    **fields: Any,
) -> Rollout:
    """Let the whole robot follow a plan in MuJoCo, until a second after the plan's end.

    The same arguments give the same rollout, wall times aside. A robot that falls is a result, not
    an error: see `Rollout.outcome`.

    Args:
        plan: a plan that converged.
        scenario: board, disturbance, pushes, whether to plan anew, and names of detector, landing
            strategy, QP solver and estimator; None: no board, nothing disturbed.
        cancelled: polled; True ends with `Cancelled`; progress: called with the share done.
        so_far: called five times a second with the motion until now: instants (K,) s, 60 to a
            simulated second, and states (K, 7 + J), MuJoCo's, joints as in `Robot.joint_names`.
        fields: those of a `Scenario` in place of one: `simulate(plan, board=0.025, seed=3)`.

    Raises:
        InputError: no plan, one that did not converge or is of another robot; an unknown name; a
            landing strategy that follows forces on a robot without a force phase; a number out of
            range, a board that does not fit under the robot and a push after the end among them.
    """
    # MuJoCo takes its time to import: not for those who only plan.
    from llsrbm.simulation import checks
    from llsrbm.simulation.simulate import simulate as run

    checks.check_plan(plan)
    check_functions(cancelled=cancelled, progress=progress, so_far=so_far)
    scenario = _scenario(scenario, fields)
    robot = robot_of(plan)
    checks.check_robot(plan, robot)
    checks.check_scenario(scenario, robot)
    return run(plan, robot, scenario, cancelled=cancelled, progress=progress, so_far=so_far)


def _scenario(scenario: Any, fields: Mapping[str, Any]) -> Scenario:
    if scenario is None:
        return Scenario().but(**fields)
    if not isinstance(scenario, Scenario):
        raise InputError(f"expected a Scenario, got a {type(scenario).__name__}")
    if fields:
        raise InputError(
            f"expected a Scenario or its fields, got {', '.join(fields)} beside a Scenario; "
            "to change one: scenario.but(...)"
        )
    return scenario
