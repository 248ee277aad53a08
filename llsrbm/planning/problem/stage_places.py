"""Where a stage's feet stand, and where its motion ends, of what is done of the request."""

from collections.abc import Sequence
from functools import reduce
from typing import Any

import casadi as ca
import numpy as np

from llsrbm.models.base import CentroidalModel
from llsrbm.ocp.lifting import Lifting
from llsrbm.planning.problem.foot_clearance import APART, ROOM
from llsrbm.planning.problem.layout import NEXT_SHORTFALL, SHIFT, SHORTFALL, SWING_NUMBERS, Layout
from llsrbm.planning.problem.roles import Role
from llsrbm.planning.problem.rotations import quat_product
from llsrbm.request.jump import COMPONENTS

_ROUND = 1e-4  # m, of the smooth maximum's corner


class StagePlaces:
    """Symbols of a stage of one role; where its feet stand and land, and where it all ends.

    World frame.

    Attributes:
        role, layout, model: what the stage is about.
        parameters: name -> symbols that stay fixed in a solve, or what they come to where less of
            the request is done.
        symbols: name -> this stage's variables; variables: all of them, states first.
        standing_feet: (3, L) m: where the feet stand in this phase, or stood last; shifted or not.
        standing_contacts: (3, C) m: their contact points; standing_yaw: (L,) rad, their headings.
        towards: (2, L) directions across the edge that flying feet cross, see `Task.towards`.
        tilt: (2, L) gradients of the surfaces on which the feet stand, or stood last.
        local: all of these in one column: parameters of a phase.
        correction: (3, 1) m2/s, base axes, parameter of the interval: see `Task.correction`; / m.
        rolled: (2, L) m, likewise, of bodies that turn over: see `Task.rolled`.
        own: parameters of the interval alone, in one column.
        lift: collects the intermediates derivatives run through.
    """

    def __init__(
        self, role: Role, layout: Layout, model: CentroidalModel, parameters: dict[str, ca.SX]
    ) -> None:
        self.role, self.layout, self.model = role, layout, model
        self.parameters = dict(parameters)
        names = (*layout.states(role), *layout.controls(role))
        self.symbols = {name: ca.SX.sym(name, layout.size(name, role)) for name in names}
        self.variables = ca.vertcat(*self.symbols.values())
        # Symbols of their own, so that phases can share their expressions.
        feet = ca.SX.sym("standing_feet", 3, layout.legs)
        contacts = ca.SX.sym("standing_contacts", 3, layout.contacts)
        self.standing_yaw = ca.SX.sym("standing_yaw", layout.legs)
        self.towards = self._given_towards = ca.SX.sym("towards", 2, layout.legs)
        self.tilt = ca.SX.sym("tilt", 2, layout.legs)
        places = ca.vec(feet), ca.vec(contacts), self.standing_yaw
        self.local = ca.vertcat(*places, ca.vec(self.towards), ca.vec(self.tilt))
        shift = ca.vertcat(self.shift, 0) if role.shifted else ca.SX.zeros(3)
        self.correction = ca.SX.sym("correction", 3)
        self.rolled = ca.SX.sym("rolled", 2, layout.legs if layout.turns else 0)
        self._swings = ca.SX.sym("swings", layout.legs, SWING_NUMBERS if layout.gives else 0)
        self.own = ca.vertcat(self.correction, ca.vec(self.rolled), ca.vec(self._swings))
        moved = ca.repmat(shift, 1, layout.legs)
        if layout.turns:
            moved += ca.vertcat(self.rolled, ca.SX.zeros(1, layout.legs))
        self.standing_feet = feet + moved
        self.standing_contacts = contacts + ca.kron(moved, ca.DM.ones(1, layout.corners))
        self.lift = Lifting(self.variables)
        self.intervals = role.intervals
        if role.has_shortfall:
            self._do_less()

    @property
    def shift(self) -> Any:
        """Shift of where feet land, (2, 1) m."""
        return self.symbols.get(SHIFT, ca.SX.zeros(2))

    def _do_less(self) -> None:
        """Put what follows from the request where it is with what is given up."""
        role, of = self.role, self.parameters
        done = of["asked"] - of["scale"] * self.symbols[SHORTFALL]
        self._now, self._then = self._poses(done), self._poses(of["reference"])
        self._turned = [now[0] - then[0] for now, then in zip(self._now, self._then, strict=True)]
        of["goal_position"] = self._moved(-1, of["goal_position"])
        half = self._turned[-1] / 2
        turn = ca.vertcat(ca.cos(half), 0, 0, ca.sin(half))
        of["goal_quat"] = quat_product(turn, of["goal_quat"])
        of["goal_velocity"] = _Rz(self._turned[-1]) @ of["goal_velocity"]
        if any(role.places_before):
            feet, corners = role.places_before, self.layout.corners
            contacts = np.repeat(feet, corners).tolist()
            self.standing_feet = self._all_moved(feet, self.standing_feet)
            self.standing_contacts = self._all_moved(contacts, self.standing_contacts)
            if self.layout.foot_coordinates > 3:
                turned = ca.vertcat(*(self._turned[place] for place in feet))
                self.standing_yaw = self.lift(self.standing_yaw + turned)
            self.tilt = self._all_turned(feet, self.tilt)
        self.towards = self._all_turned(role.places_after, self._given_towards)

    def _moved(self, place: int, point: Any) -> Any:
        """(3, 1) m: where a point of a place is, of which the parameters know where it was."""
        return _Rz(self._turned[place]) @ (point - self._then[place][1]) + self._now[place][1]

    def _all_turned(self, places: Sequence[int], directions: Any) -> Any:
        each = zip(places, ca.horzsplit(directions), strict=True)
        columns = [_Rz(self._turned[place])[:2, :2] @ direction for place, direction in each]
        return self.lift(ca.horzcat(*columns))

    def _all_moved(self, places: Sequence[int], points: Any) -> Any:
        each = zip(places, ca.horzsplit(points), strict=True)
        return self.lift(ca.horzcat(*(self._moved(place, point) for place, point in each)))

    @property
    def penalty(self) -> Any:
        """Cost of what is given up of the request."""
        if not self.role.chooses_shortfall:
            return ca.SX(0)
        return self.parameters["penalty"] * ca.sum1(self.symbols[NEXT_SHORTFALL])

    def ground_moved(self, leg: int) -> Any:
        """m: how far what a flying foot clears is above what the parameters say."""
        if not self.role.has_shortfall:
            return 0
        places = self.role.places_before, self.role.places_after
        before, after = (self._raised(each[leg]) for each in places)
        return before + (after - before) * self._swings[leg, 0]

    def edge_moved(self, leg: int) -> Any:
        """m along `towards`: likewise of the edge that it crosses."""
        if not self.role.has_shortfall:
            return 0
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

    def _contacts_in(self, poses: list[tuple[Any, Any]], places: tuple[int, ...]) -> Any:
        """(3, C) m: contact points, each in its foot's place."""
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
