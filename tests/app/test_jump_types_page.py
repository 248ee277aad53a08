"""Jump types in a real browser: chosen by their titles, with the controls they need."""

from __future__ import annotations

import pytest
from playwright.sync_api import expect

from tests.app.chromium import choose, status, wait_until

pytestmark = pytest.mark.browser


def slider(page, label):
    """Its label; the name of a type may be the same words."""
    return page.locator("label").get_by_text(label, exact=True)


def number(page, label):
    row = slider(page, label).locator("xpath=ancestor::div[.//input][1]")
    return row.locator("input").last


def test_a_type_brings_its_sliders_and_names_its_phases(page):
    expect(page.get_by_label("Jump type", exact=True)).to_have_value("All feet together")
    assert slider(page, "Hops").count() == 0
    choose(page, "Jump type", "Hops")
    slider(page, "Hops").wait_for()
    wait_until(lambda: page.session.plan.jump.hops == 2, "two hops")
    number(page, "Hops").fill("3")
    wait_until(lambda: page.session.plan.jump.hops == 3, "three hops")
    status(page, "Planned")
    strip = page.locator("#llsrbm-transport .row .phase")
    push, fly = ["take-off · all feet", "rebound · all feet"], "flight · no foot"
    names = [push[0], fly, push[1], fly, push[1], fly, "landing · all feet"]
    wait_until(lambda: [piece.text_content() for piece in strip.all()] == names, "the phases")
    titles = [piece.get_attribute("title") for piece in strip.all()]
    assert titles[:2] == ["plan: take-off (standing: all feet)", "plan: flight (standing: no foot)"]


def test_feet_that_stand_are_named_where_it_is_some_of_them(page):
    choose(page, "Jump type", "Rear last")
    wait_until(lambda: page.session.plan.jump.type == "rear-last", "the plan")
    expect(slider(page, "Hops")).to_have_count(0)
    piece = page.locator('#llsrbm-transport [title="plan: rear push (standing: LH, RH)"]')
    expect(piece).to_have_text("rear push · LH, RH")


def test_a_flip_asks_which_turn(page):
    choose(page, "Robot", "Unitree Go2")
    # There is no plan while another robot is prepared.
    wait_until(lambda: page.session.plan and page.session.plan.jump.robot == "go2", "Go2's plan")
    status(page, "Planned")  # its jump types are offered
    choose(page, "Jump type", "Flip")
    turn = page.get_by_label("Turn", exact=True)
    expect(turn).to_have_value("back flip")
    choose(page, "Turn", "front flip")
    wait_until(lambda: page.session.plan.jump.pitch > 6, "the front flip")
    choose(page, "Jump type", "Run-up")
    expect(number(page, "Speed [m/s]")).to_have_value("0.5")
    expect(turn).to_have_count(0)
    wait_until(lambda: page.session.plan.jump.pitch == 0, "no flip any more")
