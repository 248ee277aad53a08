"""The same plan simulated with the disturbances of several seeds: how many land, and the worst.

Processes simulate the seeds side by side; `Seeds` makes one outcome of theirs. The worst is the
earliest fall, if there is one; otherwise the landing whose feet are farthest from the planned
places at the end (`Outcome.foot_error`, of the foot that is farthest). That distance takes a wrong
place and a wrong heading alike, in metres, and the strict measure has it too.
"""

import math

from app.panel.status import SeedResult
from app.workers.reports import (
    Progress,
    Report,
    SeedDone,
    Simulated,
    SimulatedSeeds,
    SimulatedSoFar,
)
from app.workers.tasks import SimulateJump, SimulateSeeds
from llsrbm.analysis.wording import landing
from llsrbm.errors import InputError
from llsrbm.motion.rollout import Rollout
from llsrbm.number_text import decimal

MOST_SEEDS = 100  # Of one request: some five minutes of one process


class Seeds:
    """The reports on a job of several seeds, made of those on its simulations."""

    def __init__(self, job: int, task: SimulateSeeds) -> None:
        """Raise `InputError` of no seeds, or too many."""
        seeds = task.seeds
        if not 0 < len(seeds) <= MOST_SEEDS or len(set(seeds)) < len(seeds):
            raise InputError(
                f"seeds: expected 1 to {MOST_SEEDS} different ones, got {len(seeds)}, "
                f"{len(set(seeds))} of them different"
            )
        self._job, self._seeds = job, seeds
        self._shares = dict.fromkeys(seeds, 0.0)
        self._results: dict[int, SeedResult] = {}
        self._worst: Rollout | None = None

    def take(self, part: SimulateJump, report: Report) -> list[Report]:
        """The reports on the whole job that a report on one simulation makes."""
        seed, of = part.scenario.seed, len(self._seeds)
        assert seed is not None
        match report:
            case SimulatedSoFar():
                return []  # of many simulations the page draws none while they run
            case Progress(share=share):
                self._shares[seed] = share or 0.0
                text = f"simulating, {len(self._results)} of {of} seeds done"
                return [Progress(self._job, text, share=sum(self._shares.values()) / of)]
            case Simulated(rollout=rollout):
                self._shares[seed] = 1.0
                self._results[seed] = result = result_of(seed, rollout)
                if self._worst is None or self._order(rollout) > self._order(self._worst):
                    self._worst = rollout
                done = len(self._results)
                reports: list[Report] = [SeedDone(self._job, result, done, of)]
                if done == of:
                    results = tuple(self._results[seed] for seed in self._seeds)
                    reports.append(SimulatedSeeds(self._job, results, self._worst))
                return reports
        return [report]

    def _order(self, rollout: Rollout) -> tuple[tuple[bool, float], int]:
        """Sorts rollouts from the best to the worst; of equals the first seed's is worse."""
        seed = rollout.scenario.seed
        assert seed is not None
        return badness(rollout), -self._seeds.index(seed)


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
        at = "" if outcome.fell_at_s is None else f" at {decimal(outcome.fell_at_s, 2)} s"
        line = f"Fell{at}: {outcome.reason}."
    else:
        feet = f"; feet within {decimal(1e3 * outcome.foot_error)} mm of the plan"
        line = f"{landing(outcome)}{feet if outcome.strict else ''}."
    return SeedResult(
        seed=seed,
        landed=rollout.landed,
        strict=outcome.strict,
        fell_at_s=outcome.fell_at_s,
        foot_error=outcome.foot_error,
        line=line,
    )
