"""Simulating in one tab."""

from __future__ import annotations

import time

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import llsrbm
from app.picture.overlays.forces import ARROW_PER_WEIGHT
from tests.app import planners


def simulate(tab, session, word="Landed", seed=None):
    if seed is not None:
        tab.set("Disturb", True)
        tab.set("Seed", seed)
    tab.press("Simulate")
    return tab.wait_for_status(word)


def curves(chart):
    """Titles of a chart's lines."""
    return [line["label"] for line in chart["series"] if line.get("scale") == "y"]


def visible(tab, node):
    return tab.nodes.get(node, {}).get("visible", True)


def charts(tab):
    """Title -> chart, of those that are shown."""
    found = (m["props"] for m in tab.controls.values() if m["type"] == "GuiUplotMessage")
    return {props["title"]: props for props in found if props["visible"]}


def test_simulate_runs_and_says_how_it_ended(tab, session, script):
    told = simulate(tab, session)
    assert told.startswith("Landed yaw -2.9° from the plan at touch-down")
    assert session.rollout.jump == session.plan.jump
    assert session.rollout.scenario == llsrbm.Scenario()
    assert "Saturated ticks" in tab.text()
    assert "detected +5.0 ms" in script.events["summary"]


def test_the_plan_becomes_a_ghost_on_the_same_timeline(tab, session, script):
    assert "/shade" not in tab.nodes
    simulate(tab, session)
    rollout = session.rollout
    assert script.end == pytest.approx(2.3)
    tick = int(np.argmin(np.abs(rollout.time - 0.85)))
    apart = rollout.base_position[tick] - np.array(
        [np.interp(0.85, session.plan.time, axis) for axis in session.plan.base_position.T]
    )
    solid, shade = (script.at(f"/{name}/base", 0.85)[0] for name in ("links", "shade"))
    assert solid - shade == pytest.approx(apart, abs=0.012)
    assert np.linalg.norm(apart) > 0.05
    assert not visible(tab, "/ellipsoid/srbm")
    assert visible(tab, "/ellipsoid/whole")
    assert visible(tab, "/shade")
    assert [row["name"] for row in script.events["rows"]] == ["plan", "simulation"]
    assert "detected" in [mark["name"] for mark in script.events["marks"]]


def pushed(script, instant):
    """Sum of the arrows at an instant, m."""
    total = np.zeros(3)
    for foot in range(4):
        _, wxyz, scale = script.at(f"/arrows/{foot}", instant)
        total += Rotation.from_quat(wxyz, scalar_first=True).apply([0, 0, scale[2]])
    return total


def test_forces_are_those_that_were_measured(tab, session, script):
    simulate(tab, session)
    rollout, tick = session.rollout, int(np.argmin(np.abs(session.rollout.time - 0.25)))
    drawn, measured = pushed(script, 0.25), rollout.contact_force[tick].sum(axis=0)
    assert drawn[:2] / drawn[2] == pytest.approx(measured[:2] / measured[2], abs=0.02)
    assert pushed(script, 2.0)[2] == pytest.approx(ARROW_PER_WEIGHT, rel=0.02)
    standing = rollout.contact_force[-1, :, 2].sum()
    assert drawn[2] / measured[2] == pytest.approx(ARROW_PER_WEIGHT / standing, rel=0.05)


def test_a_new_plan_drops_the_simulation(tab, session, script):
    simulate(tab, session)
    tab.set("Forward [m]", 0.2)
    tab.wait_for_status("Planned")
    assert session.rollout is None
    tab.wait(lambda: not visible(tab, "/shade"), "no ghost")
    assert visible(tab, "/ellipsoid/srbm")
    assert script.end == pytest.approx(1.3)
    assert "/shade/base" not in script.nodes()
    assert {curve for chart in charts(tab).values() for curve in curves(chart)} == {"plan"}


def test_a_board_is_drawn_from_mid_flight_on(tab, session, script):
    tab.set("Board [mm]", 25)
    tab.set("Half board", True)
    simulate(tab, session)
    scenario = session.rollout.scenario
    assert (scenario.board, scenario.half_board) == (0.025, True)
    position, _, before = script.at("/blocks/0", 0.6)
    assert before.tolist() == [0, 0, 0]
    assert script.at("/blocks/0", 0.7)[2].tolist() == [1, 1, 1]
    assert position[2] == pytest.approx(0.0125)
    assert tab.nodes["/blocks/0"]["dimensions"][2] == pytest.approx(0.025)


