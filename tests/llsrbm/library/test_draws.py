"""Draws: the same request whenever it is drawn, within what a robot may be asked for."""

import pytest

from llsrbm.library.draws import Draw
from llsrbm.planning.problem.placement import make_task
from llsrbm.request.jump import COMPONENTS
from llsrbm.robots import load_robot

ROBOTS = ("go2", "slider")
KINDS = {
    "go2": {"together", "pirouette", "hops", "route", "rear-last", "run-up", "over-gap"},
    "slider": {"together", "pirouette", "hops", "route", "one-foot-first", "over-gap"},
}


@pytest.mark.parametrize("robot", ROBOTS)
def test_draws_are_requests_that_can_be_placed(robot):
    loaded, drawn = load_robot(robot), [Draw(robot, number) for number in range(40)]
    assert {draw.kind for draw in drawn} == KINDS[robot]
    for draw in drawn:
        assert draw.jump == Draw(robot, draw.number).jump
        make_task(draw.jump, loaded)
        for name in COMPONENTS:
            low, high = getattr(loaded.file.task, name)
            assert low - 1e-3 <= getattr(draw.jump, name) <= high + 1e-3
    assert len({draw.jump for draw in drawn}) == len(drawn)
