"""Surroundings of the robot: the ground, what it jumps from, over or onto, and a board.

The lowest place is on the ground, every other on a block: the start on one called "block", a
landing on a "box", a foot that lands higher than the others on a "stone". A block stands from the
start, as large as the feet of the lower places, the planned trunk and the legs leave room for.
Where there is no room for one under all feet of its place, it comes in mid-flight, or goes then if
it is the start's: `Surroundings.in_mid_flight` says so. A board is slid onto the last landing
surface in mid-flight.

A hurdle stands on the ground. Beside a gap lie two blocks, the ground as far below them as the gap
is deep. A robot that touches a hurdle has not jumped over it.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from llsrbm.arrays import Array, BoolArray
from llsrbm.errors import InputError
from llsrbm.mechanics import (
    turns_about_z,
)
from llsrbm.motion.block import Block
from llsrbm.motion.footprints import MARGIN, ROOM, Rectangle, around, avoiding, common, meet
from llsrbm.motion.grounds import place_headings
from llsrbm.motion.plan import Plan
from llsrbm.motion.reaching import feet_inside, links_inside, trunk_inside
from llsrbm.motion.sampling import foothold_knots, resample
from llsrbm.request.obstacle import Obstacle
from llsrbm.request.scenario import Scenario
from llsrbm.request.slopes import gradients, normals
from llsrbm.robots.feet import foot_contacts
from llsrbm.robots.robot import Robot

SLOPING = 0.08  # m of a block that slopes around the feet: its upper edge stands out
THICKER = 0.05  # m that it reaches into the ground
# Where the edge between feet beside a block and feet on it may be, as shares of their distance: in
# the middle, or so far that a trunk leaning over it before lift-off has room.
EDGES = (0.5, 0.8)
STEP = 0.04  # m of a stone around its foot, where other feet of its place leave as much
BOARD = 2.0  # m, length and width of a board on the ground: wherever the robot lands, it lies there
_DIGITS = 4  # of a place's height, m: beyond are the solver's defects
_DEEP, _WIDE = 1.0, 100.0  # m, of the block that stands for the ground
TO_SPARE = 0.01  # m between the planned feet and a board that slides in under them


@dataclass(frozen=True)
class Surroundings:
    """Everything a robot can touch: the ground at height `ground`, m, and blocks."""

    ground: float
    blocks: tuple[Block, ...]

    @property
    def solids(self) -> tuple[Block, ...]:
        """The ground, as a block, and the blocks."""
        centre = np.array([0.0, 0.0, self.ground - _DEEP / 2])
        return (Block("ground", centre, np.array([_WIDE, _WIDE, _DEEP]), 0.0), *self.blocks)

    def later(self, seconds: float) -> Self:
        """The same by a clock that shows so much (s) when the plan begins."""
        moved = (
            replace(
                block,
                from_s=block.from_s + seconds if block.from_s > 0 else 0.0,
                until_s=block.until_s + seconds,
            )
            for block in self.blocks
        )
        return replace(self, blocks=tuple(moved))

    @property
    def in_mid_flight(self) -> str:
        """A sentence about boxes that do not stand all the time; "" if all do."""
        moving = [
            f"the {block.name} {'comes' if block.from_s > 0 else 'goes'}"
            for block in self.blocks
            if block.name != "board" and (block.from_s > 0 or block.until_s < math.inf)
        ]
        if not moving:
            return ""
        sentence = f"{', '.join(moving)} in mid-flight: the robot leaves it no room at the start."
        return sentence[0].upper() + sentence[1:]


def surroundings(robot: Robot, plan: Plan, scenario: Scenario) -> Surroundings:
    """The ground and the blocks among which a plan is followed. Raises `InputError`: the board is
    too thick, see `check_board`.
    """
    check_board(plan, scenario.board)
    radius = max(contact.radius for contact in foot_contacts(robot))
    places = _places(plan)
    last = places[-1]
    if plan.obstacle is not None:
        ground, blocks = _beside_obstacle(plan.obstacle, places)
    else:
        ground = _lowest_of(places)
        blocks = []
        for k, place in enumerate(places):
            if place.height > ground:
                number = f" {k}" if 0 < k < len(places) - 1 else ""
                name = f"box{number}" if k else "block"
                blocks.append(_standing(robot, plan, places, k, name, ground, radius))
    blocks += _stones(robot, plan, places, radius)
    if scenario.board > 0:
        goal = last.seen(last.points)
        # As large as the box under all feet, where there is one.
        on = [block for block in blocks if block.name == "box" and plan.obstacle is None]
        half = on[0].size[:2] / 2 if on else np.full(2, BOARD / 2)
        middle = _turn(last.heading).T @ on[0].centre[:2] if on else goal.mean(axis=0)
        board = Rectangle(middle - half, middle + half)
        if scenario.half_board:
            board = Rectangle(np.array([goal[:, 0].mean(), board.low[1]]), board.high)
        top = last.height + scenario.board
        blocks.append(_block(last, "board", board, last.height, top, _mid_flight(plan, last)))
    return Surroundings(ground=ground, blocks=tuple(blocks))


def ground_under(plan: Plan) -> float:
    """Height (m) of the ground under everything that a plan stands on and passes over."""
    places = _places(plan)
    if plan.obstacle is not None:
        return _beside_obstacle(plan.obstacle, places)[0]
    return _lowest_of(places)


def check_board(plan: Plan, height: float) -> None:
    """Check that a board of that thickness, m, slides in under the planned feet in mid-flight.
    Raises `InputError`: it does not; the message names the thickest that does.
    """
    if height == 0:
        return
    last = _places(plan)[-1]
    feet = resample(plan, np.array([_mid_flight(plan, last)])).contact_point[0]
    room = float((feet[:, 2] - last.top(feet)).min()) - TO_SPARE
    # Whole millimetres, rounded down, so that what the message names is accepted.
    largest = max(0.0, math.floor(1000 * room) / 1000)
    if not 0 <= height <= largest:
        raise InputError(
            f"board: expected 0 to {largest:.3f} m, what passes under the planned feet in "
            f"mid-flight, got {height:g} m"
        )


@dataclass(frozen=True, eq=False)
class _Place:
    """Where the robot stands: at the start, and after each flight."""

    points: Array  # (C, 3) m, contact points of the feet that stand there
    height: float  # m
    heading: float  # rad, of the edges of what stands there
    flight: int  # the phase that leads there, 0 for the start
    tilt: Array  # (2,) gradient of its surface

    @property
    def slopes(self) -> bool:
        """True if its surface does."""
        return bool(self.tilt.any())

    def top(self, points: Array) -> Array:
        """(n,) m: height of its surface at points (n, 2) or (n, 3) of the world."""
        return self.height + (points[:, :2] - self.points[:, :2].mean(axis=0)) @ self.tilt

    def seen(self, points: Array) -> Array:
        """(C, 2) m: points (C, 3) of the world seen from above, along the heading's axes."""
        return points[:, :2] @ _turn(self.heading)


