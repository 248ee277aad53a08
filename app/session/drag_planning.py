"""Planning while a slider moves: what to ask for next, and when.

While a request changes, plans are sought quickly, each from the one before. When it has rested, it
is planned once more from scratch: what is shown in the end does not depend on the way there, and is
what the command line finds for the same request.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable

from app.compute.protocol import PlanJump
from llsrbm.jump import Jump
from llsrbm.motion.plan import Plan
from llsrbm.tuning import Tuning

REST = 0.5
"""s without a change after which a request counts as made; twice what a hand takes between steps of
a slider."""


_NEAR_TWIST = math.radians(30)  # rad; a plan farther away is a worse start than none
_NEAR_MOVE = 0.15  # m, likewise


class DragPlanning:
    """One tab's request on its way; for one thread."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        """Nothing is asked for."""
        self._clock = clock
        self._asked: tuple[Jump, Tuning] | None = None
        self._rests_at: float | None = None

    @property
    def settled(self) -> bool:
        """Whether nothing is going to be asked for by itself."""
        return self._rests_at is None

    def ask(self, jump: Jump, tuning: Tuning, shown: Plan | None) -> PlanJump | None:
        """What to plan for a request, or None if it has been asked for.

        Args:
            jump: what is wanted.
            tuning: under which weights and limits.
            shown: the plan that is shown, to start from if it is a near one.
        """
        if (jump, tuning) == self._asked:
            return None
        self._asked = (jump, tuning)
        self._rests_at = None
        alike = shown is not None and (shown.jump.robot, shown.jump.model) == (
            jump.robot,
            jump.model,
        )
        if shown is None or not alike or not shown.solved:
            return PlanJump(jump, tuning)
        # A plan from an old file has no solution.
        near = shown if shown.solution is not None and _near(shown.jump, jump) else None
        return PlanJump(jump, tuning, near=near, patient=False)

    def answered(self, task: PlanJump) -> None:
        """The newest request has its answer; a quick one will be looked at again."""
        if not task.patient:
            self._rests_at = self._clock() + REST

    def forget(self) -> None:
        """Nothing was asked for: the same request counts as a new one."""
        self._asked = self._rests_at = None

    @property
    def wait(self) -> float | None:
        """Seconds until `due` has something, or None."""
        return None if self._rests_at is None else max(0.0, self._rests_at - self._clock())

    def due(self) -> PlanJump | None:
        """What to plan now that the request has rested, or None."""
        if self._asked is None or self._rests_at is None or self._clock() < self._rests_at:
            return None
        self._rests_at = None
        return PlanJump(*self._asked)


def _near(one: Jump, other: Jump) -> bool:
    moves = (abs(getattr(one, n) - getattr(other, n)) for n in ("forward", "lateral", "height"))
    return abs(one.twist - other.twist) <= _NEAR_TWIST and max(moves) <= _NEAR_MOVE
