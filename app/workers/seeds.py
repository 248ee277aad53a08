"""The same plan simulated with the disturbances of several seeds: how many land, and the worst.

The worst is the earliest fall, if there is one; otherwise the landing whose feet are farthest from
the planned places at the end (`Outcome.foot_error`, of the foot that is farthest). That distance
takes a wrong place and a wrong heading alike, in metres, and the strict measure has it too.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from app.workers.planner import Array, Planner, ProgressListener
from app.workers.protocol import SeedResult, SimulateJump, SimulateSeeds
from llsrbm.errors import Cancelled, InputError
from llsrbm.motion.rollout import Rollout

MOST_SEEDS = 100
"""Of one request: some five minutes of one process."""


def simulate_seeds(
    planner: Planner,
    task: SimulateSeeds,
    progress: ProgressListener,
    seed_done: Callable[[SeedResult, int, int], None],
    cancelled: Callable[[], bool],
) -> tuple[tuple[SeedResult, ...], Rollout]:
    """Simulate a plan once a seed.

    Args:
        planner: simulates.
        task: the plan and the seeds.
        progress: called with the share of all that is done.
        seed_done: called with each result, how many are done, and of how many.
        cancelled: True ends with `Cancelled`, between simulations and within one.

    Returns:
        Results in the order of the seeds, and the rollout of the worst.

    Raises:
        llsrbm.errors.Error: no seeds or too many, the plan or the scenario cannot be used, or
            stopped (`Cancelled`).
    """
    seeds = task.seeds
    if not 0 < len(seeds) <= MOST_SEEDS or len(set(seeds)) < len(seeds):
        raise InputError(
            f"seeds: expected 1 to {MOST_SEEDS} different ones, got {len(seeds)}, "
            f"{len(set(seeds))} of them different"
        )
    results: list[SeedResult] = []
    worst: Rollout | None = None
    for number, seed in enumerate(seeds):

        def percent(
            text: str, *, share: float | None = None, number: int = number, **_: Any
        ) -> None:
            done = (number + (share or 0.0)) / len(seeds)
            progress(f"seed {number + 1} of {len(seeds)}, {text}", share=done)

        if cancelled():
            raise Cancelled("the simulations were cancelled")
        one = SimulateJump(task.plan, task.scenario.but(seed=seed))
        rollout = planner.simulate(one, percent, _ignore, cancelled)
        results.append(result_of(seed, rollout))
        if worst is None or badness(rollout) > badness(worst):
            worst = rollout
        seed_done(results[-1], number + 1, len(seeds))
    assert worst is not None  # there is a seed at least
    return tuple(results), worst


def badness(rollout: Rollout) -> tuple[bool, float]:
    """Sorts rollouts from the best to the worst: see above."""
    outcome = rollout.outcome
    if not rollout.landed:
        return True, -math.inf if outcome.fell_at_s is None else -outcome.fell_at_s
    return False, outcome.foot_error


def result_of(seed: int, rollout: Rollout) -> SeedResult:
    """The figures and the line of one simulation."""
    outcome = rollout.outcome
    if not rollout.landed:
        at = "" if outcome.fell_at_s is None else f" at {outcome.fell_at_s:.2f} s"
        line = f"Fell{at}: {outcome.reason}."
    else:
        loosely = "" if outcome.strict else ", but failed the strict criterion"
        line = f"Landed{loosely}; feet within {1e3 * outcome.foot_error:.0f} mm of the plan."
    return SeedResult(
        seed=seed,
        landed=rollout.landed,
        strict=outcome.strict,
        fell_at_s=outcome.fell_at_s,
        foot_error=outcome.foot_error,
        line=line,
    )


def _ignore(_share: float, _time: Array, _qpos: Array) -> None:
    """Of many simulations the page draws none while they run."""
