"""Which jumps can be planned, guessed in a fraction of a millisecond from jumps that were planned.

A request x has displacement and the limits that stop jumps most (`LIMITS`), each scaled over its
range. The score of x is the logarithm of the odds that it can be planned,

    score(x) = w · phi(x) + sum_k a_k exp(-|x - x_k|^2 / (2 WIDTH^2)) ,

where phi are all products of up to `DEGREE` of the numbers of x that stay when left and right
change places: twist and lateral together come an even number of times. The weights w of each robot
are fitted to sampled jumps by `python -m benchmarks.feasible`, which writes `assets/feasible.json`.
None ships at present: nothing is known of any robot.
The second part is what was seen since: where a jump was planned, or refused, against the score.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from itertools import combinations_with_replacement
from typing import Any

import numpy as np

from llsrbm.arrays import Array, IntArray
from llsrbm.installed import assets_directory
from llsrbm.planning.problem.placement import limits_of
from llsrbm.request.jump import COMPONENTS, Jump
from llsrbm.robots.numbers_key import numbers_key
from llsrbm.robots.robot import Robot

LIMITS: Mapping[str, tuple[float, float]] = {
    "torque_share": (0.2, 1.1),
    "speed_share": (0.2, 1.2),
    "friction": (0.1, 1.0),
    "flight_max": (0.32, 0.9),
    "clearance": (0.0, 0.3),
}
"""Limits of which samples differ, with the ends of what was sampled, SI."""

DEGREE = 3
WIDTH = 0.15  # of half a range: how far around it a jump that was seen counts
SURE = 2.0  # score to which a jump that was seen is corrected: odds of seven to one
_MOST_SEEN = 200  # corrections; the oldest are forgotten
_POINTS = 61  # along a slider
_SIDED = [COMPONENTS.index("twist"), COMPONENTS.index("lateral")]  # change their sign in a mirror


@dataclass(frozen=True, eq=False)
class Track:
    """Chances along one number of a request, the others as they are."""

    values: Array  # (n,) SI, from the lowest to the highest that may be asked
    scores: Array  # (n,) logarithms of the odds

    @property
    def intervals(self) -> tuple[tuple[float, float], ...]:
        """Ends of what can be planned, more likely than not, from the lowest on; SI."""
        can = self.scores > 0
        changes = np.flatnonzero(can[1:] != can[:-1])
        before, after = self.scores[changes], self.scores[changes + 1]
        share = before / (before - after)
        crossings = self.values[changes] + share * (self.values[changes + 1] - self.values[changes])
        ends = [*([self.values[0]] if can[0] else []), *crossings]
        ends += [self.values[-1]] if can[-1] else []
        return tuple((float(a), float(b)) for a, b in zip(ends[::2], ends[1::2], strict=True))


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

    def scaled(self, values: Array) -> Array:
        """(n, D) of SI values: -1 to 1 over their ranges, limits no further than was sampled."""
        low, high = self.ends
        scaled: Array = 2 * (values - low) / (high - low) - 1
        scaled[:, len(COMPONENTS) :] = scaled[:, len(COMPONENTS) :].clip(-1.0, 1.0)
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


def ends_of(robot: Robot) -> Array:
    """(2, D) lowest and highest of the request and of `LIMITS`, SI."""
    ranges = [getattr(robot.file.task, name) for name in COMPONENTS]
    return np.array([*ranges, *LIMITS.values()], dtype=float).T


def values_of(jump: Jump, limits: Mapping[str, float], robot: Robot) -> Array:
    """(D,) SI."""
    own = _own_limits(robot)
    request = [getattr(jump, name) for name in COMPONENTS]
    return np.array([*request, *(limits.get(name, own[name]) for name in LIMITS)], dtype=float)


@lru_cache(maxsize=16)
def feasible_of(robot: Robot) -> Feasible | None:
    """The robot's classifier as it ships; None: there is none, or its numbers have changed."""
    data: dict[str, Any] = _file().get(robot.name, {})
    if data.get("robot") != numbers_key(robot):
        return None
    return made(robot, np.array(data["weights"]))


def made(robot: Robot, weights: Array) -> Feasible:
    """A robot's classifier of these weights, without corrections."""
    ends = ends_of(robot)
    return Feasible(ends, weights, np.empty((0, ends.shape[1])), np.empty(0))


def why_unknown(jump: Jump, limits: Mapping[str, float], robot: Robot) -> str:
    """Why nothing is known of a request, as half a sentence; "": it is."""
    plain = Jump(robot=jump.robot)
    if jump.stones:
        return "with feet landing elsewhere"
    names = {*plain.as_dict()} - {*COMPONENTS, "model", "arms"}
    if any(getattr(jump, name) != getattr(plain, name) for name in names):
        return "of this type of jump"
    if jump.model != plain.model:
        return "with this model"
    if robot.arms and jump.arms != plain.arms:
        return "with the arms held"
    if feasible_of(robot) is None:
        return "of this robot"
    own = _own_limits(robot)
    others = sorted(name for name in limits if name not in LIMITS and limits[name] != own[name])
    return f"with another {others[0].replace('_', ' ')}" if others else ""


def learned(
    feasible: Feasible, jump: Jump, limits: Mapping[str, float], robot: Robot, *, planned: bool
) -> Feasible:
    """The classifier corrected by a request that was planned or refused, where it did not know."""
    if why_unknown(jump, limits, robot):
        return feasible
    return feasible.corrected(feasible.scaled(values_of(jump, limits, robot)[None])[0], planned)


def tracks(
    jump: Jump, limits: Mapping[str, float], robot: Robot, feasible: Feasible | None = None
) -> dict[str, Track]:
    """Field of `COMPONENTS` -> what can be planned along it; empty where `why_unknown`.

    `feasible`: with what was seen; None: as it ships.
    """
    feasible = feasible or feasible_of(robot)
    if feasible is None or why_unknown(jump, limits, robot):
        return {}
    low, high = feasible.ends[:, : len(COMPONENTS)]
    grids = np.linspace(low, high, _POINTS)
    values = np.tile(values_of(jump, limits, robot), (len(COMPONENTS), _POINTS, 1))
    for place in range(len(COMPONENTS)):
        values[place, :, place] = grids[:, place]
    flat = values.reshape(-1, values.shape[-1])
    scores = feasible.scores(feasible.scaled(flat)).reshape(len(COMPONENTS), _POINTS)
    return {name: Track(grids[:, k], scores[k]) for k, name in enumerate(COMPONENTS)}


@lru_cache(maxsize=16)
def _own_limits(robot: Robot) -> dict[str, float]:
    return {name: value for name, (_, value) in limits_of(robot).items()}


@cache
def _file() -> dict[str, Any]:
    path = assets_directory() / "feasible.json"
    if not path.exists():
        return {}
    return json.loads(path.read_text(encoding="utf-8"))
