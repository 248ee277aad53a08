"""An obstacle in the world, and how far jumps lead that take all feet beyond it."""

from __future__ import annotations

import numpy as np

from llsrbm.errors import InputError, NoFooting
from llsrbm.planning.problem.task import Footholds
from llsrbm.request.jump import Jump
from llsrbm.request.jump_types import Displacement, JumpType
from llsrbm.request.jump_types import names as jump_types
from llsrbm.request.obstacle import Obstacle
from llsrbm.robots.feet import foot_contacts
from llsrbm.robots.robot import Robot

RAMP = 0.04  # m, length of a ramp of the clearance profile: feet move about as far in an interval
# m that a foot stands from an edge beyond its own radius; our choice: feet of most disturbed jumps
# end within 15 mm of where they are planned to.
SCATTER = 0.02


def obstacle_of(jump: Jump, kind: JumpType, start: Footholds, robot: Robot) -> Obstacle | None:
    """The obstacle that a jump passes over, ahead of the foremost contact point at the start.

    One that the whole robot passes over begins where feet have room beside it, or so far beyond.
    Raises `InputError`: the request does not say how wide or how high it is.
    """
    row = kind.obstacle
    if row is None:
        return None
    for name in ("gap", "bar"):
        if name in kind.parameters and not getattr(jump, name) > 0:
            raise InputError(
                f"{name}: jumps of type {jump.type} pass over one; expected a number above 0 m"
            )
    near, far, height = row.ends(jump)
    front = float(start.contacts[:, 0].max())
    if kind.passes:
        front = float(start.feet[:, 0].max()) + footing_room(robot, is_gap=height < 0)
    return Obstacle(front + near, front + far, height)


def check_passed(jump: Jump, kind: JumpType) -> None:
    """Raise `InputError` where a request has a gap or a bar that its type does not pass over."""
    for name in ("gap", "bar"):
        if getattr(jump, name) and name not in kind.parameters:
            types = [title for title, other in jump_types().items() if name in other.parameters]
            raise InputError(
                f"{name}: jumps of type {jump.type} do not pass over one; expected the type "
                f'{" or ".join(types)}, or {name} among "asks" in its file'
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
        InputError: the request says how far, too.
        NoFooting: the obstacle is too wide to stand astride.
    """
    if jump.forward:
        raise InputError(
            f"forward: jumps of type {jump.type} lead as far as what they pass over asks; "
            f"expected 0, got {jump.forward:g} m"
        )
    feet, room = start.feet[:, 0], footing_room(robot, is_gap=obstacle.is_gap)
    whole = obstacle.far + room - float(feet.min())
    if count == 1:
        return (Displacement(forward=whole),)
    middle = (feet.max() + feet.min()) / 2
    shortest = obstacle.far + room - float(feet[feet > middle].min())
    longest = obstacle.near - room - float(feet[feet < middle].max())
    if shortest > longest:
        width = obstacle.far - obstacle.near
        raise NoFooting(
            f"{'gap' if obstacle.is_gap else 'bar'}: {robot.name} cannot stand astride "
            f"{width:.3f} m; expected at most {max(width - shortest + longest, 0.0):.3f} m"
        )
    first = float(np.clip(whole / 2, shortest, longest))
    return Displacement(forward=first), Displacement(forward=whole - first)
