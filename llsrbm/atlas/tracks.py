"""Tracks of sliders: which values of a number can be planned, guessed from the robot's table."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from llsrbm.arrays import Array
from llsrbm.planning.problem.placement import limits_of
from llsrbm.planning.whole_body.feasible import Feasible, feasible_of, values_of
from llsrbm.request.jump import COMPONENTS, Jump
from llsrbm.robots.robot import Robot

_POINTS = 61  # along a slider


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


def why_unknown(jump: Jump, limits: Mapping[str, float], robot: Robot) -> str:
    """Why nothing is known of a request, as half a sentence; "": it is."""
    plain = Jump(robot=jump.robot)
    if jump.stones:
        return "with feet landing elsewhere"
    if jump.route:
        return "of a route"
    names = {*plain.as_dict()} - {*COMPONENTS, "model", "arms"}
    if any(getattr(jump, name) != getattr(plain, name) for name in names):
        return "of this type of jump"
    if jump.model != plain.model:
        return "with this model"
    if robot.arms and jump.arms != plain.arms:
        return "with the arms held"
    if feasible_of(robot) is None:
        return "of this robot"
    own = limits_of(robot)
    others = sorted(name for name, value in limits.items() if value != own[name][1])
    return f"with another {others[0].replace('_', ' ')}" if others else ""


def learned(
    feasible: Feasible, jump: Jump, limits: Mapping[str, float], robot: Robot, *, planned: bool
) -> Feasible:
    """The classifier corrected by a request that was planned or refused, where it did not know."""
    if why_unknown(jump, limits, robot):
        return feasible
    return feasible.corrected(feasible.scaled(values_of(jump)[None])[0], planned)


def tracks(
    jump: Jump, limits: Mapping[str, float], robot: Robot, feasible: Feasible | None = None
) -> dict[str, Track]:
    """Field of `COMPONENTS` -> what can be planned along it; empty where `why_unknown`.

    `feasible`: with what was seen; None: as the robot's table has it.
    """
    feasible = feasible or feasible_of(robot)
    if feasible is None or why_unknown(jump, limits, robot):
        return {}
    low, high = feasible.ends
    grids = np.linspace(low, high, _POINTS)
    values = np.tile(values_of(jump), (len(COMPONENTS), _POINTS, 1))
    for place in range(len(COMPONENTS)):
        values[place, :, place] = grids[:, place]
    flat = values.reshape(-1, len(COMPONENTS))
    scores = feasible.scores(feasible.scaled(flat)).reshape(len(COMPONENTS), _POINTS)
    return {name: Track(grids[:, k], scores[k]) for k, name in enumerate(COMPONENTS)}
