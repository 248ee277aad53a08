"""A jump type's gait diagram: a bar for each stretch in which a foot stands, and the turn."""

import math
from dataclasses import replace
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from hypothesis import given

from app.panel.type_picture import EMPTY, HEIGHT, gait_diagram, type_picture
from llsrbm.request import jump_types
from llsrbm.request.jump import Jump
from llsrbm.request.jump_types import load_type, with_defaults
from llsrbm.robots import load_robot
from tests.llsrbm.schedules import schedules

OWN = """
title = "Front feet first"
summary = "all feet push; <b>the front feet</b> land first"
phase = [
  { name = "take-off", feet = "all", time = "takeoff" },
  { name = "flight & fall", feet = "none", time = "flight" },
  { name = "landing front", feet = "front", time = [0.06, 0.4] },
  { name = "landing", feet = "all", time = "landing" },
]
"""


def drawing(html):
    """The elements of a picture by their tags; parsing fails if anything is not escaped."""
    found = {}
    for each in ET.fromstring(html).iter():
        found.setdefault(each.tag, []).append(each)
    return found


def touchdowns(schedule):
    """Stretches in which a foot stands, of all feet: those at the start, and one a landing."""
    landings = sum(int(schedule.lands(phase).sum()) for phase in range(1, len(schedule)))
    return len(schedule.legs) + landings


@given(schedules())
def test_a_bar_for_each_stretch_in_which_a_foot_stands(schedule):
    bars = drawing(gait_diagram(schedule, Jump()))["rect"]
    assert len(bars) == touchdowns(schedule)
    starts = np.array([float(bar.get("x")) for bar in bars])
    lengths = np.array([float(bar.get("width")) for bar in bars])
    whole = (starts + lengths).max() - starts.min()
    share = lengths.sum() / (whole * len(schedule.legs))  # of the diagram that is filled
    assert share == pytest.approx(schedule.stands.mean(), abs=0.01)


@pytest.mark.parametrize("name", jump_types.names())
@pytest.mark.parametrize("robot", ["anymal", "go2", "slider", "g1"])
def test_every_preset_on_robots_with_two_and_four_legs(robot, name):
    kind, legs = load_type(name), load_robot(robot)
    jump = with_defaults(Jump(robot=robot, type=name))
    found = drawing(type_picture(kind, legs, jump))
    if robot in ("slider", "g1") and name in ("rear-last", "leap", "flip", "caught-flip"):
        assert "svg" not in found  # they have no hind feet
        return
    assert [each.text for each in found["text"]][: len(legs.legs)] == list(legs.leg_names)
    assert len(found["rect"]) == touchdowns(kind.schedule(legs, jump))
    assert float(found["svg"][0].get("height")) <= HEIGHT


def test_hops_are_counted():
    jump = with_defaults(Jump(robot="go2", type="hops"))
    for hops in (1, 2, 5):
        picture = type_picture(load_type("hops"), load_robot("go2"), replace(jump, hops=hops))
        assert len(drawing(picture)["rect"]) == 4 * (hops + 1)


@pytest.mark.parametrize(
    ("turn", "words", "clockwise"),
    [
        # Seen from its right a robot looks to the right: its nose goes down in a front flip.
        ({"pitch": math.tau}, "front flip, seen from its right", "1"),
        ({"pitch": -math.tau}, "back flip, seen from its right", "0"),
        ({"roll": math.tau}, "roll right, seen from behind", "1"),
        ({"roll": -math.tau}, "roll left, seen from behind", "0"),
    ],
)
def test_the_sense_of_a_turn(turn, words, clockwise):
    jump = Jump(robot="go2", type="flip" if "pitch" in turn else "barrel-roll", **turn)
    found = drawing(type_picture(load_type(jump.type), load_robot("go2"), jump))
    assert found["title"][0].text.endswith(f"landing: all feet; turn: {words}")
    (arc,) = [path.get("d") for path in found["path"] if "A" in path.get("d")]
    _, _, large, sweep = arc.split("A")[1].split()[1:5]
    assert (large, sweep) == ("1", clockwise)


def test_without_a_turn_there_is_no_arrow():
    found = drawing(type_picture(load_type("together"), load_robot("anymal"), Jump()))
    assert not [path for path in found["path"] if "A" in path.get("d")]


def test_a_file_of_ones_own(tmp_path):
    path = tmp_path / "own.toml"
    path.write_text(OWN, encoding="utf-8")
    found = drawing(type_picture(load_type(str(path)), load_robot("anymal"), Jump(type=str(path))))
    assert len(found["rect"]) == 8
    assert found["title"][0].text == (
        "take-off: all feet; flight & fall: no foot; landing front: LF, RF; landing: all feet"
    )
    assert found["div"][-1].text == "All feet push; <b>the front feet</b> land first"


def test_its_place_is_kept_while_nothing_is_known():
    height = f"height:{HEIGHT}px"
    assert height in drawing(EMPTY)["div"][0].get("style")
    assert height in type_picture(load_type("hops"), load_robot("go2"), Jump())