def _places(plan: Plan) -> list[_Place]:
    """The schedule's places; the start's edges are along the first landing's heading."""
    schedule, knots = plan.schedule, foothold_knots(plan)
    corners = plan.contact_point.shape[1] // plan.foot_position.shape[1]
    contacts = plan.contact_point.reshape(len(plan.time), -1, corners, 3)
    points = [contacts[row[row >= 0], np.flatnonzero(row >= 0)].reshape(-1, 3) for row in knots]
    for leg, _, _, dz in plan.jump.stones:
        foot = schedule.legs.index(leg)
        points[-1][foot * corners : (foot + 1) * corners, 2] -= dz
    heading = place_headings(plan)
    tilts = gradients(plan.jump, schedule.places, heading)
    heading[0] = heading[1]
    height = [round(float(place[:, 2].mean()), _DIGITS) for place in points]
    if schedule.places == 1 and not np.any(tilts):  # to the digit
        height = [0.0, plan.jump.height]
    flights = [
        next(p for p, phase in enumerate(schedule) if phase.place == k and phase.feet) - 1
        for k in range(schedule.places + 1)
    ]
    flights[0] = 0
    return [_Place(*row) for row in zip(points, height, heading, flights, tilts, strict=True)]


def _standing(
    robot: Robot,
    plan: Plan,
    places: Sequence[_Place],
    k: int,
    name: str,
    ground: float,
    radius: float,
) -> Block:
    """The block under place `k`: from the start if feet, legs and trunk leave room for it."""
    place, corners = places[k], len(robot.corners)
    points, margin = place.seen(place.points), SLOPING if place.slopes else MARGIN
    lower = [place.seen(other.points) for other in places if _in_the_way(other, place)]
    narrow: Block | None = None
    for share in EDGES:
        footprint: Rectangle | None = around(points, margin)
        for beside in lower:
            apart = avoiding(points, beside.reshape(-1, corners, 2), radius, share)
            footprint = None if footprint is None or apart is None else common(footprint, apart)
        if footprint is not None:
            block = _block(place, name, footprint, ground, place.height)
            on_feet, until_half_way = _beside(plan, places, k)
            if (
                trunk_inside(robot, plan, block)
                or links_inside(robot, plan, block, on_feet)
                or feet_inside(plan, block, _elsewhere(plan, places, k), radius)
            ):
                continue
            if not links_inside(robot, plan, block, until_half_way):
                return block
            # Rather a block that the plan's legs run into than one that is not there.
            narrow = narrow or block
    if narrow is not None:
        return narrow
    block = _block(place, name, around(points, margin), ground, place.height)
    # Of any place but the last it has to make room for a lower one that follows, too.
    goes = any(_in_the_way(other, place) for other in places[k + 1 :])
    return replace(
        block,
        from_s=_mid_flight(plan, place) if k else 0.0,
        until_s=_highest(plan, places[k + 1].flight) if goes else math.inf,
    )


