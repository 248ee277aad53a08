"""`llsrbm simulate`."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from llsrbm.commands import console, options
from llsrbm.errors import InputError
from llsrbm.request.numbers import degrees, percent, short
from llsrbm.request.scenario import Push, Scenario

if TYPE_CHECKING:
    from llsrbm.motion.plan import Plan
    from llsrbm.motion.rollout import Rollout


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
        from llsrbm.analysis.summaries import rollout_summary
        from llsrbm.certificate import certified
        from llsrbm.robots import load_robot
        from llsrbm.simulation.checks import check_scenario

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
            plan = _read_plan(file)
        else:
            # What is wrong shall not come out after seconds of planning.
            check_scenario(scenario, load_robot(request.jump.robot))
            plan = llsrbm.plan(
                request.jump,
                solver=solver,
                weights=tuning.weights,
                limits=tuning.limits,
                progress=console.show_planning,
            )
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
        console.print_error(f"the robot {_fall(rollout)}")
    return console.FAILED


def _read_plan(file: Path) -> Plan:
    import llsrbm

    trajectory = llsrbm.load(file)
    if not isinstance(trajectory, llsrbm.Plan):
        raise InputError(f"{file}: holds a {type(trajectory).__name__.lower()}; expected a plan")
    return trajectory


def _fall(rollout: Rollout) -> str:
    from llsrbm.analysis.diagnosis import fall_in_words

    return f"fell {fall_in_words(rollout)}"


def _description(rollout: Rollout) -> dict[str, str]:
    from llsrbm.formats.shown import surroundings_of
    from llsrbm.robots import load_robot

    outcome, scenario = rollout.outcome, rollout.scenario
    lines = {"request": options.in_words(rollout.jump)}
    board = ""
    if scenario.board:
        half = "half " if scenario.half_board else ""
        board = f"{half}board {1e3 * scenario.board:.0f} mm, "
    noise = "undisturbed"
    if scenario.seed is not None:
        noise = f"disturbed by seed {scenario.seed}, noise {scenario.noise:g}"
    trunk = ""
    if scenario.trunk_mass is not None:
        trunk = f", trunk {percent(scenario.trunk_mass, 1, signed=True)} against its believed mass"
    lines["scenario"] = f"{board}{noise}{trunk}"
    if scenario.estimator != Scenario.estimator:
        lines["scenario"] += f", estimator {scenario.estimator}"
    boxes = surroundings_of(rollout, load_robot(rollout.jump.robot)).in_mid_flight
    if boxes:
        lines["box"] = boxes
    for number, push in enumerate(rollout.pushes, 1):
        lines[f"push {number}" if len(rollout.pushes) > 1 else "push"] = _push(push)
    lines["outcome"] = _landed(rollout) if rollout.landed else _fall(rollout)
    if outcome.replan_median_s is not None and outcome.replan_p95_s is not None:
        solved = sum(replan.solved for replan in rollout.replans)
        lines["replans"] = (
            f"{outcome.replans}, {solved} of them solved, {1e3 * outcome.replan_median_s:.1f} ms "
            f"(p95 {1e3 * outcome.replan_p95_s:.1f} ms)"
        )
    lines["touchdown"] = (
        f"planned {outcome.touchdown_planned_s:.3f} s, true {_seconds(outcome.touchdown_true_s)}, "
        f"detected {_seconds(outcome.touchdown_detected_s)}, {outcome.false_touchdowns} false"
    )
    errors = (
        ("at lift-off", outcome.yaw_error_at_lift_off),
        ("gained in flight", outcome.yaw_error_in_flight),
        ("at touchdown", outcome.yaw_error_at_touchdown),
        ("at the end", outcome.final_yaw_error),
    )
    lines["yaw error"] = ", ".join(
        f"{degrees(error, signed=True)} {when}" for when, error in errors if error is not None
    )
    lines["place"] = (
        f"CoM {1e3 * outcome.final_position_error:.0f} mm off, feet {1e3 * outcome.foot_error:.0f} "
        f"mm, tilt {degrees(outcome.final_tilt)}"
    )
    lines["drives"] = (
        f"torque at most {100 * outcome.peak_torque_ratio:.0f} % of the limit, speed "
        f"{100 * outcome.peak_speed_ratio:.0f} %, saturated in "
        f"{100 * outcome.saturated_fraction:.1f} % of the ticks"
    )
    lines["controller"] = f"landing strategy {outcome.landing_strategy or scenario.landing}"
    if scenario.landing == "auto" and outcome.landing_strategy == "tracking":
        lines["controller"] += " (the robot file has no force phase)"
    lines["controller"] += (
        f", the QP was unsolved in {outcome.unsolved_ticks} of {len(rollout.time)} ticks"
        if outcome.unsolved_ticks
        else ", the QP was solved in every tick"
    )
    lines["speed"] = (
        f"{outcome.real_time_factor:.1f} x real time, a tick {1e3 * outcome.tick_median_s:.2f} ms "
        f"(p99 {1e3 * outcome.tick_p99_s:.2f} ms) at {outcome.control_rate_hz:.0f} Hz"
    )
    return lines


def _landed(rollout: Rollout) -> str:
    if rollout.outcome.strict:
        return "landed, by the strict measure too"
    moved = rollout.outcome.recovered and (rollout.pushes or rollout.replans)
    place = ", but for the feet's place it would" if moved else ""
    touched = f": {rollout.outcome.touched}" if rollout.outcome.touched else ""
    return f"landed, by the strict measure not{place}{touched}"


def _push(push: Push) -> str:
    impulse = ", ".join(short(value, 3) for value in push.impulse)
    moment = ", ".join(short(value, 3) for value in push.moment)
    turning = f", {moment} N m s" if any(push.moment) else ""
    return f"at {push.time:.3f} s: {impulse} N s{turning}"


def _seconds(value: float | None) -> str:
    return "never" if value is None else f"{value:.3f} s"
