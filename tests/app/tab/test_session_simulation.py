"""Simulating in one tab."""

import pytest

from tests.app import planners


def simulate(tab, session, word="Landed", seed=None):
    if seed is not None:
        tab.set("Disturb", True)
        tab.set("Seed", seed)
    tab.press("Simulate")
    return tab.wait_for_status(word)


def visible(tab, node):
    return tab.nodes.get(node, {}).get("visible", True)


def test_a_board_is_drawn_from_mid_flight_on(tab, session, script):
    tab.set("Board under the feet [mm]", 25)
    tab.set("Half board", True)
    simulate(tab, session)
    scenario = session.state.rollout.scenario
    assert (scenario.board, scenario.half_board) == (0.025, True)
    position, _, before = script.at("/blocks/0", 0.6)
    assert before.tolist() == [0, 0, 0]
    assert script.at("/blocks/0", 0.7)[2].tolist() == [1, 1, 1]
    assert position[2] == pytest.approx(0.0125)
    assert tab.nodes["/blocks/0"]["dimensions"][2] == pytest.approx(0.025)


def test_the_seed_counts_only_when_disturbed(tab, session):
    tab.set("Seed", 9)
    simulate(tab, session)
    assert session.state.rollout.scenario.seed is None
    tab.set("Disturb", True)
    tab.press("Simulate")
    tab.wait(lambda: session.state.rollout.scenario.seed == 9, "the disturbed one")
    assert session.state.rollout.scenario.noise == 1.0


def test_a_fall_is_told_and_drawn(tab, session, script):
    told = simulate(tab, session, "Fell", planners.FALLING)
    when = session.state.rollout.outcome.fell_at_s
    assert told.startswith(f"Fell at {when:.2f} s: first ")
    assert told.endswith(f", then the base touched the ground at {when:.2f} s.")
    assert script.end == pytest.approx(1.3)
    lying = session.state.rollout.base_position[-1]
    assert script.at("/links/base", 1.25)[0] == pytest.approx(lying, abs=1e-6)
    assert "fell" in [mark["name"] for mark in script.events["marks"]]


def test_half_of_no_board_is_no_board(tab, session):
    tab.set("Half board", True)
    simulate(tab, session)
    assert not session.state.rollout.scenario.half_board
