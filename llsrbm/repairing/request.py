"""The request that a part of a motion asks for: its jump, its schedule, its footholds.

The project's frame has its origin under the robot as it stands at the start. There a motion of
another frame is brought: so that its feet stand as near as they can to the robot's own.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from llsrbm.arrays import Array, IntArray
from llsrbm.errors import InputError
from llsrbm.mechanics import rotation_matrices, turns_about_z, yaw
from llsrbm.planning.problem.placement import place_task
from llsrbm.planning.problem.task import Footholds, Task, contact_points
from llsrbm.repairing.feet import feet_of
from llsrbm.repairing.frame import Frame, frame_between
from llsrbm.repairing.led import Led, Way
from llsrbm.repairing.part import NoJump, Part, merged
from llsrbm.repairing.phases import ContactPhase
from llsrbm.request.feet_order import order_of
from llsrbm.request.jump import IN_A_ROW, PLAIN, Jump
from llsrbm.request.jump_types import JumpType, load_type, names
from llsrbm.request.route import MOST, Landing
from llsrbm.request.stones import Stone
from llsrbm.robots.robot import Robot
from llsrbm.robots.schema import robot_files

LEVEL = 0.015  # m: what lands less high or deep lands on the same ground
ASIDE = 0.02  # m beside where it lands by itself, from which a foot's place is a stone of the jump
_DIGITS = 4  # of a jump's numbers, m and rad


@dataclass(frozen=True, eq=False)
class Request:
    """The request that a part of a motion amounts to.

    Attributes:
        part: of the motion; frame: the project's, in the file's.
        led: from where the motion stands, place by place, to where the plan is to stand.
        task: with the motion's own footholds in place of the robot's.
        sunk: (places,) m by which the motion's feet stand above their footholds.
    """

    part: Part
    frame: Frame
    led: Led
    task: Task
    sunk: Array

    @property
    def places_at_edges(self) -> IntArray:
        """(P + 1,) the place where the robot stands, or stood last, at the phases' edges."""
        places = self.part.places
        here = [places[k] if feet else places[k - 1] for k, feet in enumerate(self.part.feet)]
        return np.array([*here, places[-1]])

    @property
    def phases(self) -> tuple[ContactPhase, ...]:
        """Those of the part, as the schedule calls them."""
        both = zip(self.part.phases, self.task.schedule, strict=True)
        return tuple(replace(own, name=phase.name) for own, phase in both)


def request_of(part: Part, robot: Robot, share: float = 1.0) -> Request:
    """The request of a part of a motion, or of one that leads a share of its way and of its turn.

    Raises:
        NoJump: feet stand in an order of which there is no jump type; a body that turns over.
    """
    part, kind = _of_a_type(part, robot)
    places = part.footholds()
    middles, headings = stood(places, robot)
    headings = _whole_turns(part, headings)
    frame = Frame(float(headings[0]), np.array([*middles[0], places[0, :, 2].mean()]))
    own_way = Way(middles, headings)
    led = Led(own_way, own_way.shared(share))
    places, headings = led.points(places), led.to.headings
    height = places[..., 2].mean(axis=1) - frame.origin[2]
    # Feet that slide float as well, and tell no height.
    height[np.abs(height) < (np.inf if any(part.slides) else LEVEL)] = 0.0
    landings = [
        Landing(*_rounded([*ahead, rise, turn]))
        for ahead, rise, turn in zip(led.to.steps, np.diff(height), np.diff(headings), strict=True)
    ]
    jump = _jump(robot, kind, landings)
    task = place_task(jump, robot)
    feet = frame.points(places)
    sunk = feet[..., 2].mean(axis=1) - height
    feet[..., 2] = height[:, None]
    yaws = 0 * feet[..., 0]
    if len(robot.corners) > 1:
        yaws = _sole_yaws(part, robot) - frame.yaw + led.turns[:, None]
    own = tuple(
        _footholds(robot, feet[k], yaws[k], float(headings[k] - headings[0]), place.origin)
        for k, place in enumerate(task.places)
    )
    if len(landings) == 1:
        task = replace(task, jump=replace(jump, stones=_stones(task, feet[-1])))
    return Request(part, frame, led, replace(task, places=own), sunk)


