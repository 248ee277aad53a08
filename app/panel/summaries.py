"""Plans and rollouts in words and numbers for the panel."""

from __future__ import annotations

import math
from collections.abc import Sequence
from html import escape

import numpy as np

from app.panel.html import SMALL, table
from app.panel.status import SeedResult, Status, Verdict
from llsrbm.analysis.diagnosis import diagnose, fall_in_words
from llsrbm.analysis.figures import figures_of_plan
from llsrbm.analysis.model_turn import model_turn
from llsrbm.analysis.summaries import planned_peak_load
from llsrbm.motion.outcome import Outcome
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.motion.solve_report import Violation
from llsrbm.request.jump import Jump, changes
from llsrbm.request.numbers import decimal, degrees, percent, power
from llsrbm.robots import load_robot

_EVENTS_OF_A_FALL = 4  # events; what follows them is the fall itself


def plan_status(
    plan: Plan, remark: str = "", wanted: Jump | None = None, reason: str = ""
) -> Status:
    """That a plan is there, after a remark; or the nearest to what was asked for, and why."""
    if wanted is not None:
        nearest = changes(wanted, plan.jump) or "all but the same as asked for"
        return Status(Verdict.NEAREST, remark, points=(_sentence(nearest), _sentence(reason)))
    values = figures_of_plan(plan)
    shown = [("Apex", f"{decimal(100 * values.apex, signed=True)} cm")]
    if values.flight_time_s is not None:
        shown.insert(0, ("Flight", f"{decimal(values.flight_time_s, 2)} s"))
    if values.planned_torque_ratio is not None:
        shown.append(("Peak torque", percent(values.planned_torque_ratio)))
    parts = [remark] if remark else []
    if plan.refined:
        parts.append("whole body")
    elif plan.refinement is not None:
        parts.append("not refined: the whole body's plan was not found")
    if plan.report.compiling:
        parts.append("solver still being compiled")
    return Status(Verdict.FEASIBLE, ", ".join(parts), figures=tuple(shown))


def refused_status(reason: str, remark: str = "") -> Status:
    """That there is no plan, and none near it."""
    points = _sentence(reason), "No jump near it is known."
    return Status(Verdict.INFEASIBLE, remark, points=points)


def progress_line(text: str, iteration: int | None, residual: float | None) -> str:
    """The status line after "Planning" while the solver works."""
    parts = [text]
    if iteration is not None:
        parts.append(f"iteration {iteration}")
    if residual is not None:
        parts.append(f"residual {power(residual)}")
    return f"({', '.join(parts)}) ..."


def simulated_status(rollout: Rollout, remark: str = "") -> Status:
    """Whether the robot landed, and how well, after a remark; or what went wrong."""
    outcome = rollout.outcome
    if not rollout.landed:
        words = f"{fall_in_words(rollout)}."
        return Status(Verdict.FELL, f"{remark}: {words}" if remark else words)
    parts = [remark] if remark else []
    if rollout.replans:
        parts.append(f"{_followed(rollout)} new plans followed")
    if outcome.unsolved_ticks:
        ticks = _counted(outcome.unsolved_ticks, "tick")
        parts.append(f"the controller's QP was unsolved in {ticks}")
    if outcome.touched:
        parts.append(outcome.touched)
    limit = "" if outcome.strict else "not strict"
    if rollout.pushes and outcome.recovered and not outcome.strict:
        limit = "recovered from the push"
    yaw, foot = outcome.yaw_error_at_touchdown, outcome.foot_error
    shown = (
        ("Yaw error", degrees(outcome.final_yaw_error if yaw is None else yaw, signed=True)),
        ("Tilt", degrees(outcome.final_tilt)),
        ("Foot error", _millimetres(foot)),
    )
    return Status(Verdict.LANDED, ", ".join(parts), limit=limit, figures=shown)


def _followed(rollout: Rollout) -> str:
    replans = rollout.replans
    return f"{sum(math.isfinite(replan.applied) for replan in replans)} of {len(replans)}"


def seeds_line(results: Sequence[SeedResult]) -> str:
    """How many seeds landed."""
    landed = sum(result.landed for result in results)
    return f"{landed} of {len(results)} seeds landed"


