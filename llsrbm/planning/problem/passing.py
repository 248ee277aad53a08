"""An obstacle in the world, and how far jumps lead that take all feet beyond it."""

from __future__ import annotations

import numpy as np

from llsrbm.arrays import Array
from llsrbm.errors import InputError, NoFooting
from llsrbm.mechanics import turns_about_z
from llsrbm.planning.problem.task import Footholds
from llsrbm.request.jump import INCLINES, Jump
from llsrbm.request.jump_types import Displacement, JumpType
from llsrbm.request.jump_types import names as jump_types
from llsrbm.request.obstacle import Obstacle
from llsrbm.request.route import SLOPES
from llsrbm.robots.feet import foot_contacts
from llsrbm.robots.robot import Robot

RAMP = 0.04  # m, length of a ramp of the clearance profile: feet move about as far in an interval
# m that a foot stands from an edge beyond its own radius; our choice: feet of most disturbed jumps
# end within 15 mm of where they are planned to.
SCATTER = 0.02
# rad: jumps that turn more lead aside rather than over what they are to pass; our choice.
_MOST_TWIST = np.radians(60.0)
_SIZES = ("gap", "bar")  # fields of a request, of what the whole robot passes over


def obstacle_of(jump: Jump, kind: JumpType, start: Footholds, robot: Robot) -> Obstacle | None:
    """The obstacle that a jump passes over, ahead of the foremost contact point at the start.

    One that the whole robot passes over begins where feet have room beside it, or so far beyond.
    Raises `InputError`: the request does not say how wide or how high it is, or says so of none,
    or the ground beside it slopes.
    """
    _check_sizes(jump, kind)
    row = kind.obstacle
    if row is None:
        return None
    _check_level(jump)
    near, far, height = row.ends(jump)
    front = float(start.contacts[:, 0].max())
    if kind.passes:
        front = float(start.feet[:, 0].max()) + footing_room(robot, is_gap=height < 0)
    return Obstacle(front + near, front + far, height)


def _check_sizes(jump: Jump, kind: JumpType) -> None:
    """Raise `InputError`: a gap or a bar without a size, or the size of one that nothing passes."""
    for name in _SIZES:
        if name in kind.parameters and not getattr(jump, name) > 0:
            raise InputError(
                f"{name}: jumps of type {jump.type} pass over one; expected a number above 0 m"
            )
    for name in _SIZES:
        if getattr(jump, name) and name not in kind.parameters:
            types = [other for other, each in jump_types().items() if name in each.parameters]
            raise InputError(
                f"{name}: jumps of type {jump.type} pass over none of a request's size; expected "
                f'the type {" or ".join(types)}, or {name} among "asks" in its file'
            )


def _check_level(jump: Jump) -> None:
    """Raise `InputError` for slopes: what is passed over stands between level surfaces."""
    sloping = [name for name in INCLINES if getattr(jump, name)]
    sloping += [name for landing in jump.route for name in SLOPES if getattr(landing, name)]
    if sloping:
        raise InputError(
            f"{sloping[0].replace('_', ' ')}: jumps of type {jump.type} pass over a hurdle or a "
            "gap between level surfaces; expected 0, or a type that passes over nothing"
        )


def foot_reach(robot: Robot) -> float:
    """m, from the middle of a foot to where it ends, whichever way it looks."""
    radius = max(contact.radius for contact in foot_contacts(robot))
    return radius + float(np.linalg.norm(robot.corners, axis=1).max())


def footing_room(robot: Robot, *, is_gap: bool) -> float:
    """m that the middle of a standing foot keeps from the edges of what it passes over."""
    return foot_reach(robot) + (SCATTER if is_gap else RAMP)


def passing(
    jump: Jump, obstacle: Obstacle, count: int, start: Footholds, robot: Robot
) -> tuple[Displacement, ...]:
    """How far each of one or two jumps leads that take all feet beyond an obstacle.

    Of two the first ends astride it, as near to the middle of the way as the feet have room.

    Raises:
        InputError: the request says how far, too, or turns by a quarter of a turn or more in each
            of two jumps, the second of which would not lead beyond it.
        NoFooting: the obstacle is too wide to stand astride.
    """
    if jump.forward:
        raise InputError(
            f"forward: jumps of type {jump.type} lead as far as what they pass over asks; "
            f"expected 0, got {jump.forward:g} m"
        )
    if count > 1 and abs(jump.twist) > _MOST_TWIST:
        most = np.degrees(_MOST_TWIST)
        raise InputError(
            f"twist: each of the two jumps of type {jump.type} turns by it, and the second leads "
            f"along the heading after the first; expected {-most:g} to {most:g} deg"
        )
    room, x = footing_room(robot, is_gap=obstacle.is_gap), start.feet[:, 0]
    once, twice = (_ahead(start, turns * jump.twist) for turns in (1, 2))
    if count == 1:
        return (Displacement(forward=obstacle.far + room - float(once.min())),)
    hind = x < (x.max() + x.min()) / 2
    shortest = obstacle.far + room - float(once[~hind].min())
    longest = obstacle.near - room - float(once[hind].max())
    if shortest > longest:
        width = obstacle.far - obstacle.near
        turned = f", turned by {np.degrees(jump.twist):.0f} deg" if jump.twist else ""
        raise NoFooting(
            f"{'gap' if obstacle.is_gap else 'bar'}: {robot.name} cannot stand astride "
            f"{width:.3f} m{turned}; expected at most {max(width - shortest + longest, 0.0):.3f} m"
        )
    whole = obstacle.far + room - float(twice.min())
    first = float(np.clip(whole / 2, shortest, longest))
    # The second jump leads along the heading after the first.
    ahead = whole - first + jump.lateral * np.sin(jump.twist)
    return Displacement(forward=first), Displacement(forward=float(ahead / np.cos(jump.twist)))


def _ahead(start: Footholds, heading: float) -> Array:
    """(L,) m, how far ahead of the start's origin the feet stand with another heading, rad."""
    ahead: Array = (turns_about_z(heading) @ start.feet.T)[0]
    return ahead