def _of_a_type(part: Part, robot: Robot) -> tuple[Part, str]:
    """The jump type of a part; of one that has none, that of it without its short phases, or the
    order of these.
    """
    if part.flights > MOST:
        raise NoJump(f"it has {part.flights} flights in a row; expected at most {MOST}")
    for one in (part, merged(part)):
        for name, kind in names().items():
            if _plain(kind) and _feet(kind, robot, one.flights) == one.feet:
                return one, name
    own = merged(part)
    order = order_of(own.feet, robot.leg_names)
    if own.flights > 1:
        raise NoJump(
            f"its feet stand in an order of which there is no jump type with {own.flights} flights "
            f"({order})"
        )
    try:
        load_type(order).schedule(robot)
    except InputError as error:
        raise NoJump(f"its feet stand in an order that is no jump's: {error}") from error
    return own, order


def _plain(kind: JumpType) -> bool:
    """Whether jumps of a type are from rest to rest, over nothing, and do not turn over."""
    beside = {"roll", "pitch", "speed", "end_speed"} & set(kind.parameters)
    return not (beside or kind.obstacle or kind.displacement)


def _feet(kind: JumpType, robot: Robot, flights: int) -> tuple[tuple[str, ...], ...] | None:
    """Which feet stand in the phases of a type's jumps with so many flights; None: it has none."""
    hops = "hops" in kind.parameters
    if flights > 1 and not hops:
        return None
    try:
        schedule = kind.schedule(robot, Jump(hops=flights) if hops else Jump())
    except InputError:  # the robot lacks its feet
        return None
    return tuple(phase.feet for phase in schedule)


def stood(places: Array, robot: Robot) -> tuple[Array, Array]:
    """Where a robot stands whose feet stand in places (n, L, 3) m: (n, 2) m and (n,) rad.

    The turn and shift that bring its own feet there, but for as little as can be.
    """
    frames = [frame_between(robot.feet, feet) for feet in places]
    return np.array([each.origin[:2] for each in frames]), np.array([each.yaw for each in frames])


def _whole_turns(part: Part, headings: Array) -> Array:
    """Headings (n,) rad as the base has turned in between, whole turns counted."""
    motion = part.motion
    if part.turns_over:
        raise NoJump("the body turns over, and flips and rolls are planned, not repaired")
    base = yaw(motion.base_quat)
    found = headings.copy()
    own = part.places
    for place in range(1, len(headings)):
        stands = [k for k, at in enumerate(own) if at == place and part.feet[k]]
        at = np.interp(part.edges[[0, stands[-1] + 1]], motion.time, base)
        turned = headings[0] + at[1] - at[0]
        found[place] += 2 * np.pi * np.round((turned - headings[place]) / (2 * np.pi))
    return found


def _rounded(values: list[Any]) -> list[float]:
    return [round(float(value), _DIGITS) + 0.0 for value in values]


def _jump(robot: Robot, kind: str, landings: list[Landing]) -> Jump:
    known = robot_files().get(robot.name)
    name = robot.name if known == robot.path else str(robot.path)
    if len(landings) > 1:
        return Jump(robot=name, type=IN_A_ROW, route=tuple(landings))
    amounts: dict[str, Any] = {n: v for n, v in landings[0]._asdict().items() if v}
    return Jump(robot=name, type=kind if kind != IN_A_ROW else PLAIN, **amounts)


def _stones(task: Task, feet: Array) -> tuple[Stone, ...]:
    """Feet (L, 3) m that land beside where they would by themselves."""
    place = task.places[-1]
    aside = (feet - place.feet) @ turns_about_z(place.heading)
    return tuple(
        Stone(leg, *_rounded([x, y]))
        for leg, (x, y, _) in zip(task.schedule.legs, aside, strict=True)
        if np.hypot(x, y) > ASIDE
    )


def _footholds(robot: Robot, feet: Array, yaws: Array, heading: float, origin: Array) -> Footholds:
    contacts = contact_points(feet, yaws, np.array(robot.corners))
    return Footholds(feet, yaws, contacts, np.zeros((len(feet), 2)), heading, origin)


def _sole_yaws(part: Part, robot: Robot) -> Array:
    """(places, L) rad, file's frame: where soles look that stand, in the middle of that."""
    motion = part.motion
    found = np.empty((part.flights + 1, len(robot.legs)))
    for place in range(len(found)):
        own = [k for k, at in enumerate(part.places) if at == place and part.feet[k]]
        there = (motion.time >= part.edges[own[0]]) & (motion.time <= part.edges[own[-1] + 1])
        _, quat = feet_of(robot, motion.qpos[there])
        x, y = np.median(rotation_matrices(quat)[..., :2, 0], axis=0).T
        found[place] = np.arctan2(y, x)
    return found
