"""A page that tests share, and how it is brought back to where each of them begins."""

import math

from app.link import BesideChosen
from app.panel.acts import Act
from app.panel.view_controls import View
from app.picture.overlays import AT_FIRST
from app.plots.choice import DEFAULT
from app.tab.planning.refining import WholeBody
from app.tab.simulating import Automatically
from app.tab.start.opening import TabOpened, first_state
from tests.app.chromium import BASE, PACE, VIEW, number, opened, status, tab
from tests.app.synthetic_plan import refined_plan, synthetic_plan
from tests.app.waits import wait_until


def visit(browser, designer, view=VIEW, **options):
    """A page of a new visitor with the first motion in it; `session` is the server's side of it."""
    before = designer.sessions
    page = opened(browser, designer.url, view, **options)
    try:
        shows_motion(page)
        # The server's word to play comes after the clip: a test that pauses before it would see the
        # motion run all the same.
        page.wait_for_function("llsrbm.player.playing")
    except BaseException:
        page.context.close()  # it would play on beside all later tests, and keep them waiting
        raise
    (page.session,) = [each for each in designer.sessions if each not in before]
    page.designer, page.beginning = designer, None
    return page


def shows_motion(page):
    """Wait until there is a robot that can be played."""
    status(page, "Feasible")
    page.wait_for_function(f"window.__viserMutable?.nodePoseData?.['{BASE}'] && llsrbm.player.clip")


def find_session(page):
    """The server's side of a page that has got another connection meanwhile."""
    token = page.session.token

    def found():
        return [s for s in page.designer.sessions if s.token == token and s is not page.session]

    wait_until(found, "the page's next session")
    (page.session,) = found()
    return page.session


_AT_REST = """() => {
  document.activeElement?.blur();
  document.querySelectorAll(".mantine-Notification-closeButton").forEach((each) => each.click());
  document.querySelectorAll(".mantine-Paper-root > .mantine-Paper-root[aria-expanded=true]")
    .forEach((title) => title.click());
  document.querySelector("#llsrbm-part [aria-label='Close the part']")?.click();
  document.querySelectorAll(".mantine-ScrollArea-viewport").forEach((each) => each.scrollTo(0, 0));
  const { player, camera } = llsrbm;
  player.pause();
  player.setLoop(true);
  player.setRange(null);
  player.setSpeed(1);
  player.seek(0);
  camera.setFollows(false);
  camera.look("all", false);
}"""


def fresh(page):
    """The page as each test begins, see `_begin`; nothing goes wrong in it."""
    _begin(page)
    yield page
    page.evaluate("llsrbm.player.pause()")  # playing takes the processor from others
    faults = page.faults[:]
    page.faults.clear()
    assert not faults, faults  # said here: pytest explains only the asserts of test modules


def _begin(page):
    """Bring a page that tests share to where each of them begins, without opening it anew.

    The example of the first robot is shown, paused at its start; nothing is pinned. Designs to go
    back to are left, and what is chosen for an export.
    """
    session = page.session
    if session not in page.designer.sessions:  # the connection was lost in another test
        session = find_session(page)
    if page.viewport_size != VIEW:
        page.set_viewport_size(VIEW)
    page.evaluate(
        "llsrbm.player.pause(),"
        " document.querySelectorAll('dialog[open]').forEach((dialog) => dialog.close())"
    )
    tab(page, "View")
    page.mouse.move(10, 10)
    page.wait_for_timeout(PACE)  # whatever the test before has changed last arrives
    if _facts(session) != page.beginning:
        _open_example(page, session)
        page.beginning = _facts(session)
    page.evaluate(_AT_REST)


def _facts(session):
    """Of a tab, all that `_open_example` puts back."""
    state = session.state
    return (
        *(session, state.shown, state.design, state.pins, state.comparing, state.beside),
        *(state.view, state.plots, state.whole_body, state.automatically),
    )


def _open_example(page, session):
    design = first_state(session.state.robots).design
    plan = refined_plan(synthetic_plan(design.jump))
    for event in (
        BesideChosen(False),
        *[Act.UNPIN] * len(session.state.pins),
        Automatically(False),
        WholeBody(True),
        View(AT_FIRST, night=False),
        DEFAULT,
        design,
        TabOpened(design, plan, None, ()),
    ):
        session._inbox.put(event)
    wait_until(
        lambda: session.state.plan is plan and session.state.rollout is None, "the example's plan"
    )
    status(page, "Feasible")
    page.wait_for_function(
        "([robot, twist, end]) => { const { request, end: last } = llsrbm.player.clip;"
        " return request.robot === robot && Math.abs(request.twist - twist) < 1e-6"
        " && Math.abs(last - end) < 1e-6; }",
        arg=[design.jump.robot, design.jump.twist, plan.duration],
    )
    for label, value in (
        ("Twist [deg]", math.degrees(design.jump.twist)),
        ("Forward [m]", design.jump.forward),
    ):
        box = number(page, label)
        wait_until(
            lambda box=box, value=value: abs(float(box.input_value() or "nan") - value) < 0.01,
            f"the example's {label}",
        )
