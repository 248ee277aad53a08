"""Made-up tables of solved jumps whose border is known."""

from collections.abc import Iterator
from contextlib import contextmanager
from unittest.mock import patch

import numpy as np

from llsrbm.planning.whole_body import feasible
from llsrbm.planning.whole_body.learned import Outcomes
from llsrbm.request.jump import COMPONENTS
from llsrbm.robots.robot import Robot

BORDER = 0.5
"""The largest twist that was planned, as a share of its range, whatever else is asked."""

JUMPS = 4000


def made_up(robot: Robot) -> Outcomes:
    """What became of jumps all over a robot's range."""
    ends = np.array([getattr(robot.file.task, name) for name in COMPONENTS])
    x = np.random.default_rng(0).uniform(*ends.T, (JUMPS, len(COMPONENTS)))
    can = np.abs(x[:, 0]) < BORDER * ends[0, 1]
    solved, refused = x[can], x[~can]
    figures = np.full((2, len(solved)), 0.4)
    stops = ("joint_torque", "friction")
    return Outcomes(solved, *figures, refused, (stops * len(refused))[: len(refused)])


@contextmanager
def learned_of(*robots: Robot) -> Iterator[None]:
    """Some robots have such tables, no other one has any, until the block ends."""
    tables = {robot.name: made_up(robot) for robot in robots}
    numbers = {robot.name: robot.file for robot in robots}

    def outcomes_of(robot: Robot) -> Outcomes | None:
        return tables.get(robot.name) if numbers.get(robot.name) == robot.file else None

    with patch.object(feasible, "outcomes_of", outcomes_of):
        yield
