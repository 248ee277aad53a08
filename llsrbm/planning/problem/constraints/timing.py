"""Durations of the phases."""

from __future__ import annotations

from typing import Any

import numpy as np

from llsrbm.planning.problem.constraints.base import Array, Bounds, Constraint, Limit
from llsrbm.planning.problem.knots import Knots
from llsrbm.planning.problem.layout import Layout, Role
from llsrbm.planning.problem.stage import Stage
from llsrbm.planning.problem.task import Task


class PhaseTimes(Constraint):
    """T_min <= T <= T_max for each phase (the paper bounds dt; flight collapses without it)."""

    name = "phase_times"
    unit = "s"
    limits = tuple(
        Limit(
            f"{phase}_{end}",
            f"{extreme} {title}",
            "s",
            f"{title} {effect}",
            lowest=accepted[0],
            highest=accepted[1],
            place=("timing", phase, index),
            lower_bound=end == "min",
        )
        for phase, title in (("takeoff", "take-off"), ("flight", "flight"), ("landing", "landing"))
        for index, (end, extreme, effect, accepted) in enumerate(
            (
                ("min", "shortest", "takes at least this long", (0.1, 1.0)),
                ("max", "longest", "may take longer", (0.15, 1.5)),
            )
        )
    )

    def applies(self, role: Role) -> bool:
        """Where a duration is chosen: at the start, and at the end of every phase but the last."""
        return role.initial or (role.last and not role.final)

    def rows(self, stage: Stage) -> Any:
        """(1, 1) s."""
        return stage.symbols.get("next_duration", stage.symbols["duration"])

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """The limits of the phase that begins."""
        role = layout.roles[knot]
        low, high = task.times(role.phase + (0 if role.initial else 1))
        return np.array([low]), np.array([high])

    def violation(self, knots: Knots) -> Array:
        """At the knots at which phases begin; rows are where their durations are chosen."""
        out = super().violation(knots)
        return np.concatenate([out[:1], [0.0], out[1:-1]])
