"""`llsrbm simulate`."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from llsrbm.commands import console, options
from llsrbm.errors import InputError, NotConverged

if TYPE_CHECKING:
    from llsrbm.motion.plan import Plan
    from llsrbm.motion.rollout import Rollout
    from llsrbm.request.jump import Jump
    from llsrbm.request.scenario import Scenario
    from llsrbm.request.tuning import Tuning


@options.with_scenario_options
@options.with_jump_options
def simulate_command(
    context: typer.Context,
    conditions: Mapping[str, Any],
    requested: Mapping[str, Any],
    file: Annotated[
        Path | None, typer.Argument(metavar="PLAN.npz", help="A plan; without: plan first.")
    ] = None,
    design: options.DesignOption = None,
    solver: options.Planner = "fatrop",
    weight: options.Weights = None,
    limit: options.Limits = None,
    draft: options.Draft = False,
    out: options.Out = None,
    as_json: options.AsJson = False,
) -> int:
    """Let the whole robot follow a plan, in MuJoCo.

    The plan is a file, or made first from the same options as those of `llsrbm plan`, and
    followed in the scenario of the design, if there is one. The exit status is 1 if it does not
    converge, or if the robot falls.
    """
    with console.result_stream(as_json=as_json) as stdout:
        import llsrbm
        from llsrbm.analysis.diagnosis import fall_in_words
        from llsrbm.analysis.summaries import plan_summary, refusal_summary, rollout_summary
        from llsrbm.certificate import certified

        given = [name for name in options.PLANNING if options.is_given(context, name)]
        if file is not None and given:
            raise InputError(
                f"{options.option(given[0])}: is for planning, but {file} is planned already; "
                "expected a plan's file or options of a jump, not both"
            )
        request = options.requested_design(design, requested)
        tuning = options.requested_tuning(request.tuning, weight, limit)
        scenario = request.scenario.but(**conditions)
        if file is not None:
            plan = options.read_plan(file)
        else:
            try:
                plan = _planned(request.jump, solver, tuning, scenario, draft=draft)
            except NotConverged as error:
                if as_json:
                    summary = plan_summary(error.plan) | refusal_summary(error)
                    console.print_result(summary, {}, stdout, as_json=True)
                raise  # one line, exit status 1
        if scenario.replan:
            console.show_planning(
                "loading the solvers that plan anew: some minutes the first time, "
                "seconds after that"
            )
        rollout = llsrbm.simulate(plan, scenario, progress=console.show_simulation)
        if out is not None:
            certified(rollout).save(out)
        lines = {} if as_json else _description(rollout)
        console.print_result(rollout_summary(rollout), lines, stdout, as_json=as_json)
        if rollout.landed:
            return console.DONE
        console.print_error(f"the robot fell {fall_in_words(rollout)}")
    return console.FAILED


def _planned(jump: Jump, solver: str, tuning: Tuning, scenario: Scenario, *, draft: bool) -> Plan:
    """Plan a jump that will be followed in a scenario."""
    import llsrbm
    from llsrbm.analysis.drafts import draft_reason
    from llsrbm.robots import load_robot
    from llsrbm.simulation.checks import check_scenario

    # What is wrong shall not come out after seconds of planning.
    check_scenario(scenario, load_robot(jump.robot))
    plan = llsrbm.plan(
        jump,
        solver=solver,
        weights=tuning.weights,
        limits=tuning.limits,
        draft=draft,
        progress=console.show_planning,
    )
    if not plan.certified and not draft:
        console.print_remarks([f"the plan is a draft: {draft_reason(plan)}"])
    return plan


def _description(rollout: Rollout) -> dict[str, str]:
    from llsrbm.analysis.wording import outcome_words, rollout_rows
    from llsrbm.look.shown_motion import surroundings_of
    from llsrbm.robots import load_robot

    boxes = surroundings_of(rollout, load_robot(rollout.jump.robot)).in_mid_flight
    return {
        "Request": options.in_words(rollout.jump),
        "Outcome": outcome_words(rollout),
        **({"Box": boxes} if boxes else {}),
        **dict(rollout_rows(rollout)),
    }
