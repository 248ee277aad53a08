"""The controls of a push and of replanning, as a page's scripts may set them."""

import math

import pytest

from llsrbm.request.scenario import Push

NUMBERS = ("Push at [s]", "Push x [N s]", "Push y [N s]", "Push z [N s]")


def pushes(session):
    return session.state.design.scenario.pushes


@pytest.fixture
def pushed(tab, session):
    """With a push of 5 N s to the left at 0.3 s."""
    tab.set("Push", True)
    tab.wait(lambda: tab.value("Push at [s]") > 0, "a push")
    for label, value in zip(NUMBERS, (0.3, 0.0, 5.0, 0.0), strict=True):
        tab.set(label, value)
    tab.wait(lambda: pushes(session) == (Push(0.3, (0.0, 5.0, 0.0)),), "its numbers")
    return tab


def test_its_numbers_are_there_with_a_push(tab, session):
    assert not tab.value("Push")
    assert not tab.value("Replan")
    assert not any(tab.control(label)["props"]["visible"] for label in NUMBERS)
    tab.set("Push", True)
    tab.wait(
        lambda: all(tab.control(label)["props"]["visible"] for label in NUMBERS), "its numbers"
    )
    (push,) = pushes(session)
    tab.wait(lambda: tab.value("Push at [s]") == push.time, "its time")


@pytest.mark.parametrize(
    ("label", "value", "said"),
    [
        ("Push at [s]", -1.0, "Push at [s]: expected 0 to 10, got −1"),
        ("Push y [N s]", 1e6, "Push y [N s]: expected −200 to 200, got 1e+06"),
        ("Push y [N s]", math.nan, "Push y [N s]: expected a number, got nan"),
    ],
)
def test_values_that_are_no_push_are_one_line(pushed, session, label, value, said):
    pushed.set(label, value)
    pushed.wait(lambda: any(said in str(note) for note in pushed.notifications), said)
    (push,) = pushes(session)
    assert 0 <= push.time <= 10
    assert max(map(abs, push.impulse)) <= 200


def test_components_that_are_too_large_together_are_refused(pushed, session):
    pushed.set("Push x [N s]", 200.0)
    said = "push: impulse: expected at most 200 N s"
    pushed.wait(lambda: any(said in str(note) for note in pushed.notifications), said)
    assert pushes(session) == (Push(0.3, (0.0, 5.0, 0.0)),)
    pushed.wait(lambda: pushed.value("Push x [N s]") == 0.0, "the number of before")
