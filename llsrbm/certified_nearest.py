"""The nearest jump that the whole body does, where it does not do all that a draft does.

Drafts give up what the centroidal problem cannot do; the whole body, with its rotors and what it
keeps in reserve for the controller, often stops before, and searches of its own problem from a
draft that is too much end nowhere, late. Here what was given up is reduced further, by halving,
until a motion that begins from the robot's table of solved jumps has a certificate that holds. A
jump that the table makes unlikely is sought from there alone.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from llsrbm.certified_plan import CertifiedPlanner, may_hold_elsewhere
from llsrbm.motion.plan import Plan
from llsrbm.motion.robot import robot_of
from llsrbm.planning.whole_body.feasible import feasible_of
from llsrbm.planning.whole_body.learned_file import fits
from llsrbm.request.jump import COMPONENTS, STEPS, Jump

NOT_FOUND = "no motion of the whole body that keeps all limits was found"
"""Why a request has a draft and no plan; a sentence without its full stop."""
# Score below which a jump is not solved from its draft, nor on a finer grid: of 82 such requests of
# Go2's and ANYmal's (of 600, seeds 10061, 10062 and 10072) two were ever certified.
UNLIKELY = -1.0
PROBES = 3  # jumps that are tried: a half, then halfway between what is done and what is not


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
    reduced, found = _given_up(draft.jump, wanted), None
    if not reduced:
        if not _unlikely(planner, draft):
            whole = replace(planner, guesses=planner.guesses and not tried).plan(draft)
            if whole.certified or not may_hold_elsewhere(whole):
                return whole
            return _less(planner, draft, COMPONENTS, tried=True) or whole
        found = None if tried else planner.nearby(draft, draft.jump)
    found = found or _less(planner, draft, reduced or COMPONENTS, tried=not reduced)
    # What is nearest need not be this one: a solver of a finer grid is not built for it.
    return found or replace(planner, guesses=False, finer=False).plan(draft)


def _unlikely(planner: CertifiedPlanner, draft: Plan) -> bool:
    """Whether the table of solved jumps says that a draft's is hardly found."""
    feasible = feasible_of(planner.robot or robot_of(draft))
    if feasible is None or not fits(draft.jump.on_ground(0.0), draft.tuning):
        return False
    return feasible.score(draft.jump) < UNLIKELY


def _given_up(jump: Jump, wanted: Jump) -> tuple[str, ...]:
    """The components of which a jump does less than was asked."""
    return tuple(
        name
        for name, step in STEPS.items()
        if abs(getattr(wanted, name) - getattr(jump, name)) > step / 2
    )


def _less(
    planner: CertifiedPlanner, draft: Plan, reduced: tuple[str, ...], *, tried: bool
) -> Plan | None:
    """The most of a draft's jump that is found when some components are reduced.

    `tried`: all of it was, in vain; else it is at last, where three quarters are done. There is no
    less of a jump on the spot, nor of a route, whose landings alone say where it leads.
    """
    if not any(getattr(draft.jump, name) for name in reduced):
        return None
    found, done, failed = None, 0.0, 1.0
    for left in reversed(range(PROBES)):
        share = (done + failed) / 2
        if failed == 1.0 and not (left or tried):
            share = 1.0
        plan = planner.nearby(draft, _reduced(draft.jump, reduced, share))
        if plan is None:
            failed = share
        else:
            found, done = plan, share
    return found


def _reduced(jump: Jump, names: tuple[str, ...], share: float) -> Jump:
    """A share of some components, in whole steps."""
    parts: dict[str, Any] = {}
    for name in names:
        value, step = share * getattr(jump, name), STEPS[name]
        parts[name] = math.copysign(math.floor(abs(value) / step + 1e-6) * step, value)
    return replace(jump, **parts)
