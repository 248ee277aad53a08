"""Jump types in one tab, spoken to as a browser (or a hostile script) would."""

import math

import pytest

from app.panel.jump_types import types_offered
from llsrbm.request import jump_types
from tests.app.raw_tab import choose, planned

EXTRA = {
    "Turn": ("pitch", "roll"),
    "Speed [m/s]": ("speed",),
    "End speed [m/s]": ("end_speed",),
    "Hops": ("hops",),
}


@pytest.fixture
def tab(tab, session):
    """A tab of Go2, which does all types but barrel rolls."""
    choose(tab, session, "go2")
    return tab


def choose_type(tab, session, name):
    tab.set("Jump type", jump_types.load_type(name).title)
    planned(tab, session, lambda jump: jump.type == name, f"a plan of {name}")
    tab.wait_for_status("Feasible")


def there(tab):
    """Labels of the controls that depend on the type and can be seen."""
    return {label for label in EXTRA if tab.control(label)["props"]["visible"]}


@pytest.mark.parametrize("name", ["flip", "hops"])
def test_controls_appear_that_a_type_asks_for(tab, session, name):
    choose_type(tab, session, name)
    asks = jump_types.load_type(name).parameters
    assert there(tab) == {label for label, fields in EXTRA.items() if set(fields) & set(asks)}
    assert session.state.plan.schedule == jump_types.schedule_of(
        session.state.plan.jump, session.state.robot
    )


def test_they_show_what_the_type_states_and_change_it(tab, session):
    choose_type(tab, session, "hops")
    assert tab.value("Hops") == 2
    tab.set("Hops", 3)
    planned(tab, session, lambda jump: jump.hops == 3, "three hops")
    assert isinstance(session.state.plan.jump.hops, int)
    choose_type(tab, session, "flip")
    assert tab.value("Turn") == "back flip"
    tab.set("Turn", "front flip")
    jump = planned(tab, session, lambda jump: jump.pitch > 0, "a front flip").jump
    assert (jump.pitch, jump.roll, jump.hops) == (2 * math.pi, 0.0, 1)
    choose_type(tab, session, "run-up")
    tab.set("Speed [m/s]", 0.7)
    planned(tab, session, lambda jump: jump.speed == 0.7, "a faster run-up")
    tab.press("Undo")
    planned(tab, session, lambda jump: jump.speed == 0.5, "the speed before")
    assert tab.value("Speed [m/s]") == 0.5


def test_a_biped_is_offered_what_it_can_do(tab, session):
    choose_type(tab, session, "rear-last")
    tab.set("Robot", "SLIDER")
    planned(tab, session, lambda jump: jump.robot == "slider", "a plan of slider")
    tab.wait(lambda: 'SLIDER does not support "Rear last"' in tab.status(), "a word on it")
    assert session.state.plan.jump.type == "together"
    assert tab.value("Jump type") == "All feet together"
    assert "Rear last" not in tab.control("Jump type")["props"]["options"]
    choose(tab, session, "anymal")
    assert "Rear last" in tab.control("Jump type")["props"]["options"]


@pytest.mark.parametrize(
    ("label", "value"),
    [
        ("Jump type", ["Flip"]),
        ("Jump type", "../../secret.toml"),
        ("Turn", "roll upwards"),
        ("Hops", 1e9),
        ("Speed [m/s]", float("nan")),
    ],
)
def test_values_that_no_control_offers_are_told(tab, session, label, value):
    for name, kind in types_offered(session.state.robot).items():
        if set(EXTRA.get(label, ())) & set(kind.parameters):
            choose_type(tab, session, name)
            break
    before = session.state.design.jump
    tab.set(label, value)
    tab.wait(lambda: tab.notifications, "a note")
    assert label in tab.notifications[-1][1]
    jump = session.state.design.jump
    assert jump.type == before.type
    assert (jump.pitch, jump.roll) == (before.pitch, before.roll)
    assert 1 <= jump.hops <= 5
    assert 0 <= jump.speed <= 1
