"""The page in a real browser."""

from __future__ import annotations

import re

import numpy as np
import pytest

import llsrbm
from app.server.server import Designer
from tests.app import planners
from tests.app.chromium import (
    PACE,
    blue,
    chromium,
    dark,
    fill,
    green,
    opened,
    paused_at,
    picture,
    player,
    status,
    wait_until,
)

pytestmark = pytest.mark.browser


@pytest.fixture(scope="module")
def browser():
    with chromium() as started:
        yield started


@pytest.fixture
def page(browser, designer):
    page = opened(browser, designer.url)
    status(page, "Planned")
    # It has the colours of the marks and of the ellipsoids.
    page.get_by_label("Landing handle").uncheck()
    page.wait_for_timeout(PACE)
    yield page
    assert page.faults == []
    page.context.close()


def test_the_robot_is_visible(page):
    wait_until(lambda: dark(picture(page)).sum() > 3000, "dark pixels")


def test_controls_are_found_by_the_contracts_labels(page):
    labels = ("Robot", "Model", "Format", "Inertia ellipsoids", "Half board", "Disturb", "Seed")
    sliders = ("Twist [deg]", "Forward [m]", "Lateral [m]", "Landing height [m]", "Board [mm]")

    def check():
        for label in labels:
            assert page.get_by_label(label).count() == 1, label
        for name in ("Simulate", "Cancel", "Play", "Pause", "Export"):
            assert page.get_by_role("button", name=name).count() == 1, name
        for label in sliders:
            assert page.get_by_text(label, exact=True).count() == 1, label

    check()
    # Ghost and blocks are further names in viser's scene tree.
    fill(page, "Board [mm]", 25)
    page.get_by_role("button", name="Simulate").click()
    status(page, "Landed")
    check()


def test_a_slider_shows_a_new_plan(page, designer):
    paused_at(page, 0.0)
    wait_until(lambda: green(picture(page)).sum() > 200, "the marks")
    before = green(picture(page))
    fill(page, "Twist [deg]", 0)
    fill(page, "Forward [m]", 0.5)
    session = designer.sessions[-1]
    wait_until(lambda: session.plan.jump.forward == 0.5, "the plan")
    status(page, "Planned")
    # The camera looks along +y from the right: forward is to the right in the picture.
    right = np.nonzero(before)[1].max() + 60
    wait_until(
        lambda: np.nonzero(green(picture(page)))[1].max(initial=0) > right, "the marks there"
    )


def test_it_plays_pauses_and_plays(page):
    page.get_by_role("button", name="Pause").click()
    wait_until(lambda: not player(page, "playing"), "a pause")
    page.wait_for_timeout(2000)
    still = picture(page)
    page.wait_for_timeout(500)
    assert np.abs(picture(page) - still).max() == 0
    page.get_by_role("button", name="Play").click()
    wait_until(lambda: np.abs(picture(page) - still).max() > 50, "motion")


def test_ellipsoids_come_and_go(page):
    paused_at(page, 0.0)
    tinted = blue(picture(page)).sum()
    assert tinted > 5000
    page.get_by_label("Inertia ellipsoids").uncheck()
    wait_until(lambda: blue(picture(page)).sum() < tinted / 3, "no ellipsoid")
    page.wait_for_timeout(PACE)
    page.get_by_label("Inertia ellipsoids").check()
    wait_until(lambda: blue(picture(page)).sum() > tinted / 2, "the ellipsoid again")


def test_a_model_is_chosen(page, designer):
    page.get_by_label("Model").click()
    page.get_by_role("option", name="srbm", exact=True).click()
    session = designer.sessions[-1]
    wait_until(lambda: session.plan.jump.model == "srbm", "the plan")


def choose(page, session, robot):
    page.get_by_label("Robot").click()
    page.get_by_role("option", name=robot, exact=True).click()
    wait_until(lambda: session.plan and session.plan.jump.robot == robot, f"a plan of {robot}")
    status(page, "Planned")


def extent(page):
    """Width and height of what is nearly black, pixels."""
    rows, columns = np.nonzero(dark(picture(page)))
    return np.ptp(columns), np.ptp(rows)