def _lowest_of(places: Sequence[_Place]) -> float:
    return min(_lowest(place) for place in places)


def _lowest(place: _Place) -> float:
    """m: of a place's surface, as far as its block goes."""
    if not place.slopes:
        return place.height
    footprint = around(place.seen(place.points), SLOPING)
    corners = np.array(
        [
            [x, y]
            for x in (footprint.low[0], footprint.high[0])
            for y in (footprint.low[1], footprint.high[1])
        ]
    )
    return float(place.top(corners @ _turn(place.heading).T).min())


def _in_the_way(other: _Place, place: _Place) -> bool:
    """Whether the block under a place has to leave room for feet in another one."""
    sloping = other.slopes or place.slopes
    return other is not place if sloping else other.height < place.height


def _stones(robot: Robot, plan: Plan, places: Sequence[_Place], radius: float) -> Iterator[Block]:
    """Blocks under single feet of the last place: from the start if the robot leaves them room."""
    place, start, corners = places[-1], places[-2], len(robot.corners)
    feet = place.seen(place.points).reshape(-1, corners, 2)
    for leg, _, _, dz in plan.jump.stones:
        if not dz:
            continue
        foot = plan.schedule.legs.index(leg)
        own, others = feet[foot], np.delete(feet, foot, axis=0).reshape(-1, 2)
        apart = np.abs(others[:, None] - own).max(axis=-1).min() / 2
        footprint = around(own, float(min(radius + STEP, apart)))
        block = _block(place, f"stone {leg}", footprint, place.height, place.height + dz)
        before, until_half_way = _beside(plan, places, len(places) - 1)
        room = radius + ROOM
        if (
            meet(place.seen(start.points), footprint.low - room, footprint.high + room)
            or trunk_inside(robot, plan, block)
            or links_inside(robot, plan, block, before | until_half_way)
        ):
            block = replace(block, from_s=_mid_flight(plan, place))
        yield block


