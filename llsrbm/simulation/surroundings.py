"""What stands around the robot: the ground, what it jumps from or onto, and a board."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from llsrbm.errors import InputError
from llsrbm.motion.plan import Phase, Plan
from llsrbm.motion.resample import resample
from llsrbm.robots.foot_contact import foot_contacts
from llsrbm.robots.robot import Robot
from llsrbm.scenario import Scenario

Array = NDArray[np.float64]

ROOM = 0.04  # m between an edge and feet that stand beside it: they rise before they move
MARGIN = 0.25  # m of landing box or start block around the feet: a robot may miss by that much
BOARD = 2.0  # m, length and width of a board on the ground: wherever the robot lands, it lies there
TO_SPARE = 0.01  # m between the planned feet and a board that slides in under them


@dataclass(frozen=True, eq=False)
class Block:
    """A box that stands in the world for a while.

    Attributes:
        name: what it is.
        centre: (3,) m, world frame; size: (3,) m, full lengths along its own axes.
        yaw: rad, of its own axes about the vertical.
        from_s, until_s: when it stands there, s.
    """

    name: str
    centre: Array
    size: Array
    yaw: float
    from_s: float = 0.0
    until_s: float = math.inf


@dataclass(frozen=True)
class Surroundings:
    """Everything a robot can touch: the ground at height `ground`, m, and blocks."""

    ground: float
    blocks: tuple[Block, ...]


def surroundings(robot: Robot, plan: Plan, scenario: Scenario) -> Surroundings:
    """What stands where while a plan is followed.

    A landing surface above the ground is a box, one below it is the ground, and the robot starts
    on a block. Where the robot, feet and what is between them, would stand on both, the box is slid
    in in mid-flight, or the block is drawn away when the feet are highest. The board is slid onto
    the landing surface in mid-flight.

    Raises:
        InputError: the board is too thick, see `check_board`.
    """
    check_board(plan, scenario.board)
    height = plan.jump.height
    middle = _mid_flight(plan)
    radius = max(contact.radius for contact in foot_contacts(robot))
    start, goal = (_in_heading(plan, plan.contact_point[k]) for k in (0, -1))
    blocks = []
    landing = _Rectangle(goal.mean(axis=0) - BOARD / 2, goal.mean(axis=0) + BOARD / 2)
    if height > 0:
        apart = _avoiding(goal, start, radius)
        landing = apart or _around(goal, MARGIN)
        blocks.append(_block(plan, "box", landing, 0.0, height, from_s=0.0 if apart else middle))
    elif height < 0:
        apart = _avoiding(start, goal, radius)
        base = apart or _around(start, MARGIN)
        blocks.append(
            _block(plan, "block", base, height, 0.0, until_s=math.inf if apart else _highest(plan))
        )
    if scenario.board > 0:
        if scenario.half_board:
            behind = np.array([goal.mean(axis=0)[0], landing.low[1]])
            landing = _Rectangle(behind, landing.high)
        top = height + scenario.board
        blocks.append(_block(plan, "board", landing, height, top, from_s=middle))
    return Surroundings(ground=min(height, 0.0), blocks=tuple(blocks))


def check_board(plan: Plan, height: float) -> None:
    """Whether a board of that thickness, m, slides in under the planned feet in mid-flight.

    Raises:
        InputError: it does not; the message names the thickest that does.
    """
    if height == 0:
        return
    feet = resample(plan, np.array([_mid_flight(plan)])).contact_point[0]
    room = float(feet[:, 2].min()) - plan.jump.height - TO_SPARE
    # Whole millimetres, rounded down, so that what the message names is accepted.
    largest = max(0.0, math.floor(1000 * room) / 1000)
    if not 0 <= height <= largest:
        raise InputError(
            f"board: expected 0 to {largest:.3f} m, what passes under the planned feet in "
            f"mid-flight, got {height:g} m"
        )


@dataclass(frozen=True, eq=False)
class _Rectangle:
    """Seen from above, axes along the landing heading: corners `low` and `high`, (2,) m."""

    low: Array
    high: Array


def _mid_flight(plan: Plan) -> float:
    return float(plan.phase_start[[Phase.FLIGHT, Phase.LANDING]].mean())


def _highest(plan: Plan) -> float:
    """When in flight the lowest foot is highest: on a deep landing long before mid-flight."""
    flight = np.flatnonzero(plan.phase == Phase.FLIGHT)
    lowest = plan.contact_point[flight, :, 2].min(axis=1)
    return float(plan.time[flight[lowest.argmax()]])


def _heading(plan: Plan) -> Array:
    """(2, 2): R_world_heading, the heading that the robot lands with."""
    c, s = math.cos(plan.jump.twist), math.sin(plan.jump.twist)
    return np.array([[c, -s], [s, c]])


def _in_heading(plan: Plan, points: Array) -> Array:
    """(C, 2) m: points (C, 3) of the world seen from above, along the landing heading's axes."""
    seen: Array = points[:, :2] @ _heading(plan)
    return seen


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
    plan: Plan,
    name: str,
    footprint: _Rectangle,
    bottom: float,
    top: float,
    from_s: float = 0.0,
    until_s: float = math.inf,
) -> Block:
    middle = _heading(plan) @ (footprint.low + footprint.high) / 2
    return Block(
        name=name,
        centre=np.array([*middle, (bottom + top) / 2]),
        size=np.array([*(footprint.high - footprint.low), top - bottom]),
        yaw=plan.jump.twist,
        from_s=from_s,
        until_s=until_s,
    )
