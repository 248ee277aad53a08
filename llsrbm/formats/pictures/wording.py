"""A plan or a rollout in a few words, for pictures: its request and its result."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

from llsrbm.analysis.diagnosis import fall_in_words
from llsrbm.look.titles import title_of
from llsrbm.motion.plan import Plan
from llsrbm.motion.trajectory import Trajectory
from llsrbm.request.jump import Jump


def title(trajectory: Trajectory) -> str:
    """Robot, jump and model, whatever robot it is."""
    jump = trajectory.jump
    plan = trajectory if isinstance(trajectory, Plan) else trajectory.plan
    task = title_of(
        replace(jump, robot=Jump().robot),
        plan.tuning,
        None if isinstance(trajectory, Plan) else trajectory.scenario,
    )
    return f"{Path(jump.robot).stem}: {task}"


def outcome_words(trajectory: Trajectory) -> str:
    """The result in words, the most important thing first."""
    if isinstance(trajectory, Plan):
        if trajectory.solved:
            return f"planned in {1e3 * trajectory.report.solve_time_s:.0f} ms"
        return "not a feasible plan: the solver did not converge"
    outcome = trajectory.outcome
    if not trajectory.landed:
        return f"fell {fall_in_words(trajectory)}"
    yaw = math.degrees(outcome.final_yaw_error)
    away = 1e3 * outcome.final_position_error
    loosely = "" if outcome.strict else ", though not by the strict measure"
    return f"landed, {abs(yaw):.1f}° and {away:.0f} mm from the plan at the end{loosely}"
