"""A headless Chromium that renders the scene in software, and what to read off its pictures."""

import base64
import contextlib
import io
import re
import shutil

import numpy as np
from PIL import Image
from playwright.sync_api import TimeoutError as BrowserTimeout
from playwright.sync_api import sync_playwright

from app.tab.planning.requests import ANSWERS
from tests.app.waits import wait_until

FLAGS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)
VIEW = {"width": 1280, "height": 800}
PANEL_LEFT = 940  # pixels; the picture is to the left of it
NOTE = (330, 170)  # viser's note about software rendering covers this corner
BASE = "/links/base"  # of the first robot that a page draws
# of the panel; those below Details in one of its tabs
FOLDERS = (
    "Scenario",
    "Details",
    "More overlays",
    "Footholds",
    "Slopes",
    "Route",
    "Limits",
    "Atlas",
)
TAB_OF = {"More overlays": "View", "Several in one zip": "Files"}  # of folders; the others: More
COMPARE = "Results"  # the tab with pins
PACE = 80  # ms between inputs: the page sends at most one change every 50 ms

# Drawing in software takes a processor: the scene is drawn while a test looks at it, and only then.
ON_DEMAND = """
for (const name of ["clear", "drawElements", "drawArrays", "drawElementsInstanced",
  "drawArraysInstanced"]) {
  const draw = WebGL2RenderingContext.prototype[name];
  WebGL2RenderingContext.prototype[name] = function (...parameters) {
    if (!window.isLookedAt) return;
    if (name === "clear") window.pictures += 1;
    draw.apply(this, parameters);
  };
}
"""
DRAWN = """() => new Promise((done) => {
  window.isLookedAt = true;
  window.pictures = 0;
  const wait = () => {
    if (window.pictures > 2) return done();
    window.__viserMutable.requestRender();
    requestAnimationFrame(wait);
  };
  wait();
})"""
PAUSED = """(instant) => new Promise((done) => {
  const { player } = window.llsrbm;
  player.pause();
  player.seek(instant);
  const before = player.frames;
  const wait = () => (player.frames > before ? done() : requestAnimationFrame(wait));
  requestAnimationFrame(wait);
})"""

# Pixels of points (x, y, z) m in a node's own axes.
PIXELS = """([name, ...points]) => {
  const { camera, nodeRefFromName, canvas } = window.__viserMutable;
  const node = nodeRefFromName[name], box = canvas.getBoundingClientRect();
  camera.updateMatrixWorld();
  node.updateWorldMatrix(true, false);
  return points.map((point) => {
    const place = node.localToWorld(camera.position.clone().set(...point)).project(camera);
    return [box.left + (1 + place.x) / 2 * box.width, box.top + (1 - place.y) / 2 * box.height];
  });
}"""


@contextlib.contextmanager
def chromium():
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=list(FLAGS)
        )
        yield browser
        browser.close()


def visitor(browser, view=VIEW, **options):
    """A browser of its own, as it were, whose pages draw on demand."""
    context = browser.new_context(viewport=view, accept_downloads=True, **options)
    context.set_default_timeout(60_000)  # ms: where several browsers share a machine
    context.add_init_script(ON_DEMAND)
    return context


@contextlib.contextmanager
def looked_at(page):
    """What there is to see is drawn."""
    page.evaluate(DRAWN)
    yield
    page.evaluate("window.isLookedAt = false")


def opened(browser, url, view=VIEW, *, tour=False, **options):
    """A page of a new visitor, who asks no other host; `faults` are what went wrong in it.

    The tour has been seen, unless it is what is tested.
    """
    context = visitor(browser, view, **options)
    if not tour:
        context.add_init_script('localStorage.setItem("llsrbm.tour", "seen")')
    page = context.new_page()
    page.faults, page.heard = [], []
    page.on("pageerror", lambda error: page.faults.append(error.stack or str(error)))
    page.on(
        "request",
        lambda request: (
            None
            if request.url.startswith((url, "data:", "blob:"))
            else page.faults.append(f"request to {request.url}")
        ),
    )
    hear = lambda frame: page.heard.append(len(frame))  # noqa: E731
    page.on("websocket", lambda socket: socket.on("framereceived", hear))
    try:
        page.goto(url)
    except BaseException:
        context.close()  # it would go on loading beside all later tests, and keep them waiting
        raise
    return page


def tab(page, name):
    """Turn to a tab of the panel's details."""
    unfold(page, "Details")
    found = page.locator("[data-dock-area^=gui-tabs] [role=tab]").filter(has_text=_all_of(name))
    if found.get_attribute("aria-selected") != "true":
        found.click()
        page.wait_for_timeout(PACE)


def unfold(page, name):
    """Open a folder of the panel."""
    if name not in ("Scenario", "Details"):
        tab(page, TAB_OF.get(name, "More"))
    # By roles and names, which tests of the panel are about, it would take a tenth of a second.
    title = page.locator("[aria-expanded]").filter(has_text=_all_of(name))
    if title.get_attribute("aria-expanded") != "true":
        title.click()
        page.wait_for_timeout(PACE)


