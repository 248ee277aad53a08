"""`Edge`: the row that stops a jump from growing, in the words of refusals."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from llsrbm.ocp.horizon import Iterate
from llsrbm.planning.problem.placement import make_task
from llsrbm.planning.solve.jump_layout import layout_of
from llsrbm.planning.solve.watch import Watch
from llsrbm.planning.whole_body.binding import Edge
from llsrbm.planning.whole_body.grid import Grid
from llsrbm.planning.whole_body.refine import Refiner
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot


@cache
def refined():
    jump, robot = Jump(robot="go2", forward=0.3), load_robot("go2")
    task = make_task(jump, robot)
    refiner = Refiner(robot, Grid.at(task.schedule, layout_of(jump, robot).intervals))
    assert refiner.learned(task, Watch()).refined
    return refiner


def edge(kind, knot, index, size=1.0, before=None):
    """An edge whose only multiplier is that of a row, and the row's instant."""
    refiner = refined()
    multipliers, at, found = np.zeros(refiner.solver.sizes[1]), 0, None
    for name, where, time, low, _ in refiner.rows:
        if (name, where) == (kind, knot) and found is None:
            multipliers[at + index], found = size, time
        at += len(low)
    assert found is not None
    return Edge(refiner.rows, Iterate(refiner.solution.variables, multipliers), before), found


@pytest.mark.parametrize(
    ("row", "words"),
    [
        (("torque", 2, 11), "RR_calf_joint is at its limit of 38.6 Nm in take-off at {:.2f} s"),
        (("torque", 7, 0), "FL_hip_joint is at its limit of 20.1 Nm at lift-off"),
        (("speed", 12, 2), "FL_calf_joint is at its limit of 14.1 rad/s in flight at {:.2f} s"),
        (("friction", 3, 0), "the coefficient of friction is at its limit of 0.5"),
        (("durations", 0, 2), "the longest landing is at its limit of 0.8 s"),
        (("clearance", 12, 1), "the foot of FR flies as low as it may in flight at {:.2f} s"),
        (("shanks", 12, 0), "FL and FR come as near to each other as they may"),
        (("knees", 3, 2), "the knee of RL comes as near to the ground as it may"),
    ],
)
def test_rows_in_words(row, words):
    found, time = edge(*row)
    assert str(found.stop()).startswith(words.format(time))


def test_a_shortest_phase_leans_on_its_lower_bound():
    found, _ = edge("durations", 0, 0, size=-1.0)
    assert str(found.stop()) == "the shortest take-off is at its limit of 0.4 s"


def test_torque_at_speed_is_said_with_both():
    found, _ = edge("drive", 7, 8)
    assert str(found.stop()).startswith("RL_calf_joint is at its limit of ")
    assert " rad/s with " in str(found.stop())
    assert str(found.stop()).endswith(" Nm at lift-off")


def test_what_has_grown_since_an_easier_jump_counts():
    always, _ = edge("friction", 3, 0, size=5.0)
    now, _ = edge("torque", 2, 11)
    multipliers = always.solution.multipliers + now.solution.multipliers
    both = Iterate(now.solution.variables, multipliers)
    assert Edge(now.rows, both).stop().limit == "friction"
    assert Edge(now.rows, both, always.solution).stop().constraint == "torque"


def test_where_no_row_has_grown_there_is_none():
    found, _ = edge("torque", 2, 11)
    assert Edge(found.rows, found.solution, found.solution).stop() is None


@pytest.mark.parametrize(
    ("moving", "words"),
    [
        ((6, 9), "FL and FR come as near to each other as they may"),
        ((6,), "leg FL comes as near to another link as it may"),
        ((2, 17), "leg RR comes as near to what is stood on as it may"),
        ((2,), "the trunk comes as near to what is stood on as it may"),
    ],
)
def test_links_that_come_near_are_those_whose_joints_move_them_apart(moving, words):
    """`moving`: velocities, the base's first, with which a distance changes."""
    found, time = edge("apart", 12, 1)
    start = found.rows.start
    slope = np.zeros_like(start.apart.slope)
    slope[24, 1, list(moving)] = 1.0
    rows = replace(found.rows, start=replace(start, apart=replace(start.apart, slope=slope)))
    assert str(Edge(rows, found.solution).stop()) == f"{words} in flight at {time:.2f} s"
