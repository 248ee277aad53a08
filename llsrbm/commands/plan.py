"""`llsrbm plan`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import typer

from llsrbm.commands import console, options
from llsrbm.errors import NotConverged

if TYPE_CHECKING:
    from llsrbm.motion.plan import Plan


@options.with_jump_options
def plan_command(
    context: typer.Context,
    requested: Mapping[str, Any],
    design: options.DesignOption = None,
    solver: options.Planner = "fatrop",
    weight: options.Weights = None,
    limit: options.Limits = None,
    out: options.Out = None,
    as_json: options.AsJson = False,
) -> int:
    """Plan one jump from standing to standing.

    A plan that does not converge is written all the same, and the exit status is 1.
    """
    del context  # of the options that only count where they are given
    with console.result_stream(as_json=as_json) as stdout:
        import llsrbm
        from llsrbm.analysis.summaries import plan_summary

        request = options.requested_design(design, requested)
        tuning = options.requested_tuning(request.tuning, weight, limit)
        status, failure = console.DONE, None
        try:
            plan = llsrbm.plan(
                request.jump,
                solver=solver,
                weights=tuning.weights,
                limits=tuning.limits,
                progress=console.show_planning,
            )
        except NotConverged as error:
            plan, status, failure = error.plan, console.FAILED, error
        if out is not None:
            plan.save(out)
        lines = {} if as_json else _description(plan)
        console.print_result(plan_summary(plan), lines, stdout, as_json=as_json)
        if failure is not None:
            console.print_error(str(failure))
    return status


def _description(plan: Plan) -> dict[str, str]:
    from llsrbm.analysis.summaries import peak_yaw_rate, worst_violation
    from llsrbm.mechanics import final_yaw

    report = plan.report
    iterations = f"{report.iterations} iterations {report.guess}".rstrip()
    turn = final_yaw(plan.time, plan.base_quat, plan.angular_velocity[:, 2])
    return {
        "request": options.in_words(plan.jump),
        "solver": f"{report.status} by {report.solver} in {iterations}, "
        f"{1e3 * report.solve_time_s:.0f} ms ({1e3 * report.total_time_s:.0f} ms from request to "
        f"plan, {report.build_time_s:.2f} s to build the solver)",
        "duration": f"{plan.duration:.2f} s: {_phases(plan)} s",
        "turn": f"{math.degrees(turn):.1f} deg, peak yaw rate {peak_yaw_rate(plan):.2f} rad/s",
        # The instants of one that failed may run backwards.
        "joints": _joints(plan) if plan.solved else "-",
        "violation": worst_violation(plan),
    }


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
