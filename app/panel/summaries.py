"""Plans and rollouts in words and numbers for the panel."""

from collections.abc import Sequence
from html import escape

import numpy as np

from app.panel.html import SMALL, table
from app.panel.status import Checks, SeedResult, Status, Verdict
from llsrbm.analysis.diagnosis import fall_in_words
from llsrbm.analysis.drafts import draft_reason
from llsrbm.analysis.figures import figures_of_plan
from llsrbm.analysis.wording import (
    InWords,
    drive_rows,
    followed_plans,
    plan_rows,
    rollout_rows,
    shortfalls,
    violation_rows,
)
from llsrbm.certificate import stated
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.motion.solve_report import Violation
from llsrbm.number_text import degrees
from llsrbm.request.jump import Jump, changes
from llsrbm.robots import Robot


def plan_status(
    plan: Plan, remark: str = "", wanted: Jump | None = None, reason: str = "", follows: str = ""
) -> Status:
    """That a plan is there, after a remark; or the nearest to what was asked for, and why.

    `follows`: words on the whole body's plan that will replace it; "": none will.
    """
    parts = [remark] if remark else []
    if not (plan.certified or follows):
        why = draft_reason(plan)
        parts = [f"{remark} {_sentence(why)}"] if remark.endswith(".") else [*parts, f"as {why}"]
    rest = f"{', '.join(parts)} {follows}".strip()
    figures, checks = _plan_figures(plan), _checks(plan)
    if wanted is not None:
        nearest = changes(wanted, plan.jump) or "almost the request"
        points = _sentence(nearest), _sentence(reason)
        return Status(Verdict.NEAREST, rest, points=points, figures=figures, checks=checks)
    verdict = Verdict.FEASIBLE if plan.certified else Verdict.DRAFT
    return Status(verdict, rest, figures=figures, checks=checks)


def _plan_figures(plan: Plan) -> tuple[tuple[str, str], ...]:
    """The figures that matter for this jump: how it turns, how long it flies, what it takes."""
    values = figures_of_plan(plan)
    words = InWords(values)
    names = ["flight_time_s", "planned_torque_ratio", "model_turn_in_flight"]
    if not plan.jump.turns:
        names.insert(0, "Izz_change")
    shown = [words.row(name) for name in names if getattr(values, name) is not None]
    return (*([_turn(plan)] if plan.jump.turns else []), *shown)


def _turn(plan: Plan) -> tuple[str, str]:
    """The turn of the body about the axis that the request names."""
    axis = 1 if plan.jump.pitch else 0
    turned = np.trapezoid(plan.angular_velocity[:, axis], plan.time)
    return "Turn", degrees(float(turned), signed=True)


def _checks(motion: Plan | Rollout) -> Checks | None:
    found = stated(motion)
    if found is None:
        return None
    held = [each.holds is True for each in found]
    return Checks(sum(held), len(held))


def refused_status(reason: str, remark: str = "") -> Status:
    """That there is no plan, and none near it."""
    points = _sentence(reason), "No similar feasible jump is known."
    return Status(Verdict.INFEASIBLE, remark, points=points)


def progress_line(text: str, iteration: int | None) -> str:
    """The status line after "Planning" while the solver works."""
    step = "" if iteration is None else f", step {iteration}"
    return f"({text}{step}) ..."


def simulated_status(rollout: Rollout, remark: str = "") -> Status:
    """Whether the robot landed, and how well, after a remark; or what went wrong."""
    outcome = rollout.outcome
    if not rollout.landed:
        words = f"{fall_in_words(rollout)}."
        return Status(Verdict.FELL, f"{remark}: {words}" if remark else words)
    parts = [remark] if remark else []
    if rollout.replans:
        parts.append(f"{followed_plans(rollout)} new plans followed")
    limit = ""
    if not outcome.strict:
        pushed_away = rollout.pushes and outcome.recovered
        limit = "recovered from the push" if pushed_away else "not strict"
        parts.append(shortfalls(outcome))
    figures = InWords(outcome)
    at_contact = outcome.yaw_error_at_touchdown is not None
    yaw = figures["yaw_error_at_touchdown" if at_contact else "final_yaw_error"]
    names = ("final_tilt", "foot_error", "peak_torque_ratio")
    shown = (("Yaw error", yaw), *map(figures.row, names))
    checks = _checks(rollout)
    return Status(Verdict.LANDED, ", ".join(parts), limit=limit, figures=shown, checks=checks)


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


def _sentence(text: str) -> str:
    return f"{text[:1].upper()}{text[1:].removesuffix('.')}."


def plan_figures(plan: Plan) -> str:
    """The plan's numbers."""
    return table(plan_rows(plan), "Plan")


def rollout_figures(rollout: Rollout) -> str:
    """The simulation's numbers."""
    return table(rollout_rows(rollout), "Simulation")


def drive_figures(robot: Robot) -> str:
    """The numbers of a robot's drives."""
    return table(drive_rows(robot), f"Drives of {robot.file.title}")


def residuals(violations: dict[str, Violation]) -> str:
    """Every constraint's largest violation, recomputed without the solver."""
    return table(violation_rows(violations))
