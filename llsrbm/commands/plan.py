"""`llsrbm plan`."""

from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING

import typer

from llsrbm.commands import console, options
from llsrbm.commands.design import DesignOption, requested_design
from llsrbm.errors import NotConverged

if TYPE_CHECKING:
    from llsrbm.motion.plan import Plan


def plan_command(
    context: typer.Context,
    design: DesignOption = None,
    robot: options.Robot = "anymal",
    model: options.Model = "llsrbm-plus",
    twist: options.Twist = 0.0,
    forward: options.Forward = 0.0,
    lateral: options.Lateral = 0.0,
    height: options.Height = 0.0,
    solver: options.Planner = "fatrop",
    weight: options.Weights = None,
    limit: options.Limits = None,
    out: options.Out = None,
    as_json: options.AsJson = False,
) -> int:
    """Plan one jump from standing to standing.

    A plan that does not converge is written all the same, and the exit status is 1.
    """
    with console.result_stream(as_json=as_json) as stdout:
        import llsrbm
        from llsrbm.analysis.summary import plan_summary

        jump = options.requested_jump(robot, model, twist, forward, lateral, height)
        request = requested_design(context, design, jump)
        tuning = options.requested_tuning(request.tuning, weight, limit)
        status, failure = console.DONE, None
        try:
            plan = llsrbm.plan(
                request.jump,
                solver=solver,
                weights=tuning.weights,
                limits=tuning.limits,
                progress=console.tell,
            )
        except NotConverged as error:
            plan, status, failure = error.plan, console.FAILED, error
        if out is not None:
            plan.save(out)
        if as_json:
            print(json.dumps(plan_summary(plan), allow_nan=False), file=stdout)
        else:
            console.print_lines(_description(plan), stdout)
        if failure is not None:
            console.complain(str(failure))
    return status


def _description(plan: Plan) -> dict[str, str]:
    """A plan in a few lines for a person: degrees, milliseconds."""
    from llsrbm.analysis.summary import peak_yaw_rate, worst_violation
    from llsrbm.motion.rotation import yaw

    report = plan.report
    takeoff, flight, landing = plan.phase_start[1:] - plan.phase_start[:-1]
    return {
        "request": options.described(plan.jump),
        "solver": f"{report.status} by {report.solver} in {report.iterations} iterations, "
        f"{1e3 * report.solve_time_s:.0f} ms ({1e3 * report.total_time_s:.0f} ms from request to "
        f"plan, {report.build_time_s:.2f} s to build the solver)",
        "duration": f"{plan.duration:.2f} s: take-off {takeoff:.2f}, flight {flight:.2f}, "
        f"landing {landing:.2f} s",
        "turn": f"{math.degrees(yaw(plan.base_quat)[-1]):.1f} deg, "
        f"peak yaw rate {peak_yaw_rate(plan):.2f} rad/s",
        # The instants of one that failed may run backwards.
        "joints": _joints(plan) if plan.solved else "-",
        "violation": worst_violation(plan),
    }


def _joints(plan: Plan) -> str:
    """The joint that is loaded most, the fastest, and the one that comes nearest to a stop."""
    from llsrbm.analysis.joint_margins import joint_margins
    from llsrbm.analysis.peak_loads import planned_peak_load
    from llsrbm.robots import load_robot

    robot = load_robot(plan.jump.robot)
    load = planned_peak_load(plan)
    margins = joint_margins(plan, robot).worst()
    if load is None:
        return margins
    return f"{load.joint} is most loaded, {load.in_words(robot.sliding_joints)}; {margins}"