def _beside(plan: Plan, places: Sequence[_Place], k: int) -> tuple[BoolArray, BoolArray]:
    """(N+1,) knots beside place `k` on the feet of others, and with the half of the flight."""
    flight = places[max(k, 1)].flight
    if k:
        return plan.phase < flight, plan.time < _mid_flight(plan, places[k])
    return plan.phase > flight, plan.time > _highest(plan, flight)


def _elsewhere(plan: Plan, places: Sequence[_Place], k: int) -> BoolArray:
    """(N+1,) knots in flights of a route between two other places than `k`."""
    flights = [place.flight for place in places]
    flights[0] = -1  # nothing leads to the start
    beside = {flights[k], *flights[k + 1 : k + 2]}
    return np.isin(plan.phase, [flight for flight in flights if flight not in beside])


def _beside_obstacle(obstacle: Obstacle, places: Sequence[_Place]) -> tuple[float, list[Block]]:
    """The height of the ground, m, and the blocks of a jump over an obstacle across the x axis."""
    points = np.concatenate([place.points for place in places])
    low, high = points.min(axis=0) - MARGIN, points.max(axis=0) + MARGIN
    middle = (obstacle.near + obstacle.far) / 2
    before, beyond = places[0].height, places[0].height
    for place in places:  # on either side they are at one height: the planner saw to it
        if (place.points[:, 0] > middle).any():
            beyond = place.height
    ground = min(before, beyond, obstacle.height) + 0.0  # no negative zero

    def box(name: str, start: float, end: float, top: float, *, untouched: bool = False) -> Block:
        return Block(
            name=name,
            centre=np.array([(start + end) / 2, (low[1] + high[1]) / 2, (ground + top) / 2]),
            size=np.array([end - start, high[1] - low[1], top - ground]),
            yaw=0.0,
            untouched=untouched,
        )

    blocks = []
    if before > ground:
        blocks.append(box("block", low[0], obstacle.near, before))
    if obstacle.height > ground:
        top = obstacle.height
        blocks.append(box("hurdle", obstacle.near, obstacle.far, top, untouched=True))
    if beyond > ground:
        blocks.append(box("box", obstacle.far, max(high[0], obstacle.far + MARGIN), beyond))
    return ground, blocks


def _mid_flight(plan: Plan, place: _Place) -> float:
    return float(plan.phase_start[[place.flight, place.flight + 1]].mean())


def _highest(plan: Plan, phase: int) -> float:
    """When in a flight the lowest foot is highest, s: long before the middle of a deep one."""
    flight = np.flatnonzero(plan.phase == phase)
    lowest = plan.contact_point[flight, :, 2].min(axis=1)
    return float(plan.time[flight[lowest.argmax()]])


def _turn(heading: float) -> Array:
    return turns_about_z(heading)[:2, :2]


def _block(
    place: _Place,
    name: str,
    footprint: Rectangle,
    bottom: float,
    top: float,
    from_s: float = 0.0,
) -> Block:
    middle = _turn(place.heading) @ (footprint.low + footprint.high) / 2
    size = footprint.high - footprint.low
    block = Block(
        name=name,
        centre=np.array([*middle, (bottom + top) / 2]),
        size=np.array([*size, top - bottom]),
        yaw=place.heading,
        from_s=from_s,
    )
    if not place.slopes:
        return block
    surface = np.array([*middle, place.top(middle[None])[0] + top - place.height])
    along = place.tilt @ _turn(place.heading)
    thick = top - bottom + THICKER
    return replace(
        block,
        centre=surface - normals(place.tilt) * thick / 2,
        size=np.array([*(size * np.sqrt(1 + along**2)), thick]),
        tilt=(float(place.tilt[0]), float(place.tilt[1])),
    )
