"""One request of a library: planned, checked and simulated in a process of its own."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from llsrbm.errors import Error, InputError
from llsrbm.library.draws import Draw
from llsrbm.request.jump import Jump
from llsrbm.request.tuning import Tuning

if TYPE_CHECKING:
    from llsrbm.library.card import Simulated
    from llsrbm.library.file import StoredMotion
    from llsrbm.motion.plan import Plan

NONE_LIKE_IT = "the robot's table of solved jumps has next to none like it"
KEPT, NOT_PLANNED, NOT_CERTIFIED = "kept", "not-planned", "not-certified"
NOT_STRICT, FAILED, THERE = "not-strict", "failed", "there-already"

LIMIT = 300.0  # s that an attempt may take; most take some seconds
_FIRST_SEED = 46_000  # of simulations
_LONGEST = 300  # characters of a reason


class NotStrict(InputError):
    """A motion of which a simulation did not land strictly."""


@dataclass(frozen=True)
class Request:
    """A jump that is asked for: a draw, one that was given, or the image of a motion in a mirror.

    `original`: the motion of which the image is wanted; then jump and tuning are its.
    """

    jump: Jump
    tuning: Tuning
    draw: Draw | None = None
    original: StoredMotion | None = None

    @classmethod
    def drawn(cls, draw: Draw) -> Request:
        """That of a draw."""
        return cls(draw.jump, Tuning(), draw)

    @classmethod
    def image(cls, original: StoredMotion) -> Request:
        """The image of a motion."""
        return cls(original.card.request, original.card.tuning, original=original)

    @property
    def number(self) -> int | None:
        """That of its draw."""
        return None if self.draw is None else self.draw.number


@dataclass(frozen=True, eq=False)
class Attempt:
    """The end of a request: a motion if it is `KEPT`, else why not."""

    request: Request
    status: str
    motion: StoredMotion | None = None
    why: str = ""


def simulated(plan: Plan, seeds: int, *, every: bool = False) -> Simulated:
    """How simulations of a plan end, everything disturbed by `seeds` seeds; the first that is not
    strict is the last, but of `every`.

    Raises `Error`: the plan cannot be simulated.
    """
    from llsrbm.api import simulate
    from llsrbm.library.card import Simulated

    outcomes = []
    for seed in range(_FIRST_SEED, _FIRST_SEED + seeds):
        outcomes.append(simulate(plan, seed=seed).outcome)
        if not (every or outcomes[-1].strict):
            break
    return Simulated.of(outcomes)


def attempt(request: Request, seeds: int) -> Attempt:
    """Plan a request, put it into a library's form, and simulate what that gives.

    Every simulation has to be strict, if there are some.
    """
    try:
        return _attempt(request, seeds)
    except NotStrict as error:
        return Attempt(request, NOT_STRICT, why=_one_line(error))
    except Error as error:
        return Attempt(request, NOT_PLANNED, why=_one_line(error))
    except Exception as error:  # noqa: BLE001  # a build goes on, and its journal has the error
        return Attempt(request, FAILED, why=_one_line(error))


def judged(
    plan: Plan, seeds: int, drawn: int | None = None, *, not_strict: bool = False
) -> StoredMotion:
    """A plan in a library's form, after as many simulations.

    `not_strict`: whatever becomes of these; else each has to be strict.

    Raises `InputError`: see `stored_motion`, or a simulation is not strict.
    """
    from llsrbm.library.card import Simulated
    from llsrbm.library.library import stored_motion

    motion = stored_motion(plan, Simulated(), drawn)
    if not_strict:
        return _with(motion, simulated(plan, seeds, every=True))
    return _strict(motion, plan, seeds)


def _strict(motion: StoredMotion, plan: Plan, seeds: int) -> StoredMotion:
    """A motion with its simulations; raises `NotStrict`: one is not strict."""
    found = simulated(plan, seeds)
    if seeds and not found.all_strict:
        raise NotStrict(
            f"simulation {found.seeds} of {seeds} did not land strictly; expected that all do"
        )
    return _with(motion, found)


def _with(motion: StoredMotion, found: Simulated) -> StoredMotion:
    return replace(motion, card=motion.card.model_copy(update={"simulated": found}))


def _attempt(request: Request, seeds: int) -> Attempt:
    from llsrbm.api import plan as planned
    from llsrbm.certified_nearest import is_unlikely

    if request.original is not None:
        return Attempt(request, KEPT, _image(request.original, seeds))
    # To be sure takes as long as three motions; others are drawn.
    if request.draw is not None and is_unlikely(request.jump, request.tuning):
        return Attempt(request, NOT_PLANNED, why=NONE_LIKE_IT)
    plan = planned(
        request.jump,
        weights=request.tuning.weights,
        limits=request.tuning.limits,
        patient=False,
        explains=False,
    )
    if not plan.certified:
        return Attempt(request, NOT_CERTIFIED, why="the plan's certificate does not hold")
    return Attempt(request, KEPT, judged(plan, seeds, request.number))


def _image(original: StoredMotion, seeds: int) -> StoredMotion:
    """The image of a motion in a mirror, checked and simulated like any other."""
    from llsrbm.library.library import checked, robot_of_card
    from llsrbm.library.mirror import mirrored
    from llsrbm.library.stored import reopened

    robot, name = robot_of_card(original.card), original.card.name
    plan = reopened(original.card, original.numbers, robot, name)
    image = checked(mirrored(original.card, plan, robot), robot)
    return _strict(image, reopened(image.card, image.numbers, robot, name), seeds)


def run_attempt(request: Request, seeds: int, limit: float) -> Attempt:
    """`attempt` in the process beside this one, within `limit` seconds or failed."""
    from llsrbm.sweep.jump import ProcessDied, compute

    try:
        found: Attempt = compute(attempt, request, seeds, limit=limit)
    except TimeoutError:
        return Attempt(request, FAILED, why=f"no result within {limit:g} s")
    except (ProcessDied, Error) as error:
        return Attempt(request, FAILED, why=_one_line(error))
    return found


def _one_line(error: Exception) -> str:
    return (" ".join(str(error).split()) or type(error).__name__)[:_LONGEST]