def test_robots_take_turns(page, designer):
    session = designer.sessions[-1]
    choose(page, session, "slider")
    paused_at(page, 0.0)
    # Its legs are black, and so is most of ANYmal.
    width, height = extent(page)
    assert height > max(200, 1.5 * width)
    assert green(picture(page)).sum() > 200
    page.get_by_role("button", name="Simulate").click()
    status(page, "Landed")
    page.wait_for_timeout(PACE)
    choose(page, session, "anymal")
    paused_at(page, 0.0)
    width, height = extent(page)
    assert width > 0.8 * height > 100
    assert session.rollout is None


def test_export_downloads_what_is_shown(page, designer, tmp_path):
    with page.expect_download() as download:
        page.get_by_role("button", name="Export").click()
    path = tmp_path / download.value.suggested_filename
    download.value.save_as(path)
    assert path.name == "anymal-llsrbm-plus-plan.npz"
    assert llsrbm.load(path).jump == designer.sessions[-1].plan.jump


def test_simulate_shows_the_whole_robot_beside_the_plan(page):
    page.get_by_role("button", name="Simulate").click()
    assert status(page, "Landed").startswith("Landed yaw -2.9° from the plan at touch-down")
    # In mid-flight the made-up simulation is 9 cm above the plan: the ghost stands out.
    paused_at(page, 0.65)
    assert page.locator('[title="simulation: force control"]').is_visible()
    tinted = 0.95 * blue(picture(page)).sum()
    page.get_by_label("Inertia ellipsoids").uncheck()
    page.wait_for_timeout(PACE)
    wait_until(lambda: 10_000 < blue(picture(page)).sum() < tinted, "the ghost, no ellipsoid")
    page.get_by_label("Ghost").uncheck()
    wait_until(lambda: blue(picture(page)).sum() < 6000, "no ghost")
    page.wait_for_timeout(PACE)
    page.get_by_label("Ghost").check()
    wait_until(lambda: blue(picture(page)).sum() > 10_000, "the ghost again")


def test_cancel_ends_a_simulation(page, designer):
    page.get_by_label("Disturb").check()
    page.wait_for_timeout(PACE)
    page.get_by_label("Seed").fill(str(planners.SLOWLY))
    page.wait_for_timeout(PACE)
    page.get_by_role("button", name="Simulate").click()
    page.get_by_text(re.compile("^Simulating \\d+%$")).wait_for()
    page.get_by_role("button", name="Cancel").click()
    status(page, "Cancelled")
    assert designer.sessions[-1].rollout is None


def test_a_crash_is_told_and_the_page_goes_on(page, capfd):
    fill(page, "Twist [deg]", round(np.degrees(planners.CRASH)))
    assert "was restarted" in status(page, "Failed")
    page.wait_for_timeout(PACE)
    fill(page, "Twist [deg]", 30)
    status(page, "Planned")


def test_with_the_real_planner(browser, tmp_path):
    designer = Designer(port=0)
    try:
        page = opened(browser, designer.url)
        text = status(page, "Planned", timeout=90_000)
        assert re.match(r"Planned in \d+ ms, \d+ iterations, largest violation ", text)
        fill(page, "Twist [deg]", 45)
        fill(page, "Forward [m]", 0.3)
        session = designer.sessions[-1]
        wait_until(lambda: session.plan.jump.forward == 0.3, "the plan")
        status(page, "Planned")
        plan = session.plan
        assert plan.solved
        assert plan.com[-1, :2] == pytest.approx([0.3, 0.0], abs=0.02)
        with page.expect_download() as download:
            page.get_by_role("button", name="Export").click()
        download.value.save_as(tmp_path / "plan.npz")
        assert llsrbm.load(tmp_path / "plan.npz").com.tolist() == plan.com.tolist()
        page.get_by_role("button", name="Simulate").click()
        status(page, "Landed", timeout=60_000)
        assert session.rollout.com[-1, :2] == pytest.approx(plan.com[-1, :2], abs=0.05)
        assert page.faults == []
        page.context.close()
    finally:
        designer.close()
