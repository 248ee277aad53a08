"""Which jumps can be planned, guessed in a fraction of a millisecond from jumps that were planned.

A request x is scaled over what the robot's file allows. The score of x is the logarithm of the odds
that a plan of it is found whose certificate holds,

    score(x) = w · phi(x) + sum_k a_k exp(-|x - x_k|^2 / (2 WIDTH^2)) ,

where phi are all products of up to `DEGREE` of the numbers of x that stay when left and right
change places: twist and lateral together come an even number of times. The weights w are those of a
logistic regression on the robot's table of solved and refused jumps (`llsrbm robot learn`): a robot
without a table has none. The second part is what was seen since: where a jump was planned, or
refused, against the score.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache, lru_cache
from itertools import combinations_with_replacement

import numpy as np
from scipy.special import expit

from llsrbm.arrays import Array, IntArray
from llsrbm.planning.whole_body.learned import Outcomes
from llsrbm.planning.whole_body.learned_file import leads_to, outcomes_of
from llsrbm.request.jump import COMPONENTS, Jump
from llsrbm.request.tuning import Tuning
from llsrbm.robots import load_robot
from llsrbm.robots.robot import Robot

DEGREE = 3
WIDTH = 0.15  # of half a range: how far around it a jump that was seen counts
SURE = 2.0  # score to which a jump that was seen is corrected: odds of seven to one
RIDGE = 0.3  # of the weights
_STEPS = 60  # of Newton's method, which takes ten
_CHANGE = 1e-6  # of weights, with which it ends
_MOST_SEEN = 200  # corrections; the oldest are forgotten
_SIDED = [COMPONENTS.index("twist"), COMPONENTS.index("lateral")]  # change their sign in a mirror


@dataclass(frozen=True, eq=False)
class Feasible:
    """One robot's classifier."""

    ends: Array  # (2, D) of what is scaled, SI
    weights: Array  # (F,)
    centres: Array  # (K, D) scaled requests that were seen
    amounts: Array  # (K,) of their corrections

    def scores(self, x: Array) -> Array:
        """(n,) of scaled requests (n, D)."""
        score: Array = features(x) @ self.weights
        if len(self.amounts):
            away = ((x[:, None] - self.centres) ** 2).sum(axis=2)
            score += np.exp(-away / (2 * WIDTH**2)) @ self.amounts
        return score

    def score(self, jump: Jump) -> float:
        """A jump's."""
        return float(self.scores(self.scaled(values_of(jump)[None]))[0])

    def scaled(self, values: Array) -> Array:
        """(n, D) of SI values: -1 to 1 over their ranges."""
        low, high = self.ends
        scaled: Array = 2 * (values - low) / (high - low) - 1
        return scaled

    def corrected(self, x: Array, feasible: bool) -> Feasible:
        """With a scaled request (D,) that was planned or refused; itself if it knew."""
        target = SURE if feasible else -SURE
        score = float(self.scores(x[None])[0])
        if score * target > 0:
            return self
        return replace(
            self,
            centres=np.vstack([self.centres, x])[-_MOST_SEEN:],
            amounts=np.append(self.amounts, target - score)[-_MOST_SEEN:],
        )


def features(x: Array) -> Array:
    """(n, F) phi of scaled requests (n, D)."""
    ones = np.ones((len(x), 1))
    return np.hstack([ones, x])[:, _products(x.shape[1])].prod(axis=2)


@cache
def _products(size: int) -> IntArray:
    """(F, DEGREE) columns that are multiplied; 0 is the one of ones."""
    chosen = combinations_with_replacement(range(size + 1), DEGREE)
    sided = [column + 1 for column in _SIDED]
    return np.array([c for c in chosen if sum(c.count(column) for column in sided) % 2 == 0])


def values_of(jump: Jump) -> Array:
    """(D,) SI."""
    return np.array([getattr(jump, name) for name in COMPONENTS], dtype=float)


def feasible_of(robot: Robot) -> Feasible | None:
    """The robot's classifier; None: it has no table of solved jumps."""
    outcomes = outcomes_of(robot)
    return None if outcomes is None else fitted(robot, outcomes)


def begins_from_table(jump: Jump, tuning: Tuning) -> bool:
    """Whether the robot has a table of solved jumps from which this one begins."""
    return leads_to(jump, tuning) and outcomes_of(load_robot(jump.robot)) is not None


@lru_cache(maxsize=16)
def fitted(robot: Robot, outcomes: Outcomes) -> Feasible:
    """The classifier of what became of a robot's jumps, without corrections."""
    ends = np.array([getattr(robot.file.task, name) for name in COMPONENTS], dtype=float).T
    plain = Feasible(ends, np.empty(0), np.empty((0, len(COMPONENTS))), np.empty(0))
    x = plain.scaled(np.vstack([outcomes.requests, outcomes.refused]))
    planned = np.arange(len(x)) < len(outcomes.requests)
    return replace(plain, weights=_regression(features(x), planned.astype(float)))


def _regression(phi: Array, y: Array) -> Array:
    """(F,) weights of features (n, F) by Newton's method, of which y (n,) are 0 or 1."""
    ridge = np.full(phi.shape[1], RIDGE)
    w = np.zeros(phi.shape[1])
    for _ in range(_STEPS):
        chance = expit(phi @ w)
        hessian = (phi.T * (chance * (1 - chance))) @ phi + np.diag(ridge)
        step = np.linalg.solve(hessian, phi.T @ (y - chance) - ridge * w)
        w += step * min(1.0, 3.0 / max(float(np.abs(phi @ step).max()), 1.0))
        if np.abs(step).max() < _CHANGE:
            break
    return w