def seeds_share(results: Sequence[SeedResult]) -> str:
    """In how many seeds the robot landed, or fell if it did in any: what follows that word."""
    fell = sum(not result.landed for result in results)
    return f"{fell or len(results)} of {len(results)} seeds"


def seeds_table(results: Sequence[SeedResult], worst_seed: int | None = None) -> str:
    """How each seed ended, as HTML; "" for none."""
    if not results:
        return ""
    cells = "".join(_seed_cell(result, worst=result.seed == worst_seed) for result in results)
    marked = next((result for result in results if result.seed == worst_seed), None)
    line = "" if marked is None else f"Worst, seed {marked.seed}: {marked.line}"
    return (
        f'<div style="{SMALL}"><b>{seeds_line(results)}</b>'
        f'<ul class="llsrbm-seeds" aria-label="Results by seed">{cells}</ul>{escape(line)}</div>'
    )


def _seed_cell(result: SeedResult, *, worst: bool) -> str:
    state = "landed" if result.landed else "fell"
    sign = "✓" if result.landed else "✗"
    return (
        f'<li class="{state}{" worst" if worst else ""}" title="{escape(result.line)}" '
        f'aria-label="Seed {result.seed}: {state}">{result.seed} {sign}</li>'
    )


def worst(violations: dict[str, Violation]) -> str:
    """The largest violation in words."""
    if not violations:
        return "none"
    name, violation = max(violations.items(), key=lambda item: item[1].amount)
    if violation.amount == 0:
        return "0"
    return f"{_amount(violation)} ({_spoken(name)})"


def _amount(violation: Violation) -> str:
    return f"{power(violation.amount)} {violation.unit.replace('m2', 'm²')}"


def _sentence(text: str) -> str:
    return f"{text[:1].upper()}{text[1:].removesuffix('.')}."


def _spoken(name: str) -> str:
    return name.replace("_", " ")


def plan_figures(plan: Plan) -> str:
    """The plan's numbers."""
    report, values = plan.report, figures_of_plan(plan)
    load = planned_peak_load(plan)
    solver = report.solver
    if report.compiling:
        solver += ", still being compiled: twice as fast once it is"
    sliding = load_robot(plan.jump.robot).sliding_joints
    standing = plan.robot_parameters["inertia"][2][2]
    return table(
        [
            ("Duration", f"{decimal(plan.duration, 2)} s = {_phases(plan)}"),
            ("Peak yaw rate", f"{decimal(values.peak_yaw_rate, 2)} rad/s"),
            (
                "Least Izz in flight",
                f"{_known(values.smallest_Izz, 2)} kg m² ({decimal(standing, 2)} standing)",
            ),
            ("Minimum foot radius", f"{_known(values.feet_radius, 3)} m"),
            (
                "Peak foot force",
                (
                    f"{_known(values.peak_force)} N, "
                    f"{_known(values.peak_force_in_weights, 2)} of the weight"
                ),
            ),
            *_model_error(plan),
            *(
                []
                if load is None
                else [("Most loaded joint", f"{load.joint} {load.in_words(sliding)}")]
            ),
            ("Solve time", f"{decimal(1e3 * report.solve_time_s)} ms ({solver})"),
            ("Iterations", f"{report.iterations}" + _attempts(report.attempts)),
            ("Largest violation", worst(plan.violations)),
        ],
        "Plan",
    )


def _model_error(plan: Plan) -> list[tuple[str, str]]:
    error = model_turn(plan)
    if error is None:
        return []
    takeoff, flight = (degrees(turn, signed=True) for turn in (error.takeoff, error.flight))
    turns = f"{takeoff} until lift-off, {flight} in flight"
    return [("Model's turn error", f"{plan.jump.model}: {turns}")]


def _phases(plan: Plan) -> str:
    """Names and durations, s; the feet that stand where it is some of them."""
    schedule = plan.schedule
    durations = np.diff(plan.phase_start)
    return " + ".join(
        phase.name
        + (f" ({', '.join(phase.feet)})" if 0 < len(phase.feet) < len(schedule.legs) else "")
        + f" {decimal(seconds, 2)}"
        for phase, seconds in zip(schedule, durations, strict=True)
    )


