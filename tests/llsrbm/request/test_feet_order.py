"""Jump types in a line, against those in files."""

import pytest

import llsrbm
from llsrbm.request.feet_order import MOST, is_order, order_of, table_of
from llsrbm.request.jump_types import load_type, names
from llsrbm.robots import load_robot

GO2 = load_robot("go2")
ROBOTS = {name: load_robot(name) for name in ("go2", "slider")}


@pytest.mark.parametrize("robot", ROBOTS.values(), ids=ROBOTS)
@pytest.mark.parametrize("name", ["together", "rear-last", "leap", "one-foot-first", "hops"])
def test_the_order_of_a_preset_has_its_phases(robot, name):
    try:
        own = names()[name].schedule(robot)
    except llsrbm.InputError:
        pytest.skip("without its feet")
    order = order_of([phase.feet for phase in own], robot.leg_names)
    assert is_order(order)
    found = load_type(order).schedule(robot)
    assert [phase.feet for phase in found] == [phase.feet for phase in own]
    assert found.places_after.tolist() == own.places_after.tolist()


def test_groups_and_names_of_legs_are_words():
    found = load_type("all - FL + RL - hind - none - RR - all").schedule(GO2)
    assert [phase.feet for phase in found][1:5] == [("FL", "RL"), ("RL", "RR"), (), ("RR",)]


@pytest.mark.parametrize(
    ("order", "why"),
    [
        ("all - nobody - none - all", "nobody"),
        ("all -  - none - all", "expected at most"),
        ("all - FL+ - none - all", "expected at most"),
        (" - ".join(["all", "none"] * MOST + ["all"]), "expected at most"),
        ("none - all - none - all", "all feet"),
        ("all - front - all", "flight"),
    ],
)
def test_what_is_no_order_is_refused_in_a_line(order, why):
    with pytest.raises(llsrbm.InputError, match=why) as refusal:
        load_type(order).schedule(GO2)
    assert "\n" not in str(refusal.value)


def test_files_and_presets_are_none():
    assert not any(map(is_order, (*names(), "my - type.toml", "all", "")))


def test_a_long_name_of_feet_fits_on_the_timeline():
    phases = table_of("all - " + "+".join(["a_leg_with_a_long_name"] * 4) + " - none - all")[
        "phase"
    ]
    assert all(len(phase["name"]) <= 40 for phase in phases)
