"""The nearest jump that the whole body does, where it does not do all that a draft does.

Drafts give up what the centroidal problem cannot do; the whole body, with its rotors and what it
keeps in reserve for the controller, often stops before, and searches of its own problem from a
draft that is too much end nowhere, late. Here what was given up is reduced further, by halving,
until a motion that begins from the robot's table of solved jumps has a certificate that holds.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from llsrbm.certified_plan import CertifiedPlanner, may_hold_elsewhere
from llsrbm.motion.plan import Plan
from llsrbm.request.jump import COMPONENTS, STEPS, Jump

NOT_FOUND = "no motion of the whole body that keeps all limits was found"
"""Why a request has a draft and no plan; a sentence without its full stop."""
HALVINGS = 3  # to an eighth of what is reduced
# Share of a draft's nearest jump that is near enough. For less the whole body's own search, of some
# seconds, is tried first; what it finds at the edge often falls (docs/figures.md).
ENOUGH = 0.4


def plan_or_nearest(
    planner: CertifiedPlanner, draft: Plan, wanted: Jump, *, tried: bool = False
) -> Plan:
    """The whole body's plan of a draft; or, where its certificate does not hold, of less.

    The result's `jump` says what it is of. It is without a certificate that holds where none is
    known of less either.

    Args:
        planner: of whole bodies' plans.
        draft: a centroidal plan, of the request or of the nearest jump that has one.
        wanted: the request.
        tried: it was begun from the robot's table, in vain.

    Raises:
        Cancelled: it is not wanted any more.
    """
    reduced = _given_up(draft.jump, wanted)
    if not reduced:
        found = replace(planner, guesses=planner.guesses and not tried).plan(draft)
        if found.certified or not may_hold_elsewhere(found):
            return found
        return _less(planner, draft, COMPONENTS)[0] or found
    less, share = planner.nearby(draft, draft.jump), 1.0
    if less is None:
        less, share = _less(planner, draft, reduced)
    if less is not None and share >= ENOUGH:
        return less
    # What is nearest need not be this one: a solver of a finer grid is not built for it.
    found = replace(planner, guesses=False, finer=False).plan(draft)
    return found if found.certified or less is None else less


def _given_up(jump: Jump, wanted: Jump) -> tuple[str, ...]:
    """The components of which a jump does less than was asked."""
    return tuple(
        name
        for name, step in STEPS.items()
        if abs(getattr(wanted, name) - getattr(jump, name)) > step / 2
    )


def _less(
    planner: CertifiedPlanner, draft: Plan, reduced: tuple[str, ...]
) -> tuple[Plan | None, float]:
    """The most of a draft's jump that is found when some components are reduced; its share."""
    found, done, failed = None, 0.0, 1.0
    for _ in range(HALVINGS):
        share = (done + failed) / 2
        plan = planner.nearby(draft, _reduced(draft.jump, reduced, share))
        if plan is None:
            failed = share
        else:
            found, done = plan, share
    return found, done


def _reduced(jump: Jump, names: tuple[str, ...], share: float) -> Jump:
    """A share of some components, in whole steps."""
    parts: dict[str, Any] = {}
    for name in names:
        value, step = share * getattr(jump, name), STEPS[name]
        parts[name] = math.copysign(math.floor(abs(value) / step + 1e-6) * step, value)
    return replace(jump, **parts)
