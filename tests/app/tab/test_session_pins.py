"""Designs that stay beside the current one."""

from __future__ import annotations

import pytest

from tests.app.raw_tab import choose, pinned, planned


def pin_at(tab, session, forward):
    tab.set("Forward [m]", forward)
    planned(tab, session, lambda jump: jump.forward == forward, "the plan to pin")
    tab.wait_for_status("Planned")
    tab.press("Pin")


def test_pinned_designs_stay_until_they_are_let_go(tab, session, script):
    for number, forward in enumerate((0.1, 0.2, 0.3), start=1):
        assert not tab.control("Pin")["props"]["disabled"]
        pin_at(tab, session, forward)
        tab.wait(lambda n=number: len(pinned(tab)) == n, "a ghost")
    tab.wait(lambda: tab.control("Pin")["props"]["disabled"], "no colour left")
    choices = tab.control("Pinned")["props"]["options"]
    assert len(choices) == len(set(choices)) == 3
    tab.set("Forward [m]", 0.5)
    planned(tab, session, lambda jump: jump.forward == 0.5, "the next plan")
    tab.wait_for_status("Planned")
    ends = {name: script.at(f"{name}/base", 1.3)[0][0] for name in pinned(tab)}
    solid = script.at("/links/base", 1.3)[0][0]
    assert sorted(solid - end for end in ends.values()) == pytest.approx([0.2, 0.3, 0.4], abs=1e-5)
    tab.set("Pinned", choices[1])
    tab.press("Unpin")
    tab.wait(lambda: len(pinned(tab)) == 2, "two ghosts")
    tab.wait(lambda: not tab.control("Pin")["props"]["disabled"], "a colour again")
    left = {name for name in pinned(tab) if f"{name}/base" in script.nodes()}
    assert sorted(solid - ends[name] for name in left) == pytest.approx([0.2, 0.4], abs=1e-5)


def test_a_pin_survives_a_change_of_robot_and_is_taken_up_again(tab, session, script):
    pin_at(tab, session, 0.2)
    tab.wait(lambda: pinned(tab), "a ghost")
    choose(tab, session, "slider")
    tab.wait(lambda: "/pinned/1/base" in script.nodes(), "the ghost's motion")
    tab.press("Use this design")
    planned(tab, session, lambda jump: jump.robot == "anymal", "the pinned design")
    assert session.plan.jump.forward == 0.2
    assert tab.value("Robot") == "ANYmal B"
