"""A page that is loaded anew, loses its connection, or its server, in a real browser."""

import contextlib
import re
import subprocess
import sys

import pytest

from tests.app.chromium import (
    COMPARE,
    fill,
    number,
    opened,
    player,
    press,
    status,
    tab,
    tick,
    visitor,
)
from tests.app.shared_page import find_session, fresh, shows_motion, visit
from tests.app.waits import wait_until

FORWARD = 0.3  # m, of the design that is found again
INSTANT = 0.65  # s, place on the timeline


@pytest.fixture(scope="module")
def own(browser, designer):
    """A page that may be loaded anew, for its tokens are in its own context."""
    page = visit(browser, designer)
    yield page
    page.context.close()


@pytest.fixture
def page(own):
    yield from fresh(own)


def plan_pin_and_simulate(page):
    """Leave something to be found again: a pin of the example, and a simulation of another jump."""
    tab(page, COMPARE)
    press(page, "Pin")
    fill(page, "Forward [m]", FORWARD)
    wait_until(lambda: page.session.state.plan.jump.forward == FORWARD, "the plan")
    status(page, "Feasible")
    press(page, "Simulate")
    status(page, "Landed")
    page.evaluate("t => { llsrbm.player.pause(); llsrbm.player.seek(t); }", INSTANT)
    wait_until(lambda: page.session.state.playback.time == pytest.approx(INSTANT), "the place")


def everything_is_there(page):
    session = find_session(page)
    # It is known by its token before its state is there.
    wait_until(lambda: session.state.rollout is not None, "the simulation")
    status(page, "Landed")
    assert session.state.plan.jump.forward == FORWARD
    assert len(session.state.pins) == 1
    wait_until(lambda: float(number(page, "Forward [m]").input_value()) == FORWARD, "the slider")
    page.wait_for_function("llsrbm.player.clip?.request.forward === 0.3")
    wait_until(lambda: player(page, "time") == pytest.approx(INSTANT), "the place")
    wait_until(lambda: player(page, "playing") is False, "a motion that stands")
    clip = "n => llsrbm.player.clip.channels.some(s => s.tracks.some(t => t.nodes.includes(n)))"
    page.wait_for_function(clip, arg="/pinned/1/base")
    page.locator('[title="simulation: force control"]').wait_for()
    tab(page, COMPARE)
    page.get_by_role("button", name="Unpin", exact=True).wait_for()


def test_everything_is_found_again(page, designer):
    """After a reload, a lost connection, and a crash, before which no page says good-bye."""
    plan_pin_and_simulate(page)
    page.reload()
    everything_is_there(page)
    designer._server._websock_server.disconnect_all_clients()
    everything_is_there(page)
    page.evaluate("window.addEventListener('pagehide', (e) => e.stopImmediatePropagation(), true)")
    page.reload()
    everything_is_there(page)


def test_a_link_opens_its_design_with_which_the_next_visit_begins_with_its_preferences(
    page, browser, designer
):
    fill(page, "Forward [m]", FORWARD)
    wait_until(lambda: page.session.state.plan.jump.forward == FORWARD, "the plan")
    press(page, "Share")
    dialog = page.get_by_role("dialog", name="Share this design")
    dialog.wait_for()
    address = dialog.get_by_label("Link").input_value()
    assert address.startswith(f"{designer.url.rstrip('/')}/#design=")
    dialog.get_by_role("button", name="Close").click()
    dialog.wait_for(state="hidden")
    with contextlib.closing(visitor(browser, color_scheme="dark")) as context:
        context.add_init_script('localStorage.setItem("llsrbm.tour", "seen")')
        first = design_opened(context, designer, address)
        first.locator(":root[data-mantine-color-scheme=dark]").wait_for(state="attached")
        tick(first, "Foot workspace")
        first.wait_for_function("localStorage.getItem('llsrbm.preferences')?.includes('reach')")
        first.close()
        later = design_opened(context, designer, designer.url)
        box = later.get_by_label("Foot workspace", exact=True)
        box.wait_for(state="attached")
        wait_until(box.is_checked, "the overlay")


