"""Jumps that take all feet beyond a gap or a bar."""

import numpy as np
import pytest

from llsrbm.errors import InputError, NoFooting
from llsrbm.planning.problem.passing import footing_room
from llsrbm.planning.problem.placement import make_task
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot


@pytest.mark.parametrize("name", ["go2", "anymal", "slider", "g1_legs"])
@pytest.mark.parametrize("size", [{"gap": 0.2}, {"bar": 0.1}])
def test_all_feet_end_beyond_it_and_none_stands_in_it(name, size):
    robot = load_robot(name)
    kind = "over-gap" if "gap" in size else "over-hurdle"
    task = make_task(Jump(robot=name, type=kind, **size), robot)
    obstacle, room = task.obstacle, footing_room(robot, is_gap="gap" in size) - 1e-6
    assert len(task.places) == 1 + (2 if len(robot.legs) == 4 else 1)
    feet = np.array([place.feet[:, 0] for place in task.places])
    assert (feet[0] <= obstacle.near - room).all()
    assert (feet[-1] >= obstacle.far + room).all()
    assert ((feet <= obstacle.near - room) | (feet >= obstacle.far + room)).all()
    width = obstacle.far - obstacle.near
    assert width == pytest.approx(size.get("gap", 0.04))


def test_wider_than_a_robot_stands_astride_is_refused_with_what_it_can():
    robot = load_robot("go2")
    with pytest.raises(NoFooting, match=r"gap: go2 cannot stand astride 0.400 m; expected at most"):
        make_task(Jump(robot="go2", type="over-gap", gap=0.4), robot)


@pytest.mark.parametrize(
    ("jump", "said"),
    [
        ({"type": "over-gap"}, "gap: jumps of type over-gap pass over one"),
        ({"type": "over-gap", "gap": 0.2, "forward": 0.1}, "forward: jumps of type over-gap lead"),
        ({"type": "over-hurdle", "gap": 0.2}, "bar: jumps of type over-hurdle pass over one"),
        ({"type": "over-gap", "gap": 0.2, "hops": 3}, "hops: .* expected 1, got 3"),
        # A size that nothing would have passed over was left out without a word.
        ({"gap": 0.2}, "gap: jumps of type together pass over none .* expected the type over-gap"),
        ({"type": "gap", "gap": 0.5, "forward": 0.4}, "gap: jumps of type gap pass over none"),
        ({"type": "over-gap", "gap": 0.2, "bar": 0.1}, "bar: .* expected the type over-hurdle"),
        # The blocks beside it were level whatever the plan took them for.
        ({"type": "over-gap", "gap": 0.2, "slope": 0.1}, "slope: .* between level surfaces"),
        ({"type": "hurdle", "forward": 0.5, "takeoff_cross_slope": 0.1}, "takeoff cross slope: "),
        (
            {"type": "gap", "route": [{"forward": 0.5}, {"forward": 0.4, "cross_slope": 0.1}]},
            "cross slope: .* between level surfaces",
        ),
    ],
)
def test_what_the_type_needs_is_said(jump, said):
    with pytest.raises(InputError, match=said):
        make_task(Jump(robot="go2", **jump), load_robot("go2"))


@pytest.mark.parametrize("name", ["go2", "anymal", "g1"])
@pytest.mark.parametrize(("twist", "lateral"), [(0.0, 0.0), (0.3, 0.1), (-0.3, 0.1), (0.2, -0.15)])
@pytest.mark.parametrize(("kind", "size"), [("over-gap", "gap"), ("over-hurdle", "bar")])
def test_feet_keep_their_room_however_the_jumps_turn(name, twist, lateral, kind, size):
    robot = load_robot(name)
    jump = Jump(robot=name, type=kind, twist=twist, lateral=lateral, **{size: 0.06})
    task = make_task(jump, robot)
    room = footing_room(robot, is_gap=size == "gap") - 1e-9
    for place in task.places:
        x = place.feet[:, 0]
        assert ((x <= task.obstacle.near - room) | (x >= task.obstacle.far + room)).all()
    nearest = task.places[-1].feet[:, 0].min()
    assert nearest == pytest.approx(task.obstacle.far + room)


def test_two_jumps_that_would_lead_aside_are_refused():
    with pytest.raises(InputError, match=r"twist: each of the two jumps .* expected -60 to 60 deg"):
        make_task(Jump(robot="go2", type="over-gap", gap=0.1, twist=1.3), load_robot("go2"))
