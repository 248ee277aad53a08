"""What stands around the robot: the ground, what it jumps from or onto, and a board."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from llsrbm.errors import InputError
from llsrbm.mechanics import yaw
from llsrbm.motion.plan import Plan
from llsrbm.motion.sampling import foothold_knots, resample
from llsrbm.request.scenario import Scenario
from llsrbm.robots.foot_contact import foot_contacts
from llsrbm.robots.robot import Robot
from llsrbm.simulation.block import Block as Block
from llsrbm.simulation.obstacles import Standing, ground_and_blocks

Array = NDArray[np.float64]

ROOM = 0.04  # m between an edge and feet that stand beside it: they rise before they move
MARGIN = 0.25  # m of landing box or start block around the feet: a robot may miss by that much
BOARD = 2.0  # m, length and width of a board on the ground: wherever the robot lands, it lies there
_DIGITS = 4  # of a place's height, m: beyond are the solver's defects
TO_SPARE = 0.01  # m between the planned feet and a board that slides in under them


@dataclass(frozen=True)
class Surroundings:
    """Everything a robot can touch: the ground at height `ground`, m, and blocks."""

    ground: float
    blocks: tuple[Block, ...]


def surroundings(robot: Robot, plan: Plan, scenario: Scenario) -> Surroundings:
    """What stands where while a plan is followed.

    Over an obstacle see `llsrbm.simulation.obstacles`. Otherwise:

    The lowest place is on the ground, every other on a block: the start on one called "block", a
    landing on a "box". Where the robot, feet and what is between them, would stand on a block and
    beside it, the block is slid in in mid-flight, or drawn away when the feet are highest. The
    board is slid onto the last landing surface in mid-flight.

    Raises:
        InputError: the board is too thick, see `check_board`.
    """
    check_board(plan, scenario.board)
    radius = max(contact.radius for contact in foot_contacts(robot))
    places = _places(plan)
    last = places[-1]
    goal = last.seen(last.points)
    landing = _Rectangle(goal.mean(axis=0) - BOARD / 2, goal.mean(axis=0) + BOARD / 2)
    if plan.obstacle is not None:
        standing = [Standing(place.points, place.height) for place in places]
        ground, blocks = ground_and_blocks(plan.obstacle, standing, MARGIN)
    else:
        ground, blocks = min(place.height for place in places), []
        for k, place in enumerate(places):
            if place.height <= ground:
                continue
            footprint, from_s, until_s = _block_under(plan, places, k, radius)
            number = f" {k}" if 0 < k < len(places) - 1 else ""
            name = f"box{number}" if k else "block"
            blocks.append(_block(place, name, footprint, ground, place.height, from_s, until_s))
            if k == len(places) - 1:
                landing = footprint
    if scenario.board > 0:
        if scenario.half_board:
            behind = np.array([goal.mean(axis=0)[0], landing.low[1]])
            landing = _Rectangle(behind, landing.high)
        top = last.height + scenario.board
        from_s = _mid_flight(plan, last.flight)
        blocks.append(_block(last, "board", landing, last.height, top, from_s))
    return Surroundings(ground=ground, blocks=tuple(blocks))


def check_board(plan: Plan, height: float) -> None:
    """Whether a board of that thickness, m, slides in under the planned feet in mid-flight.

    Raises:
        InputError: it does not; the message names the thickest that does.
    """
    if height == 0:
        return
    last = _places(plan)[-1]
    feet = resample(plan, np.array([_mid_flight(plan, last.flight)])).contact_point[0]
    room = float(feet[:, 2].min()) - last.height - TO_SPARE
    # Whole millimetres, rounded down, so that what the message names is accepted.
    largest = max(0.0, math.floor(1000 * room) / 1000)
    if not 0 <= height <= largest:
        raise InputError(
            f"board: expected 0 to {largest:.3f} m, what passes under the planned feet in "
            f"mid-flight, got {height:g} m"
        )


@dataclass(frozen=True, eq=False)
class _Rectangle:
    """Seen from above, axes along a heading: corners `low` and `high`, (2,) m."""

    low: Array
    high: Array


@dataclass(frozen=True, eq=False)
class _Place:
    """Where the robot stands: at the start, and after each flight.

    Attributes:
        points: (c, 3) m, contact points of the feet that stand there.
        height: m; heading: rad, of the edges of what stands there.
        flight: the phase that leads there, 0 for the start.
    """

    points: Array
    height: float
    heading: float
    flight: int

    def seen(self, points: Array) -> Array:
        """(C, 2) m: points (C, 3) of the world seen from above, along the heading's axes."""
        seen: Array = points[:, :2] @ _turn(self.heading)
        return seen