def design_opened(context, designer, address):
    """A page of this address, once it shows the design."""
    before = designer.sessions
    page = context.new_page()
    page.goto(address)
    shows_motion(page)
    (session,) = [each for each in designer.sessions if each not in before]
    wait_until(lambda: session.state.plan.jump.forward == FORWARD, "the design of the link")
    assert "#" not in page.evaluate("location.href")  # a reload finds what came of it
    wait_until(
        lambda: re.search(
            rf"forward\W+{FORWARD}\b", page.evaluate("localStorage.getItem('llsrbm.design')")
        ),
        "the browser to keep it",
    )
    wait_until(lambda: float(number(page, "Forward [m]").input_value()) == FORWARD, "the slider")
    return page


# ---- the server


@contextlib.contextmanager
def serving(port=0):
    """A server in a process of its own; its port."""
    command, line = [sys.executable, "-m", "tests.app.served", str(port)], ""
    for _ in range(10):  # another connection may happen to use the port for a moment
        if not line:
            process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
            line = process.stdout.readline()
    try:
        yield process, int(line)
    finally:
        process.kill()
        process.wait()
        process.stdout.close()


@pytest.mark.nightly
def test_the_server_is_killed_and_the_page_goes_on_with_the_next_one(browser):
    with serving() as (process, port):
        page = opened(browser, f"http://127.0.0.1:{port}/")
        shows_motion(page)
        fill(page, "Forward [m]", FORWARD)
        page.wait_for_function("llsrbm.player.clip.request.forward === 0.3")
        wait_until(
            lambda: '"forward": 0.3' in page.evaluate("sessionStorage.getItem('llsrbm.design')"),
            "the browser to keep it",
        )
        status(page, "Feasible")  # until then another motion is to come from this server
        page.evaluate("llsrbm.player.pause(), llsrbm.player.seek(0.65)")
        page.evaluate("window.before = llsrbm.player.clip")
        process.kill()
        process.wait()
    with serving(port) as (_, again):
        assert again == port
        page.wait_for_function("llsrbm.player.clip !== window.before")
        status(page, "Feasible")
        wait_until(
            lambda: float(number(page, "Forward [m]").input_value()) == FORWARD, "the design"
        )
        page.wait_for_function("llsrbm.player.clip.request.forward === 0.3")
        wait_until(lambda: player(page, "time") == pytest.approx(INSTANT), "the place")
        wait_until(lambda: player(page, "playing") is False, "a motion that stands")
        # It plans and plays as before.
        fill(page, "Forward [m]", 0.1)
        page.wait_for_function("llsrbm.player.clip.request.forward === 0.1")
        press(page, "Play")
        wait_until(lambda: player(page, "time") > 0.7, "motion")
        assert page.faults == []
    page.context.close()


# ---- browsers that lack something

HIDDEN = """
let whole;
const without = { get: (owner, name) => name === "HIDDEN" ? undefined : Reflect.get(owner, name) };
Object.defineProperty(window, "__viserMutable", {
  get: () => whole,
  set: (value) => { whole = new Proxy(value, without); },
});
"""


def test_a_page_whose_viewer_lacks_a_field_says_so(browser, designer):
    context = visitor(browser)
    context.add_init_script(HIDDEN.replace("HIDDEN", "nodeRefFromName"))
    page = context.new_page()
    faults = []
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.goto(designer.url)
    page.get_by_text("This page cannot play").wait_for()
    page.get_by_text("Its viewer lacks __viserMutable.nodeRefFromName").wait_for()
    status(page, "Feasible")  # all else works
    assert faults == []
    context.close()


FORBIDS_STORAGE = """
for (const name of ["localStorage", "sessionStorage"])
  Object.defineProperty(window, name, {
    get() { throw new DOMException("denied", "SecurityError"); },
  });
"""


def test_a_browser_that_forbids_storage_works_without(browser, designer):
    context = visitor(browser)
    context.add_init_script(FORBIDS_STORAGE)
    page = context.new_page()
    faults = []
    page.on("pageerror", lambda error: faults.append(str(error)))
    before = designer.sessions
    page.goto(designer.url)
    shows_motion(page)
    (session,) = [each for each in designer.sessions if each not in before]
    fill(page, "Forward [m]", FORWARD)
    wait_until(lambda: session.state.plan.jump.forward == FORWARD, "the plan")
    assert player(page, "playing")
    assert faults == []
    context.close()
