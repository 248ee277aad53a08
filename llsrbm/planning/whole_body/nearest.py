"""The nearest jump that the whole body does, by solves in which the landing may be moved.

They begin with a jump that is done, of the robot's table, and move the landing towards the one that
is wanted, as far as all rows hold: what is not done has a price, by its distance.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import chain
from typing import Any

import numpy as np

from llsrbm.arrays import Array
from llsrbm.ocp.horizon import Iterate
from llsrbm.planning.problem.placement import retargeted
from llsrbm.planning.problem.shortfall import distance
from llsrbm.planning.problem.task import Task
from llsrbm.planning.solve.watch import Watch
from llsrbm.planning.whole_body.binding import Edge
from llsrbm.planning.whole_body.feasible import Feasible
from llsrbm.planning.whole_body.refine import Refiner
from llsrbm.request.jump import COMPONENTS, STEPS, Jump

# Cost of a whole range that is not done. Hard jumps cost some 1000: with a tenth of it nothing
# moves, with ten times as much solves end nowhere.
PRICE = 1e4
# From there, where little is left to do: of 24 requests of Go2 five come from 0.5 to 5 % of the
# ranges to all, of ANYmal three.
DEARER, LITTLE = 3e4, 0.06
DONE = 2e-3  # of the ranges; what is left below it is nothing
# Score from which on the table is sure of a jump, and steps in which such a share of one is sought.
SURE, STEP = 1.0, 0.05
# Parts of that share, each where the one before leads nowhere: with longer flights the whole leads
# further than 0.6 or 0.3 (distances of 0.00, 0.04 and 0.09, not 0.13 and more). A payload, limits
# other than the table's, and some jumps of G1 need less.
PARTS = (1.0, 0.5, 0.25)
# Shares of the ranges by which less is done of what is given up, until a certificate holds.
LESS = (0.0, 0.03, 0.1)


@dataclass(frozen=True, eq=False)
class Reached:
    """A jump, and its solution or one nearby; edge: what stops more of it."""

    jump: Jump
    solution: Iterate
    edge: Edge | None = None


def nearest(refiner: Refiner, task: Task, feasible: Feasible, watch: Watch) -> Iterator[Reached]:
    """Jumps of whole steps near a task's that are done, or nearly: the nearest first.

    Raises:
        Cancelled: it is not wanted any more.
    """
    reached, tried, begun = None, [], _begun(refiner, task, feasible)
    for each in begun:
        tried.append(each)
        reached = _moved(refiner, task, each, PRICE, watch)
        if reached is not None:
            yield from _reached(refiner, task, reached, watch)
            break
    # Links may pass each other in all of these: less, as the table leads to it by itself.
    edge = None if reached is None else reached.edge
    for each in chain(tried, begun):
        yield replace(each, jump=_in_whole_steps(each.jump, task, 0.0), edge=edge)


def _begun(refiner: Refiner, task: Task, feasible: Feasible) -> Iterator[Reached]:
    """Jumps of the table near each share of a request; none of a robot without a table."""
    for share in _shares(task, feasible):
        jump = _share(task.jump, share)
        nearby = refiner.nearby(jump, task.tuning)
        if nearby is None:
            return
        yield Reached(jump, nearby)


def _reached(refiner: Refiner, task: Task, reached: Reached, watch: Watch) -> Iterator[Reached]:
    """The jump that a moved landing comes to, in whole steps, and less of it."""
    if DONE < distance(task, reached.jump) < LITTLE:
        further = _moved(refiner, task, reached, DEARER, watch)
        if further is not None and distance(task, further.jump) < DONE:
            yield replace(further, jump=task.jump)
    before = None
    for less in LESS:
        jump = _in_whole_steps(reached.jump, task, less)
        if jump != before:
            yield replace(reached, jump=jump)
        before = jump


def _shares(task: Task, feasible: Feasible) -> tuple[float, ...]:
    """The shares of a jump at which a solve begins, until one leads on.

    The first is the largest of which the table is sure, 0: not even of a small one.
    """
    sure = sure_share(task.jump, feasible)
    return tuple(part * sure for part in PARTS) if sure else (sure,)


def sure_share(jump: Jump, feasible: Feasible) -> float:
    """The largest share of a jump of which the table is sure; 0: not even of a small one."""
    shares = np.arange(1.0, 0.0, -STEP).tolist()
    return next((s for s in shares if feasible.score(_share(jump, s)) >= SURE), 0.0)


def _share(jump: Jump, share: float) -> Jump:
    parts: dict[str, Any] = {name: share * getattr(jump, name) for name in COMPONENTS}
    return replace(jump, **parts)


def _moved(
    refiner: Refiner, task: Task, begun: Reached, price: float, watch: Watch
) -> Reached | None:
    """From a jump towards a task's; None: it leads nowhere."""
    wanted = _values(task.jump) - _values(begun.jump)
    at = retargeted(task, begun.jump)
    found = refiner.moved(at, begun.solution, wanted, price, watch)
    if found is None:
        return None
    reached = (_values(begun.jump) + found.offset).tolist()
    done: dict[str, Any] = dict(zip(COMPONENTS, reached, strict=True))
    return Reached(replace(task.jump, **done), found.solution, found.edge)


def _in_whole_steps(reached: Jump, task: Task, less: float) -> Jump:
    """A jump in whole steps, with less of what is given up: what is off by half a step or more."""
    parts: dict[str, Any] = {}
    for name, step in STEPS.items():
        whole, value = getattr(task.jump, name), getattr(reached, name)
        parts[name] = whole
        if abs(whole - value) > step / 2:
            low, high = getattr(task.robot.file.task, name)
            left = max(abs(value) - less * (high - low), 0.0)
            parts[name] = math.copysign(math.floor(left / step + 1e-6) * step, whole)
    return replace(task.jump, **parts)


def _values(jump: Jump) -> Array:
    return np.array([getattr(jump, name) for name in COMPONENTS])