def test_half_of_no_board_is_no_board(tab, session):
    tab.set("Half board", True)
    simulate(tab, session)
    assert not session.rollout.scenario.half_board


def test_the_seed_counts_only_when_disturbed(tab, session):
    tab.set("Seed", 9)
    simulate(tab, session)
    assert session.rollout.scenario.seed is None
    tab.set("Disturb", True)
    tab.press("Simulate")
    tab.wait(lambda: session.rollout.scenario.seed == 9, "the disturbed one")
    assert session.rollout.scenario.noise == 1.0


def test_progress_is_told_and_cancel_keeps_the_plan(tab, session):
    simulate(tab, session, "Simulating", planners.SLOWLY)
    tab.wait(lambda: tab.status().startswith("Simulating 1"), "some percent")
    assert tab.control("Cancel")["props"]["visible"]
    tab.press("Cancel")
    tab.wait_for_status("Cancelled")
    assert session.plan is not None
    assert session.rollout is None
    simulate(tab, session, seed=1)


def test_cancel_ends_a_simulation_that_does_not_ask(tab, session):
    simulate(tab, session, "Simulating", planners.STUBBORNLY)
    tab.wait(lambda: tab.status().startswith("Simulating 1"), "its beginning")
    began = time.monotonic()
    tab.press("Cancel")
    tab.wait_for_status("Cancelled")
    assert time.monotonic() - began < 1.0
    simulate(tab, session, seed=1)


def test_a_slider_stops_the_simulation_and_plans(tab, session):
    simulate(tab, session, "Simulating", planners.SLOWLY)
    tab.wait(lambda: tab.status().startswith("Simulating 1"), "its beginning")
    began = time.monotonic()
    tab.set("Forward [m]", 0.3)
    tab.wait(lambda: session.plan.jump.forward == 0.3, "the plan")
    assert time.monotonic() - began < 2.0
    tab.wait_for_status("Planned")
    time.sleep(0.2)
    assert session.rollout is None


@pytest.mark.parametrize("seed", [planners.FALLING, planners.TRIPPING])
def test_a_fall_is_told_and_drawn(tab, session, script, seed):
    told = simulate(tab, session, "Fell", seed)
    when = session.rollout.outcome.fell_at_s
    assert told.startswith(f"Fell at {when:.2f} s: first ")
    assert told.endswith(f", then the base touched the ground at {when:.2f} s.")
    assert script.end == pytest.approx(1.3)
    lying = session.rollout.base_position[-1]
    assert script.at("/links/base", 1.25)[0] == pytest.approx(lying, abs=1e-6)
    assert "fell" in [mark["name"] for mark in script.events["marks"]]


def test_a_refusal_is_a_sentence_and_the_plan_stays(tab, session):
    told = simulate(tab, session, "Failed", planners.IMPOSSIBLE)
    assert told == "Failed board: expected 0 to 0.05 m, got more"
    simulate(tab, session, seed=1)


@pytest.mark.parametrize(
    ("label", "value", "told"),
    [
        ("Board [mm]", 999, "Board [mm]: expected 0 to 70, got 999; the nearest is taken"),
        ("Seed", -3, "Seed: expected 0 to 9999, got -3; the nearest is taken"),
    ],
)
def test_a_value_no_control_offers_is_corrected_and_said(tab, session, label, value, told):
    tab.set("Disturb", True)
    tab.set(label, value)
    tab.press("Simulate")
    tab.wait(lambda: tab.notifications, "a notification")
    assert tab.notifications[0] == ("Corrected", told)
    tab.wait_for_status("Landed")


def test_plots_gain_a_curve(tab, session):
    planned = charts(tab)
    assert all(curves(chart) == ["plan"] for chart in planned.values())
    simulate(tab, session)
    tab.wait(lambda: "simulation" in curves(charts(tab)["CoM position, z [m]"]), "a curve")
    assert charts(tab).keys() == planned.keys()