def _places(plan: Plan) -> list[_Place]:
    """The schedule's places; the start's edges are along the first landing's heading."""
    schedule, knots = plan.schedule, foothold_knots(plan)
    corners = plan.contact_point.shape[1] // plan.foot_position.shape[1]
    each = np.arange(plan.contact_point.shape[1])
    points = [
        plan.contact_point[np.repeat(row, corners), each][np.repeat(row >= 0, corners)]
        for row in knots
    ]
    if schedule.places == 1:  # to the digit
        height, heading = [0.0, plan.jump.height], [plan.jump.twist] * 2
    else:
        height = [round(float(place[:, 2].mean()), _DIGITS) for place in points]
        base = [int(row.max()) for row in knots]
        heading = [float(angle) for angle in yaw(plan.base_quat)[base]]
        heading[0] = heading[1]
    flights = [
        next(p for p, phase in enumerate(schedule) if phase.place == k and phase.feet) - 1
        for k in range(schedule.places + 1)
    ]
    flights[0] = 0
    return [_Place(*row) for row in zip(points, height, heading, flights, strict=True)]


def _block_under(
    plan: Plan, places: list[_Place], k: int, radius: float
) -> tuple[_Rectangle, float, float]:
    """Of the block under place k: its top, from when and until when it stands, s."""
    place = places[k]
    points = place.seen(place.points)
    footprint: _Rectangle | None = None
    from_s, until_s = 0.0, math.inf
    for j, other in enumerate(places):
        if j == k:
            continue
        apart = _avoiding(points, place.seen(other.points), radius)
        if apart is not None:
            footprint = apart if footprint is None else _common(footprint, apart)
        elif j < k:
            from_s = _mid_flight(plan, place.flight)
        else:
            until_s = _highest(plan, places[k + 1].flight)
    return footprint or _around(points, MARGIN), from_s, until_s


def _mid_flight(plan: Plan, flight: int) -> float:
    return float(plan.phase_start[[flight, flight + 1]].mean())


def _highest(plan: Plan, phase: int) -> float:
    """When in a flight the lowest foot is highest: on a deep landing long before mid-flight."""
    flight = np.flatnonzero(plan.phase == phase)
    lowest = plan.contact_point[flight, :, 2].min(axis=1)
    return float(plan.time[flight[lowest.argmax()]])


def _turn(heading: float) -> Array:
    """(2, 2): R_world_heading."""
    c, s = math.cos(heading), math.sin(heading)
    return np.array([[c, -s], [s, c]])


def _common(one: _Rectangle, other: _Rectangle) -> _Rectangle:
    return _Rectangle(np.maximum(one.low, other.low), np.minimum(one.high, other.high))


def _around(points: Array, margin: float) -> _Rectangle:
    return _Rectangle(points.min(axis=0) - margin, points.max(axis=0) + margin)


def _avoiding(points: Array, others: Array, radius: float) -> _Rectangle | None:
    """A rectangle around `points` (C, 2), as wide as `MARGIN`, where no foot of `others` stands.

    None if even the feet on `points` themselves, of that radius, leave no room for the robot that
    stands on the others.
    """
    low, high = points.min(axis=0) - radius, points.max(axis=0) + radius
    apart = radius + ROOM
    if _inside(_between(others), low, high, apart).any():
        return None
    wide = _around(points, MARGIN)
    for axis, across in ((0, 1), (1, 0)):
        beside = (others[:, across] > low[across] - apart) & (
            others[:, across] < high[across] + apart
        )
        where = others[beside, axis]
        before, after = where[where < low[axis]], where[where > high[axis]]
        # An edge between start and landing is in the middle: feet rise and land beside it.
        low[axis] = max(wide.low[axis], (before.max(initial=-np.inf) + radius + low[axis]) / 2)
        high[axis] = min(wide.high[axis], (after.min(initial=np.inf) - radius + high[axis]) / 2)
    # An edge that grew towards the margin may have come under the robot at a corner.
    if _inside(_between(others), low, high, apart).any():
        return None
    return _Rectangle(low, high)


def _between(points: Array) -> Array:
    """Points (C, 2) and more on the lines between any two of them: what a robot stands over."""
    share = np.linspace(0.0, 1.0, 9)[:, None, None, None]
    lines: Array = points[:, None] * (1 - share) + points[None] * share
    return lines.reshape(-1, 2)


def _inside(points: Array, low: Array, high: Array, radius: float) -> NDArray[np.bool_]:
    """(C,) whether a foot of that radius at a point reaches into a rectangle."""
    return np.asarray(((points > low - radius) & (points < high + radius)).all(axis=1))


def _block(
    place: _Place,
    name: str,
    footprint: _Rectangle,
    bottom: float,
    top: float,
    from_s: float = 0.0,
    until_s: float = math.inf,
) -> Block:
    middle = _turn(place.heading) @ (footprint.low + footprint.high) / 2
    return Block(
        name=name,
        centre=np.array([*middle, (bottom + top) / 2]),
        size=np.array([*(footprint.high - footprint.low), top - bottom]),
        yaw=place.heading,
        from_s=from_s,
        until_s=until_s,
    )
