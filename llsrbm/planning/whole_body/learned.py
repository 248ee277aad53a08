"""Solved jumps of a robot: where the whole body's problem begins, if there are some nearby.

A table has requests x (twist, forward, lateral, height), scaled to -1 ... 1 over what the robot's
file allows, and of each the solution's variables and multipliers v. For a new request x the nearest
K give, by a linear regression that is weighted by nearness,

    v(x) = c0 + C (x_k - x)   with the least   sum_k exp(-(WIDTH d_k / d_K)^2) |v_k - v(x_k)|^2 ,

and c0 is where `Solver.follow` begins. Quaternions have no jumps of sign between neighbours: all of
them begin at 1, 0, 0, 0 and turn on without a break, past half a turn, too.

A table also has the requests that were looked at and refused: from both together the page's tint
and the atlas are made (`llsrbm.atlas`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from llsrbm.ocp.horizon import Iterate
from llsrbm.request.jump import COMPONENTS, Jump
from llsrbm.robots.robot import Robot

Array = NDArray[np.float64]

# Of inverse distances, local regressions and radial basis functions the latter two lose equally few
# jumps that are in no table, and a regression takes 0.5 ms, not 12.
NEIGHBOURS = 16
WIDTH = 1.5
RIDGE = 1e-3  # of slopes, against neighbours that lie in a plane


class Solved(NamedTuple):
    """A jump whose certificate holds."""

    jump: Jump
    solution: Iterate  # of its whole-body problem
    flight: float  # s without a foot on the ground
    torque_share: float  # largest share of the torque that a drive gives at its speed


class Refused(NamedTuple):
    """A jump of which no plan was found whose certificate holds."""

    jump: Jump
    stopped_by: str  # name of the constraint that is violated most, or of a check


@dataclass(frozen=True, eq=False)
class Outcomes:
    """Outcomes of the jumps that were looked at: n solved ones, m refused ones.

    Attributes:
        requests: (n, 4) rad and m, by `COMPONENTS`.
        flight, torque_share: (n,) as of `Solved`.
        refused: (m, 4) rad and m; stopped_by: of each, as of `Refused`.
    """

    requests: Array
    flight: Array
    torque_share: Array
    refused: Array
    stopped_by: tuple[str, ...]

    def refusals(self, robot: Robot) -> list[Refused]:
        """The jumps that were refused."""
        return list(map(Refused, _jumps(self.refused, robot), self.stopped_by))


@dataclass(frozen=True, eq=False)
class Learned:
    """Solutions of n jumps.

    Attributes:
        outcomes: of all jumps that were looked at; scale: (4,) half of each range.
        variables: (n, V); multipliers: (n, R), of all rows.
    """

    outcomes: Outcomes
    scale: Array
    variables: Array
    multipliers: Array

    @classmethod
    def of(cls, solved: Sequence[Solved], refused: Sequence[Refused], robot: Robot) -> Learned:
        """The table of some jumps."""
        ranges = np.array([getattr(robot.file.task, name) for name in COMPONENTS])
        outcomes = Outcomes(
            requests=_requests([each.jump for each in solved]),
            flight=np.array([each.flight for each in solved]),
            torque_share=np.array([each.torque_share for each in solved]),
            refused=_requests([each.jump for each in refused]),
            stopped_by=tuple(each.stopped_by for each in refused),
        )
        return cls(
            outcomes,
            scale=np.ptp(ranges, axis=1) / 2,
            variables=np.array([each.solution.variables for each in solved]),
            multipliers=np.array([each.solution.multipliers for each in solved]),
        )

    def solved(self, robot: Robot) -> list[Solved]:
        """The jumps that were solved."""
        found = self.outcomes
        solutions = map(Iterate, self.variables, self.multipliers)
        figures = found.flight.tolist(), found.torque_share.tolist()
        return list(map(Solved, _jumps(found.requests, robot), solutions, *figures))

    @property
    def sizes(self) -> tuple[int, int]:
        """Numbers of variables and of rows."""
        return self.variables.shape[1], self.multipliers.shape[1]

    def guess(self, jump: Jump) -> Iterate:
        """Where a jump begins; see above."""
        near, share = self._shares(np.array([getattr(jump, name) for name in COMPONENTS]))
        return Iterate(share @ self.variables[near], share @ self.multipliers[near])

    def _shares(self, x: Array) -> tuple[NDArray[np.intp], Array]:
        """(K,) which solutions, and (K,) how much of each."""
        away = (self.outcomes.requests - x) / self.scale
        distance = np.linalg.norm(away, axis=1)
        near = np.argsort(distance, kind="stable")[:NEIGHBOURS]
        furthest = max(float(distance[near[-1]]), np.finfo(float).tiny)
        weight = np.exp(-((WIDTH * distance[near] / furthest) ** 2))
        A = np.hstack([np.ones((len(near), 1)), away[near] / furthest])
        ridge = np.diag([0.0, *[RIDGE] * len(self.scale)])
        share: Array = np.linalg.solve((A.T * weight) @ A + ridge, A.T * weight)[0]
        return near, share


def _requests(jumps: Sequence[Jump]) -> Array:
    """(n, 4) what they ask for."""
    rows = [[getattr(jump, name) for name in COMPONENTS] for jump in jumps]
    return np.array(rows, dtype=float).reshape(-1, len(COMPONENTS))


def _jumps(requests: Array, robot: Robot) -> list[Jump]:
    """Jumps of a robot that ask for (n, 4)."""
    plain = Jump(robot=str(robot.path))
    return [
        replace(plain, **dict(zip(COMPONENTS, each, strict=True))) for each in requests.tolist()
    ]
