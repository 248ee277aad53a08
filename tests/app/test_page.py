"""The page in a real browser."""

import re

import numpy as np
import pytest

import llsrbm
from app.designer import Designer
from tests.app.chromium import (
    PIXELS,
    at_rest,
    base_node,
    fill,
    green,
    opened,
    paused_at,
    picture,
    player,
    press,
    status,
    tab,
    tick,
    unfold,
)
from tests.app.waits import wait_until


@pytest.fixture
def page(page):
    # It has the colours of the marks and of the ellipsoids.
    tick(page, "Landing handle", ticked=False)
    return page


def test_controls_are_found_by_the_contracts_labels_and_the_whole_robot_is_shown(page):
    labels = {
        "": ("Robot", "Model", "Format"),
        "View": ("Inertia ellipsoids",),
        "Scenario": ("Half board", "Disturb", "Seed"),
    }
    sliders = {
        "": ("Twist [deg]", "Forward [m]", "Lateral [m]", "Landing height [m]"),
        "Scenario": ("Board under the feet [mm]",),
    }

    def check():
        for name in ("", "View", "Scenario"):
            if name:
                (unfold if name == "Scenario" else tab)(page, name)
            for label in labels[name]:
                assert page.get_by_label(label, exact=True).count() == 1, label
            for label in sliders.get(name, ()):
                assert page.get_by_text(label, exact=True).count() == 1, label
        for name in ("Simulate", "Export", "Pause" if player(page, "playing") else "Play"):
            assert page.get_by_role("button", name=name, exact=True).count() == 1, name

    check()
    # Ghost and blocks are further names in viser's scene tree.
    fill(page, "Board under the feet [mm]", 25)
    press(page, "Simulate")
    assert status(page, "Landed").startswith("Landed\nYaw error\n−2.9°")
    check()
    ellipsoids_and_ghost_come_and_go(page)


def ellipsoids_and_ghost_come_and_go(page):
    # In mid-flight the made-up simulation is 9 cm above the plan: the ghost stands out.
    paused_at(page, 0.65)
    assert page.locator('[title="simulation: force control"]').is_visible()

    def show(*layers):
        for layer in ("Inertia ellipsoids", "Ghost"):
            tick(page, layer, ticked=layer in layers)
        at_rest(page)

    show()
    without = picture(page)
    show("Inertia ellipsoids")
    wait_until(lambda: changed(without, picture(page)) > 2000, "its rings")
    show("Ghost")
    wait_until(lambda: changed(without, picture(page)) > 2500, "the ghost")
    show()
    wait_until(lambda: changed(without, picture(page)) < 500, "neither rings nor ghost")


def marks_beside_the_robot(page):
    """Pixels from the robot, which is at its start, to the rightmost landing mark."""
    ((base, _),) = page.evaluate(PIXELS, [base_node(page), [0, 0, 0]])
    return np.nonzero(green(picture(page)))[1].max(initial=0) - base


def test_a_slider_shows_a_new_plan(page):
    tick(page, "Landing handle")
    paused_at(page, 0.0)
    wait_until(lambda: green(picture(page)).sum() > 200, "the marks")
    before = marks_beside_the_robot(page)
    fill(page, "Twist [deg]", 0)
    fill(page, "Forward [m]", 0.5)
    session = page.session
    wait_until(lambda: session.state.plan.jump.forward == 0.5, "the plan")
    status(page, "Feasible")
    # The camera looks along +y from the right: forward is to the right in the picture.
    wait_until(lambda: marks_beside_the_robot(page) > before + 60, "the marks there")


def test_it_plays_pauses_and_plays(page):
    press(page, "Play")
    wait_until(lambda: player(page, "time") > 0.1, "motion")
    press(page, "Pause")
    wait_until(lambda: not player(page, "playing"), "a pause")
    at_rest(page)
    still = picture(page)
    assert np.abs(picture(page) - still).max() == 0
    press(page, "Play")
    wait_until(lambda: np.abs(picture(page) - still).max() > 50, "motion")


def changed(one, other):
    """How many pixels differ."""
    return int((np.abs(one - other).max(axis=2) > 8).sum())


@pytest.mark.nightly
def test_with_the_real_planner(browser, tmp_path):
    designer = Designer(port=0, token="none")
    try:
        page = opened(browser, designer.url)
        text = status(page, "Feasible", timeout=180_000)  # builds two solvers where none is kept
        session = designer.sessions[-1]
        assert re.match(
            r"Feasible 13/13 checks\s+Yaw inertia Izz, flight\s+[+−]?\d+ %\s+"
            r"Flight time\s+0\.\d+ s\s+Planned torque\s+\d+ %\s+Model's turn error\s+[+−]?\d\.\d°",
            text,
        )
        fill(page, "Twist [deg]", 45)
        fill(page, "Forward [m]", 0.3)
        wait_until(lambda: session.state.plan.jump.forward == 0.3, "the plan")
        status(page, "Feasible")
        plan = session.state.plan
        assert plan.solved
        assert plan.com[-1, :2] == pytest.approx([0.3, 0.0], abs=0.02)
        with page.expect_download() as download:
            page.get_by_role("button", name="Export", exact=True).click()
        download.value.save_as(tmp_path / "plan.npz")
        assert llsrbm.load(tmp_path / "plan.npz").com.tolist() == plan.com.tolist()
        press(page, "Simulate")
        status(page, "Landed", timeout=60_000)
        assert session.state.rollout.com[-1, :2] == pytest.approx(plan.com[-1, :2], abs=0.05)
        assert page.faults == []
        page.context.close()
    finally:
        designer.close()
