"""`llsrbm plan`."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any

import typer

from llsrbm.commands import console, options
from llsrbm.errors import NotConverged
from llsrbm.request.numbers import degrees

if TYPE_CHECKING:
    from llsrbm.motion.plan import Plan
    from llsrbm.motion.solve_report import Refinement


@options.with_jump_options
def plan_command(
    context: typer.Context,
    requested: Mapping[str, Any],
    design: options.DesignOption = None,
    solver: options.Planner = "fatrop",
    weight: options.Weights = None,
    limit: options.Limits = None,
    nearest: Annotated[
        bool, typer.Option("--nearest", help="Take the nearest jump that can be planned.")
    ] = False,
    refine: Annotated[
        bool,
        typer.Option("--refine/--no-refine", help="A second stage on the whole body's dynamics."),
    ] = False,
    out: options.Out = None,
    as_json: options.AsJson = False,
) -> int:
    """Plan one jump from standing to standing.

    A request that is not feasible is refused with its reason and the nearest one that is, and the
    exit status is 1, unless that is taken; what the planner ended with is written all the same.
    """
    del context  # of the options that only count where they are given
    with console.result_stream(as_json=as_json) as stdout:
        import llsrbm
        from llsrbm import certified
        from llsrbm.analysis.summaries import certificate_summary, plan_summary, refusal_summary
        from llsrbm.planning.whole_body.refine import refined

        request = options.requested_design(design, requested)
        tuning = options.requested_tuning(request.tuning, weight, limit)
        status, failure = console.DONE, None
        try:
            plan = llsrbm.plan(
                request.jump,
                solver=solver,
                weights=tuning.weights,
                limits=tuning.limits,
                refine=refine,
                progress=console.show_planning,
            )
        except NotConverged as error:
            failure = error
            plan, status = error.plan, console.FAILED
            if nearest and error.nearest is not None:
                plan, status = error.nearest, console.DONE
                if refine:
                    plan = refined(plan, progress=console.show_planning)
        if out is not None or as_json:
            plan = certified(plan)
        if out is not None:
            (llsrbm.with_feedback(plan) if plan.refined else plan).save(out)
        lines = {} if as_json else _description(plan)
        summary = plan_summary(plan) | (refusal_summary(failure) if failure else {})
        if as_json:
            summary |= certificate_summary(plan)
        console.print_result(summary, lines, stdout, as_json=as_json)
        if failure is not None:
            console.print_error(str(failure))
    return status


def _description(plan: Plan) -> dict[str, str]:
    from llsrbm.analysis.summaries import peak_yaw_rate, worst_violation
    from llsrbm.mechanics import final_yaw

    report = plan.report
    iterations = f"{report.iterations} iterations {report.guess}".rstrip()
    compiling = ", still being compiled: twice as fast once it is" if report.compiling else ""
    turn = final_yaw(plan.time, plan.base_quat, plan.angular_velocity[:, 2])
    return {
        "request": options.in_words(plan.jump),
        "solver": f"{report.status} by {report.solver} in {iterations}, "
        f"{1e3 * report.solve_time_s:.0f} ms ({1e3 * report.total_time_s:.0f} ms from request to "
        f"plan, {report.build_time_s:.2f} s to build the solver{compiling})",
        **({} if plan.refinement is None else {"whole body": _refinement(plan.refinement)}),
        "duration": f"{plan.duration:.2f} s: {_phases(plan)} s",
        "turn": f"{degrees(turn)}, peak yaw rate {peak_yaw_rate(plan):.2f} rad/s",
        "model": _model(plan),
        # The instants of one that failed may run backwards.
        "joints": _joints(plan) if plan.solved else "-",
        "violation": worst_violation(plan),
    }


def _refinement(of: Refinement) -> str:
    effort = f"{of.iterations} iterations, {1e3 * of.solve_time_s:.0f} ms"
    if of.status != "solved":
        return f"not refined: the second stage did not converge ({effort}); this is the first's"
    building = f", {of.build_time_s:.1f} s to build the solver" if of.build_time_s > 0.1 else ""
    compiling = ", still being compiled" if of.compiling else ""
    return f"refined in {effort}{building}{compiling}"


def _model(plan: Plan) -> str:
    """The model, and by how much the whole body turns beyond what it promises."""
    from llsrbm.analysis.model_turn import model_turn

    error = model_turn(plan)
    if error is None:
        return plan.jump.model
    return (
        f"{plan.jump.model}; the whole body turns {degrees(error.takeoff, signed=True)} further "
        f"until lift-off and {degrees(error.flight, signed=True)} in flight"
    )


def _phases(plan: Plan) -> str:
    """Name and duration, s, of each phase, with its feet where only some of them stand."""
    parts = []
    for phase, (start, end) in zip(plan.schedule, pairwise(plan.phase_start), strict=True):
        some = 0 < len(phase.feet) < len(plan.schedule.legs)
        feet = f" on {' and '.join(phase.feet)}" if some else ""
        parts.append(f"{phase.name}{feet} {end - start:.2f}")
    return ", ".join(parts)


def _joints(plan: Plan) -> str:
    from llsrbm.analysis.joint_margins import joint_margins
    from llsrbm.analysis.summaries import planned_peak_load
    from llsrbm.robots import load_robot

    robot = load_robot(plan.jump.robot)
    load = planned_peak_load(plan)
    margins = joint_margins(plan, robot).worst()
    if load is None:
        return margins
    return f"{load.joint} is most loaded, {load.in_words(robot.sliding_joints)}; {margins}"
