"""`llsrbm plan`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any

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
    nearest: Annotated[
        bool, typer.Option("--nearest", help="Take the nearest jump that can be planned.")
    ] = False,
    draft: options.Draft = False,
    out: options.Out = None,
    as_json: options.AsJson = False,
) -> int:
    """Plan one jump from standing to standing, checked on the whole body.

    A request that is not feasible is refused with its reason and the nearest one that is, and the
    exit status is 1, unless that is taken; what the planner ended with is written all the same.
    """
    del context  # of the options that only count where they are given
    with console.result_stream(as_json=as_json) as stdout:
        import llsrbm
        from llsrbm import certified
        from llsrbm.analysis.summaries import certificate_summary, plan_summary, refusal_summary

        request = options.requested_design(design, requested)
        tuning = options.requested_tuning(request.tuning, weight, limit)
        status, failure = console.DONE, None
        try:
            plan = llsrbm.plan(
                request.jump,
                solver=solver,
                weights=tuning.weights,
                limits=tuning.limits,
                draft=draft,
                progress=console.show_planning,
            )
        except NotConverged as error:
            failure = error
            plan, status = error.plan, console.FAILED
            if nearest and error.nearest is not None:
                plan, status = error.nearest, console.DONE
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
    from llsrbm.analysis.joint_margins import joint_margins
    from llsrbm.analysis.wording import plan_rows
    from llsrbm.motion.robot import robot_of

    rows = {"Request": options.in_words(plan.jump), **dict(plan_rows(plan))}
    if plan.solved:  # the instants of one that failed may run backwards
        rows["Joints"] = joint_margins(plan, robot_of(plan)).worst()
    return rows
