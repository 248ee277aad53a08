"""Planning while a slider moves: what to plan next, and from which plan to start.

While a request changes, plans are sought quickly, each from the one before; far from that the whole
body is asked at once, where the robot's table is sure of the jump. A request that has not changed
for `REST`, and has its quick answer, is planned once more from scratch, or, where the robot's table
knows such jumps, by the whole body: the end does not depend on the way there, and is what the
command line finds for the same request.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from app.workers.tasks import PlanJump
from llsrbm.motion.plan import Plan
from llsrbm.request.jump import INCLINES, Jump
from llsrbm.request.tuning import Tuning

REST = 0.5
"""s without a change after which a request counts as made; twice what a hand takes between steps of
a slider. With 0.3 the whole body's plan begins where a hand turns, and steps wait for it."""

_NEAR_TWIST = math.radians(30)  # rad; a plan farther away is a worse start than none
_NEAR_MOVE = 0.15  # m, likewise
_NEAR_SPEED = 0.3  # m/s, likewise


@dataclass(frozen=True)
class DragPlanning:
    """One tab's request on its way."""

    # what was planned last, or is being planned; None: nothing that counts
    requested: tuple[Jump, Tuning] | None = None
    # whether it has its quick answer, and rests until it is planned from scratch
    rests: bool = False
    # whether its rest is over: it is planned from scratch as soon as it has its quick answer
    over: bool = False
    # number of rests so far, so that one that was broken off is not taken for a later one
    rest: int = 0

    def request(
        self, jump: Jump, tuning: Tuning, shown: Plan | None, *, whole_body: bool
    ) -> tuple[DragPlanning, PlanJump | None]:
        """The request on its way, and what to plan for it, from the plan shown; None: under way.

        Far from that its draft takes longer than the plan of the whole body, if that is wanted.
        """
        if (jump, tuning) == self.requested:
            return self, None
        moved = self.done(jump, tuning)
        alike = shown is not None and _kind(shown.jump) == _kind(jump)
        if shown is None or not alike or not shown.solved or jump.route:
            # A route begins from the plans of its jumps, not from the one before.
            return moved, PlanJump(jump, tuning, whole_body=whole_body)
        # A plan from an old file has no solution.
        begins = _near(shown.jump, jump) or shown.is_nearest
        near = shown if shown.solution is not None and begins else None
        at_once = whole_body and near is None
        return moved, PlanJump(jump, tuning, near=near, patient=False, whole_body=at_once)

    def answered(self, task: PlanJump, plan: Plan | None) -> DragPlanning:
        """The newest request has its answer; a quick one will be planned again, unless it is the
        plan of the whole body already.
        """
        if task.patient or (plan is not None and plan.refined):
            return self
        return replace(self, rests=True)

    def done(self, jump: Jump, tuning: Tuning) -> DragPlanning:
        """A request that needs no plan, or has no answer yet; a rest that was on is broken off."""
        return DragPlanning((jump, tuning), rest=self.rest + 1)

    def forget(self) -> DragPlanning:
        """Nothing was requested: the same request counts as a new one."""
        return DragPlanning(rest=self.rest)

    def rested(self, number: int) -> tuple[DragPlanning, PlanJump | None]:
        """The task now that the rest with this number is over.

        None: it was broken off, or the quick answer is not there yet.
        """
        if number != self.rest or self.requested is None:
            return self, None
        if not self.rests:
            return replace(self, over=True), None
        return DragPlanning(self.requested, rest=self.rest), PlanJump(*self.requested)


def _kind(jump: Jump) -> tuple[object, ...]:
    """Fields that two requests must share for one's plan to be a start for the other's.

    Phases are of a type, and of a number of hops; whole turns differ by turns; free arms are
    variables more.
    """
    phases = jump.type, jump.jumps, jump.roll, jump.pitch
    return jump.robot, jump.model, jump.arms, *phases


def _near(one: Jump, other: Jump) -> bool:
    def apart(*names: str) -> float:
        return max(abs(getattr(one, name) - getattr(other, name)) for name in names)

    return (
        apart("twist", *INCLINES) <= _NEAR_TWIST
        and apart("forward", "lateral", "height", "gap", "bar") <= _NEAR_MOVE
        and apart("speed", "end_speed") <= _NEAR_SPEED
    )
