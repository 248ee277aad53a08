"""How much of a motion's way is sought, where the robot's table of jumps says it is too far."""

from __future__ import annotations

from typing import Any

from llsrbm.certified_nearest import UNLIKELY
from llsrbm.planning.whole_body.feasible import feasible_of
from llsrbm.planning.whole_body.nearest import sure_share
from llsrbm.repairing.request import Request
from llsrbm.request.jump import COMPONENTS, Jump
from llsrbm.robots.robot import Robot


def shares(request: Request, robot: Robot) -> tuple[float, ...]:
    """Shares of a motion's way and turn to be sought, each where the one before leads nowhere.

    Jumps in a row, and a robot without a table, go all the way or not at all.
    """
    feasible = None if request.task.jump.route else feasible_of(robot)
    if feasible is None:
        return (1.0,)
    own: dict[str, Any] = {name: getattr(request.task.jump, name) for name in COMPONENTS}
    jump = Jump(robot=request.task.jump.robot, **own)
    sure = sure_share(jump, feasible)
    less = (sure,) if 0 < sure < 1 else ()
    return less if less and feasible.score(jump) < UNLIKELY else (1.0, *less)
