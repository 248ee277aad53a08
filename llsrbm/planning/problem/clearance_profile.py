"""Least height of the body along the way: a smooth profile of an obstacle and of the ground.

The profile is the ground's height before the obstacle, its top over it, and the ground's height
beyond it, with ramps between. Ramps lie outside of the obstacle, so that what is above the profile
is above the obstacle.
"""

from typing import Any

import casadi as ca
import numpy as np

from llsrbm.arrays import Array
from llsrbm.body.trunk_and_knees import trunk_box
from llsrbm.errors import NoFooting
from llsrbm.planning.problem.passing import RAMP, foot_reach, footing_room
from llsrbm.planning.problem.task import Task
from llsrbm.robots.feet import foot_contacts

SHINS = (1 / 3, 2 / 3)  # of the way from knee to foot, points that are looked at
LEG_ROOM = 0.03  # m, as much of a leg lies on either side of its knee, and of these
_ROUNDED = 1e-6  # m, of feet that stand exactly as near as they may
STATIONS = 3  # cross-sections of the trunk's box whose corners are looked at
FAR = 100.0  # m, where the obstacle is that is none

# Name -> number of scalars; see `clearance_parameters`.
CLEARANCE_PARAMETERS = {
    "obstacle": 2,
    "obstacle_heights": 3,
    "obstacle_room": 3,
    "body_margin": 1,
    "trunk": 6,
}


def profile(x: Any, edges: Any, heights: Any, room: Any) -> Any:
    """m: height at x.

    Args:
        x: m, a scalar or an expression.
        edges: m, where the obstacle begins and ends.
        heights: m, before it, of its top, and beyond it.
        room: m between an edge and the ramp: what a point of the body stands for on either side.
    """
    rise = _step((x - edges[0] + room) / RAMP + 1)
    fall = _step((x - edges[1] - room) / RAMP)
    return heights[0] + (heights[1] - heights[0]) * rise + (heights[2] - heights[1]) * fall


def _step(u: Any) -> Any:
    """From 0 at u = 0 to 1 at u = 1, with continuous second derivatives."""
    u = ca.fmin(ca.fmax(u, 0.0), 1.0)
    return u**3 * (10 - 15 * u + 6 * u**2)


def clearance_parameters(task: Task) -> dict[str, Array]:
    """Name -> value of the parameters of rows about the whole body.

    `obstacle`: near and far edge, m. `obstacle_heights`: before, top, beyond, m. `obstacle_room`:
    of the trunk, of legs and of feet, m. `body_margin`: m. `trunk`: the box, m.
    """
    box = trunk_box(task.robot)
    before, beyond = sides(task)
    if task.obstacle is None:
        edges, top = (FAR, FAR), before
    else:
        edges = task.obstacle.near, task.obstacle.far
        top = max(task.obstacle.height, before, beyond)
    return {
        "obstacle": np.array(edges),
        "obstacle_heights": np.array([before, top, beyond]),
        "obstacle_room": np.array([trunk_spacing(box), LEG_ROOM, foot_reach(task.robot)]),
        "body_margin": np.array([task.body_margin]),
        "trunk": box.ravel(),
    }


def sides(task: Task) -> tuple[float, float]:
    """m: height of the ground before the obstacle and beyond it; without one, of the lowest."""
    heights = [place.height for place in task.places]
    if task.obstacle is None:
        return min(heights), min(heights)
    middle = (task.obstacle.near + task.obstacle.far) / 2
    beyond = [place.height for place in task.places if (place.contacts[:, 0] > middle).any()]
    return heights[0], beyond[-1] if beyond else heights[0]


def trunk_spacing(box: Array) -> float:
    """m: the furthest that neighbours among the trunk's points are from each other.

    Where one of them is over the obstacle, so are its neighbours' ends of the edges between.
    """
    length, width, _ = box[1] - box[0]
    return float(max(length / (STATIONS - 1), width))


def trunk_points(box: Any) -> list[tuple[Any, Any, Any]]:
    """(4 stations) points of a box, base axes, of its lowest and its highest corner."""
    shares = [k / (STATIONS - 1) for k in range(STATIONS)]
    return [
        (box[0] + share * (box[3] - box[0]), y, z)
        for share in shares
        for y in (box[1], box[4])
        for z in (box[2], box[5])
    ]


def foot_radius(task: Task) -> float:
    """m, of what of a foot touches the ground."""
    return max(contact.radius for contact in foot_contacts(task.robot))


def check_footing(task: Task) -> None:
    """Check that feet stand beside the obstacle, and at one height on either side. Raises
    `NoFooting`: one does not; which, and where it could stand.
    """
    obstacle = task.obstacle
    if obstacle is None:
        return
    room = footing_room(task.robot, is_gap=obstacle.is_gap) - _ROUNDED
    what = "gap" if obstacle.is_gap else "hurdle"
    legs = task.schedule.legs
    middle = (obstacle.near + obstacle.far) / 2
    for k, place in enumerate(task.places):
        when = f"after jump {k}" if k else "at the start"
        for i, (x, _, _) in enumerate(place.feet):
            if obstacle.near - room < x < obstacle.far + room:
                raise NoFooting(
                    f"obstacle: {when} the {legs[i]} foot would stand at {x:.3f} m, but "
                    f"the {what} goes from {obstacle.near:.3f} to {obstacle.far:.3f} m; expected "
                    f"feet at least {room:.3f} m before or beyond it: another distance forward"
                )
        heights = sides(task)
        for i, (x, _, _) in enumerate(place.feet):
            height = heights[int(x > middle)]
            if abs(place.height - height) > 1e-6:
                raise NoFooting(
                    f"obstacle: {when} the {legs[i]} foot would stand at a height of "
                    f"{place.height:g} m, {'beyond' if x > middle else 'before'} the {what}, where "
                    f"the ground is at {height:g} m; expected one height on either side: a jump "
                    "on the level, or all feet across"
                )
