"""The elastic problem: how much of a request is done is a variable, its shortfall a cost.

From the first knot at which a foot swings, shares of the robot's ranges by which the request is
given up are states with zero dynamics, chosen as controls in the interval before. Less is done,
never more. Where the feet land, where the motion ends and what feet clear follow from them; the
cost is their sum, so that nothing is given up that can be done, and of several components as few
as will do.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property, reduce
from typing import Any

import casadi as ca
import numpy as np

from llsrbm.arrays import Array
from llsrbm.models.base import CentroidalModel
from llsrbm.planning.problem.foot_clearance import (
    APART,
    FAR,
    ROOM,
    edge_ranges,
    ground_share,
)
from llsrbm.planning.problem.layout import Layout
from llsrbm.planning.problem.roles import Role
from llsrbm.planning.problem.rotations import quat_product
from llsrbm.planning.problem.stage import Stage
from llsrbm.planning.problem.stones import offsets
from llsrbm.planning.problem.task import Task
from llsrbm.request.jump import COMPONENTS

SHORTFALL = "shortfall"  # state: shares of the ranges by which the request's components are reduced
NEXT_SHORTFALL = "next_shortfall"  # control: what they become
_OWN = 3  # numbers of a leg that each interval has for itself, see `swing_numbers`
_ROUND = 1e-4  # m, of the smooth maximum's corner


@dataclass(frozen=True)
class ElasticRole(Role):
    """Kind of a knot's stage, with the places of its feet.

    Attributes:
        places_before, places_after: (L,) place in which each foot stands, or stood last; stands, or
            stands next.
        has_shortfall: whether what is given up is known, a state.
        chooses_shortfall: whether it is chosen over the interval that starts here.
    """

    places_before: tuple[int, ...] = ()
    places_after: tuple[int, ...] = ()
    has_shortfall: bool = False
    chooses_shortfall: bool = False


@dataclass(frozen=True)
class ElasticLayout(Layout):
    """Names, sizes and places of all variables, with what is given up.

    Attributes:
        places_before, places_after: (P, L) places, see `ElasticRole`.
    """

    places_before: tuple[tuple[int, ...], ...] = ()
    places_after: tuple[tuple[int, ...], ...] = ()
    elastic = True

    @classmethod
    def around(cls, layout: Layout, task: Task) -> ElasticLayout:
        """Layout around another one's variables and the places in a task's schedule."""
        own = {field.name: getattr(layout, field.name) for field in fields(Layout)}
        before, after = (
            tuple(tuple(row) for row in places.tolist())
            for places in (task.places_before, task.places_after)
        )
        return cls(**own, places_before=before, places_after=after)

    @property
    def name(self) -> str:
        """With its kind, for names of files."""
        return f"{super().name}-elastic"

    @property
    def displacements(self) -> int:
        """K, of the schedule."""
        return max(map(max, self.places_after))

    @property
    def own_numbers(self) -> int:
        """Parameters that each interval has for itself."""
        return super().own_numbers + _OWN * self.legs

    @cached_property
    def roles(self) -> tuple[Role, ...]:
        """(N + 1) roles."""
        first = next(p for p, row in enumerate(self.stands) if not all(row))
        return tuple(
            ElasticRole(
                **{field.name: getattr(role, field.name) for field in fields(Role)},
                places_before=self.places_before[role.phase],
                places_after=self.places_after[role.phase],
                has_shortfall=role.phase >= first,
                chooses_shortfall=role.phase == first - 1 and role.last,
            )
            for role in super().roles
        )

    def size(self, name: str, role: Role) -> int:
        """Scalars of the variable called `name` at a knot of that role."""
        return len(COMPONENTS) if name in (SHORTFALL, NEXT_SHORTFALL) else super().size(name, role)

    def states(self, role: Role) -> tuple[str, ...]:
        """Names of the states at a knot of that role."""
        assert isinstance(role, ElasticRole)
        return (*super().states(role), *((SHORTFALL,) if role.has_shortfall else ()))

    def controls(self, role: Role) -> tuple[str, ...]:
        """Names of the controls over the interval that starts at a knot of that role."""
        assert isinstance(role, ElasticRole)
        return (*super().controls(role), *((NEXT_SHORTFALL,) if role.chooses_shortfall else ()))


def elastic_sizes(layout: ElasticLayout) -> dict[str, int]:
    """Name -> number of scalars of the parameters that plain problems do not have."""
    n = len(COMPONENTS)
    each = n * layout.displacements
    sizes = {"asked": n, "reference": n, "scale": n, "penalty": 1, "fixed": each, "follows": each}
    return sizes | {"stones": 3 * layout.legs}


def elastic_parameters(layout: ElasticLayout, task: Task) -> dict[str, Array]:
    """Name -> value of the parameters that plain problems do not have.

    `asked`: the request's components. `reference`: those of the jump that the task's other numbers
    are of. `scale`: what a component changes by when a whole range is given up. `penalty`: of that.
    `fixed`, `follows`: of each displacement what the jump type says, and 1 where the request does.
    `stones`: how far each foot lands beside its default in the last place.
    """
    own = task.robot.file.task
    whole = np.array([getattr(task.requested or task.jump, name) for name in COMPONENTS])
    ranges = np.array([high - low for low, high in (getattr(own, name) for name in COMPONENTS)])
    rows = task.displacement or (None,) * layout.displacements
    given = [[getattr(row, name, None) for name in COMPONENTS] for row in rows]
    return {
        "asked": whole,
        "reference": np.array([getattr(task.jump, name) for name in COMPONENTS]),
        "scale": np.sign(whole) * np.where(ranges > 0, ranges, 1.0),
        "penalty": np.ones(1),
        "fixed": np.array([[value or 0.0 for value in row] for row in given]),
        "follows": np.array([[float(value is None) for value in row] for row in given]),
        "stones": offsets(task.jump.stones, task.robot),
    }


def swing_numbers(layout: ElasticLayout, task: Task) -> Array:
    """(N, 3 L) of each interval: how what feet clear moves with what is given up.

    Of each leg the share of the landing surface's rise that its foot clears, and whether an edge
    bounds it from above, before the foot is up, and from below, on its way down.
    """
    share = np.zeros((layout.total, layout.legs))
    progress = layout.swing_progress[0][:-1]
    for phase in range(layout.phases):
        here = layout.phase[:-1] == phase
        start, goal = (
            task.footholds_before(phase).feet[:, 2],
            task.footholds_after(phase).feet[:, 2],
        )
        share[here] = ground_share(start, goal, task.swing_share(phase, progress[here]))
    low, high = edge_ranges(task, layout)
    numbers = [np.nan_to_num(share), high[:-1] < FAR, low[:-1] > -FAR]
    return np.concatenate(numbers, axis=1).astype(float)


class ElasticStage(Stage):
    """Symbolic quantities of one role of the elastic problem."""

    role: ElasticRole
    layout: ElasticLayout

    def __init__(
        self,
        role: ElasticRole,
        layout: ElasticLayout,
        model: CentroidalModel,
        parameters: dict[str, ca.SX],
    ) -> None:
        super().__init__(role, layout, model, dict(parameters))
        self._swings = ca.SX.sym("swings", layout.legs, _OWN)
        if not role.has_shortfall:
            return
        of = self.parameters
        done = of["asked"] - of["scale"] * self.symbols[SHORTFALL]
        self._now, self._then = self._poses(done), self._poses(of["reference"])
        self._turned = [now[0] - then[0] for now, then in zip(self._now, self._then, strict=True)]
        last = self._now[-1]
        of["goal_position"] = _Rz(last[0]) @ of["start_position"] + last[1]
        half = self._turned[-1] / 2
        turn = ca.vertcat(ca.cos(half), 0, 0, ca.sin(half))
        of["goal_quat"] = quat_product(turn, of["goal_quat"])
        of["goal_velocity"] = _Rz(self._turned[-1]) @ of["goal_velocity"]
        if any(role.places_before):
            self.standing_feet = self.lift(self._placed_in(self._now, role.places_before))
            self.standing_contacts = self.lift(self._contacts_in(self._now, role.places_before))
            if layout.foot_coordinates > 3:
                headings = ca.vertcat(*(self._now[place][0] for place in role.places_before))
                self.standing_yaw = self.lift(of["phase0_yaw"] + headings)
        columns = [
            _Rz(self._turned[place])[:2, :2] @ self._given_towards[:, leg]
            for leg, place in enumerate(role.places_after)
        ]
        self.towards = self.lift(ca.horzcat(*columns))

    @property
    def own(self) -> Any:
        """Parameters of the interval alone, in one column."""
        return ca.vertcat(super().own, ca.vec(self._swings))

    @property
    def penalty(self) -> Any:
        """Cost of what is given up of the request."""
        if not self.role.chooses_shortfall:
            return ca.SX(0)
        return self.parameters["penalty"] * ca.sum1(self.symbols[NEXT_SHORTFALL])

    def ground_moved(self, leg: int) -> Any:
        """m: how far what a flying foot clears is above what the parameters say."""
        places = self.role.places_before, self.role.places_after
        before, after = (self._raised(each[leg]) for each in places)
        return before + (after - before) * self._swings[leg, 0]

    def edge_moved(self, leg: int) -> Any:
        """m along `towards`: likewise of the edge that it crosses."""
        (up, down), (was_up, was_down) = (
            self._edge(leg, self._now, self.towards),
            self._edge(leg, self._then, self._given_towards),
        )
        return self._swings[leg, 1] * (up - was_up) + self._swings[leg, 2] * (down - was_down)

    def _raised(self, place: int) -> Any:
        return self._now[place][1][2] - self._then[place][1][2]

    def _poses(self, moved: Any) -> list[tuple[Any, Any]]:
        """Heading, rad, and origin, (3, 1) m, of all places, of a request's components (4, 1)."""
        of, n = self.parameters, len(COMPONENTS)
        heading, origin = ca.SX(0), ca.SX.zeros(3)
        poses = [(heading, origin)]
        for k in range(self.layout.displacements):
            here = slice(n * k, n * (k + 1))
            step = of["fixed"][here] + of["follows"][here] * moved
            origin = origin + _Rz(heading) @ step[1:]
            heading = heading + step[0]
            poses.append((heading, self.lift(origin)))
        return poses

    def _placed_in(self, poses: list[tuple[Any, Any]], places: tuple[int, ...]) -> Any:
        """(3, L) m: each foot in its place."""
        feet = ca.reshape(self.parameters["phase0_feet"], 3, -1)
        each = (feet[:, leg] + self._aside(leg, p) for leg, p in enumerate(places))
        return ca.horzcat(*(_at(poses[p], foot) for p, foot in zip(places, each, strict=True)))

    def _contacts_in(self, poses: list[tuple[Any, Any]], places: tuple[int, ...]) -> Any:
        """(3, C) m: likewise of contact points."""
        points = ca.reshape(self.parameters["phase0_contacts"], 3, -1)
        each, corners = np.repeat(places, self.layout.corners), self.layout.corners
        found = (
            _at(poses[p], points[:, c] + self._aside(c // corners, p)) for c, p in enumerate(each)
        )
        return ca.horzcat(*found)

    def _aside(self, leg: int, place: int) -> Any:
        """(3, 1) m: how far a foot lands beside its default in a place."""
        if place < self.layout.displacements:
            return ca.SX.zeros(3)
        return self.parameters["stones"][3 * leg : 3 * leg + 3]

    def _edge(self, leg: int, poses: list[tuple[Any, Any]], towards: Any) -> tuple[Any, Any]:
        """m along a leg's direction: where its foot is to be before the edge, and beyond it.

        But for what does not change, as in `constraints.edge`.
        """
        t, legs = towards[:, leg], range(self.layout.legs)
        a, b = self.role.places_before[leg], self.role.places_after[leg]
        start, goal = (
            ca.mtimes(t.T, self._contacts_in(poses, (place,) * len(legs))[:2, :])
            for place in (a, b)
        )
        corners = self.layout.corners
        mine = slice(leg * corners, (leg + 1) * corners)
        before, beyond = _largest(start[mine]), -_largest(-goal[mine])
        if corners > 1:
            return before, beyond
        gaps = -_largest(-goal) - before, beyond - _largest(start)
        rooms = [_largest(ca.horzcat(ROOM, gap / 2 - APART)) for gap in gaps]
        return before + rooms[0], beyond - rooms[1]


def _largest(values: Any) -> Any:
    """The largest of (1, n), smooth."""
    return reduce(
        lambda a, b: (a + b + ca.sqrt((a - b) ** 2 + _ROUND**2)) / 2, ca.horzsplit(values)
    )


def _at(pose: tuple[Any, Any], point: Any) -> Any:
    return _Rz(pose[0]) @ point + pose[1]


def _Rz(angle: Any) -> Any:
    c, s = ca.cos(angle), ca.sin(angle)
    return ca.vertcat(ca.horzcat(c, -s, 0), ca.horzcat(s, c, 0), ca.horzcat(0, 0, 1))
