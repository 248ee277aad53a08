"""Tables are made jump by jump, and go on from what is there."""

from types import SimpleNamespace

import numpy as np
import pytest

from llsrbm.analysis import learning
from llsrbm.analysis.learning import learn, requests
from llsrbm.errors import InputError
from llsrbm.ocp.horizon import Iterate
from llsrbm.planning.whole_body.grid import Grid
from llsrbm.planning.whole_body.learned import Refused, Solved
from llsrbm.planning.whole_body.learned_file import read_outcomes
from llsrbm.robots import load_robot

GRID = Grid((((0, 1, 2, 3), 8), ((), 12), ((0, 1, 2, 3), 8)))


@pytest.fixture
def robot():
    return load_robot("go2")


@pytest.fixture
def asked(monkeypatch, robot):
    """The jumps that were looked at; those that turn to the left are refused."""
    jumps = []

    def looked_at(jump, refiner):
        jumps.append(jump)
        if jump.twist > 0:
            return Refused(jump, "friction")
        return Solved(jump, Iterate(np.ones(3), np.ones(2)), 0.4, 0.8)

    monkeypatch.setattr(learning, "_looked_at", looked_at)
    monkeypatch.setattr(learning, "_refiner", lambda _: SimpleNamespace(robot=robot, grid=GRID))
    return jumps


def test_what_is_refused_is_kept_too_and_nothing_is_looked_at_twice(asked, robot, tmp_path):
    path = tmp_path / "go2.npz"
    learn(robot, 60, path)
    _, table = learn(robot, 80, path)
    assert asked == list(requests(robot, 80))
    outcomes = read_outcomes(path, robot, GRID)
    refused = [jump for jump in asked if jump.twist > 0]
    assert [each.jump for each in outcomes.refusals(robot)] == refused
    assert len(outcomes.requests) == len(table.solved(robot)) == 80 - len(refused)


def test_a_table_of_too_few_jumps_is_none(asked, robot, tmp_path):
    path = tmp_path / "go2.npz"
    with pytest.raises(InputError, match="of 16 jumps hold; expected at least 16"):
        learn(robot, 16, path)
    assert not path.exists()


def test_half_of_the_requests_have_at_most_two_components(robot):
    components = [
        sum(value != 0 for value in (jump.twist, jump.forward, jump.lateral, jump.height))
        for jump in requests(robot, 40)
    ]
    assert min(components[::2]) >= 3
    assert max(components[1::2]) == 2


def test_where_no_table_can_be_written_is_told_before_jumps_are_solved(asked, robot, tmp_path):
    for path in (tmp_path, tmp_path / "none" / "go2.npz"):
        with pytest.raises(InputError, match="cannot write"):
            learn(robot, 80, path)
    assert asked == []