def rollout_figures(rollout: Rollout) -> str:
    """The simulation's numbers."""
    outcome = rollout.outcome
    feet = (
        f"{_millimetres(outcome.foot_error_at_touchdown)} at touchdown, "
        f"{_millimetres(outcome.foot_error)} at the end"
    )
    rows = [
        ("World", _scenario(rollout)),
        ("Yaw from the plan", _yaw_errors(outcome)),
        ("Detection", _detection(outcome)),
        ("Foot error", feet),
        (
            "Peak load",
            (
                f"{percent(outcome.peak_torque_ratio)} of torque, "
                f"{percent(outcome.peak_speed_ratio)} of speed"
            ),
        ),
        ("Saturated ticks", percent(outcome.saturated_fraction, 1)),
        (
            "Controller tick",
            (
                f"{decimal(1e3 * outcome.tick_median_s, 2)} ms, "
                f"p99 {decimal(1e3 * outcome.tick_p99_s, 2)} ms"
            ),
        ),
        ("Real-time factor", decimal(outcome.real_time_factor, 1)),
    ]
    if outcome.replan_median_s is not None and outcome.replan_p95_s is not None:
        times = (
            f"{decimal(1e3 * outcome.replan_median_s, 1)} ms, "
            f"p95 {decimal(1e3 * outcome.replan_p95_s, 1)} ms"
        )
        rows += [("New plans", f"{_followed(rollout)} followed"), ("Planning anew", times)]
    if not rollout.landed:
        rows[:0] = [
            (f"Wrong from {decimal(event.time, 2)} s", event.words)
            for event in diagnose(rollout)[:_EVENTS_OF_A_FALL]
        ]
    return table(rows, "Simulation")


def residuals(violations: dict[str, Violation]) -> str:
    """Every constraint's largest violation, recomputed without the solver."""
    rows = (
        (
            _spoken(name),
            _amount(v) + (f", {v.phase} at {decimal(v.time, 2)} s" if v.amount else ""),
        )
        for name, v in sorted(violations.items(), key=lambda item: -item[1].amount)
    )
    return table(rows)


def _scenario(rollout: Rollout) -> str:
    scenario, disturbance = rollout.scenario, rollout.disturbance
    parts = []
    if scenario.board > 0:
        kind = "half board" if scenario.half_board else "board"
        parts.append(f"{kind} of {decimal(1e3 * scenario.board)} mm")
    if scenario.seed is None:
        trunk = scenario.trunk_mass
        parts.append(f"trunk {percent(trunk, 1, signed=True)}" if trunk else "undisturbed")
    else:
        parts.append(
            f"seed {scenario.seed}: "
            f"trunk {percent(disturbance.trunk_mass_factor - 1, 1, signed=True)}, "
            f"friction {decimal(disturbance.friction, 2)}, "
            f"contacts {decimal(1e3 * disturbance.contact_time)} ms, "
            f"torque delayed by {_counted(disturbance.torque_delay_ticks, 'tick')}"
        )
    parts += [
        f"push of {decimal(math.hypot(*push.impulse), 1)} N s at {decimal(push.time, 2)} s"
        for push in rollout.pushes
    ]
    return ", ".join(parts)


def _detection(outcome: Outcome) -> str:
    true, detected = outcome.touchdown_true_s, outcome.touchdown_detected_s
    if detected is None:
        text = "missed" if true is not None else "no contact, none detected"
    elif true is None:
        text = "without a contact"
    else:
        text = f"{decimal(1e3 * (detected - true), 1, signed=True)} ms from the first contact"
    false = outcome.false_touchdowns
    return f"{text}, {false} false" if false else text


def _yaw_errors(outcome: Outcome) -> str:
    errors = (
        ("at lift-off", outcome.yaw_error_at_lift_off),
        ("gained in flight", outcome.yaw_error_in_flight),
        ("at touchdown", outcome.yaw_error_at_touchdown),
        ("at the end", outcome.final_yaw_error),
    )
    return ", ".join(
        f"{degrees(error, signed=True)} {when}" for when, error in errors if error is not None
    )


def _millimetres(length: float | None) -> str:
    return "none" if length is None else f"{decimal(1e3 * length)} mm"


def _known(value: float | None, places: int = 0) -> str:
    return "–" if value is None else decimal(value, places)


def _counted(count: int, thing: str) -> str:
    return f"{count} {thing}" if count == 1 else f"{count} {thing}s"


def _attempts(count: int) -> str:
    return f" ({count} guesses)" if count > 1 else ""