def _all_of(text):
    return re.compile(rf"^\s*{re.escape(text)}\s*$")


def press(page, name):
    page.get_by_role("button", name=name, exact=True).click()
    page.wait_for_timeout(PACE)


def choose(page, label, value):
    """Choose an option of a dropdown, opening it again where a redrawn panel has closed it."""
    box = page.get_by_label(label, exact=True)
    option = page.get_by_role("option", name=value, exact=True)

    def chosen():
        if not option.is_visible():
            box.click()
        try:
            option.click(timeout=2000)
        except BrowserTimeout:
            return False
        return True

    wait_until(chosen, f"the option {value}")
    page.wait_for_timeout(PACE)


def tick(page, label, ticked=True):
    """Tick a box of the tab View, or clear it."""
    tab(page, "View")
    box = page.get_by_label(label, exact=True)
    if not box.is_visible():
        unfold(page, "More overlays")
    box.set_checked(ticked)
    page.wait_for_timeout(PACE)


def player(page, what):
    """Something of the page's own player: `time`, `playing`, `play()` ..."""
    return page.evaluate(f"window.llsrbm.player.{what}")


def paused_at(page, instant):
    """Stop the motion at a time, s, and wait until the robot is there."""
    page.evaluate(PAUSED, instant)


def settled(page):
    """Wait until scripts have looked at a new layout, and nothing folds or fades any more."""
    page.wait_for_timeout(300)
    # A busy machine draws the new layout later than that; the scripts look 0.2 s after it.
    page.evaluate("new Promise((done) => requestIdleCallback(done, { timeout: 5000 }))")
    page.wait_for_function("!llsrbm.layout.pending")
    page.wait_for_function(
        "document.getAnimations().every((each) => each.playState !== 'running'"
        " || each.effect.getComputedTiming().endTime === Infinity)"
    )
    page.wait_for_timeout(50)


def at_rest(page):
    """Wait until the player moves nothing any more, and the picture is as fine as it gets."""
    fine = "() => (window.__viserTestpoints.devSettings.get().fixedDpr ?? 1) >= 1"
    page.wait_for_function(fine)
    before = None
    while (frames := page.evaluate("llsrbm.player.frames")) != before:
        before = frames
        page.wait_for_timeout(200)


def base_node(page):
    """Name of the base of the robot that is drawn solid, once it is drawn."""
    drawn = "() => window.__viserMutable.nodeRefFromName[llsrbm.camera.target?.follow]"
    page.wait_for_function(drawn)
    return page.evaluate("llsrbm.camera.target.follow")


def screenshot(page, **options):
    """(H, W, 3) of the page, the scene drawn."""
    with looked_at(page):
        content = page.screenshot(**options)
    return np.asarray(Image.open(io.BytesIO(content)).convert("RGB")).astype(int)


def picture(page):
    """(H, W, 3) of the scene, without the panel, the bar below and viser's note."""
    pixels = screenshot(page)[:, :PANEL_LEFT].copy()
    pixels[: NOTE[1], : NOTE[0]] = 255
    bar = page.locator("#llsrbm-transport").bounding_box()
    if bar is not None:
        pixels[int(bar["y"]) :] = 255
    return pixels


def dark(pixels):
    """Mask of what is darker than sky and floor: ANYmal's legs and trunk."""
    return pixels.max(axis=2) < 110


def green(pixels):
    """Mask of the landing marks' colour."""
    r, g, b = np.moveaxis(pixels, -1, 0)
    return (g > r + 50) & (g > b + 30)


def number(page, label):
    """The number field beside a slider; the thumb itself has no label."""
    row = page.get_by_text(label, exact=True).locator("xpath=ancestor::div[.//input][1]")
    return row.locator("input").last


def fill(page, label, value):
    number(page, label).fill(str(value))
    page.wait_for_timeout(PACE)


def status(page, word, timeout=60_000):
    """Wait for a status; an answer that is still being refined does not count."""
    state = '[aria-busy="false"]' if word.split()[0].rstrip(".,") in ANSWERS else ""
    line = page.locator(f'[role="status"]{state}').filter(has_text=re.compile(rf"^\s*{word}"))
    line.wait_for(timeout=timeout)
    text = line.inner_text()
    assert text.startswith(word)
    return text


_DROP = """([name, content, where, letGo]) => {
  const bytes = Uint8Array.from(atob(content), (c) => c.charCodeAt(0));
  const dataTransfer = new DataTransfer();
  dataTransfer.items.add(new File([bytes], name));
  const at = document.querySelector(where);
  const options = { dataTransfer, bubbles: true, cancelable: true };
  at.dispatchEvent(new DragEvent("dragover", options));
  if (letGo) at.dispatchEvent(new DragEvent("drop", options));
}"""


def drop(page, name, content, where="canvas", let_go=True):
    """Drag a file over the page and let go of it, as far as a script can."""
    page.evaluate(_DROP, [name, base64.b64encode(content).decode(), where, let_go])
