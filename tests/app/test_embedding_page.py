"""A replay in the frame of another page, and in a notebook: scripts control it."""

import contextlib
import functools
import http.server
import shutil
import threading

import pytest

from llsrbm.formats import export
from llsrbm.request.jump import Jump
from tests.app.axe import findings
from tests.app.chromium import visitor
from tests.app.synthetic_plan import synthetic_plan
from tests.app.waits import wait_until
from tests.llsrbm.synthetic_rollout import synthetic_rollout

pytestmark = pytest.mark.skipif(shutil.which("chromium") is None, reason="no Chromium")

OUTER = """<!doctype html><html lang="en"><title>A page</title>
<script>
  window.heard = [];
  addEventListener("message", ({ data }) => heard.push(data));
  const say = (llsrbm, value) =>
    document.querySelector("iframe").contentWindow.postMessage({ llsrbm, value }, "*");
  const latest = (kind) => heard.findLast(({ llsrbm }) => llsrbm === kind);
</script>
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A page with a replay in a frame, and another replay."""
    made = tmp_path_factory.mktemp("embedding")
    plan = synthetic_plan(Jump(robot="anymal", twist=1.0))
    export(plan, made / "jump.html", format="html", fps=20)
    export(synthetic_rollout(plan), made / "other.html", format="html", fps=20)
    frame = '<iframe src="jump.html" width="400" height="300"></iframe>'
    (made / "page.html").write_text(OUTER + frame, encoding="utf-8")
    (made / "notebook.html").write_text(OUTER + plan._repr_html_(), encoding="utf-8")
    return made


@pytest.fixture(scope="module")
def site(folder):
    """The folder's address on a server of this machine."""
    handler = functools.partial(http.server.SimpleHTTPRequestHandler, directory=folder)
    handler.log_message = lambda *_: None
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}"
    server.shutdown()


@pytest.fixture(scope="module", params=["disk", "server"])
def page(request, browser, folder):
    """Its tests share it: one that loads another motion comes after those of the first."""
    base = folder.as_uri() if request.param == "disk" else request.getfixturevalue("site")
    yield from shown(browser, f"{base}/page.html")


@pytest.fixture(scope="module")
def served(browser, site):
    yield from shown(browser, f"{site}/page.html")


def shown(browser, address):
    with contextlib.closing(visitor(browser)) as context:
        page, faults = context.new_page(), []
        page.on("pageerror", lambda error: faults.append(str(error)))
        page.goto(address)
        page.wait_for_function("latest('ready')?.end > 0")
        yield page
        assert faults == []


def test_it_plays_pauses_and_goes_where_it_is_sent(page):
    page.wait_for_function("latest('frame')?.playing")
    page.evaluate("say('pause')")
    page.wait_for_function("latest('frame').playing === false")
    for instant in (0.45, 0.1):
        page.evaluate("t => say('seek', t)", instant)
        page.wait_for_function("t => Math.abs(latest('frame')?.time - t) < 1e-6", arg=instant)
    page.evaluate("heard.length = 0, say('play')")
    page.wait_for_function("heard.filter(({ time }) => time > 0.1).length > 5")
    times = page.evaluate("heard.filter(({ llsrbm }) => llsrbm === 'frame').map((e) => e.time)")
    assert times == sorted(times)


def test_what_makes_no_sense_is_refused_with_a_reason(page):
    page.evaluate("say('pause')")
    for value in ("'soon'", "NaN", "undefined"):
        page.evaluate(f"heard.length = 0, say('seek', {value})")
        page.wait_for_function("latest('refused')?.why.startsWith('seek: expected seconds')")
    page.evaluate("heard.length = 0, say('load', 'javascript:alert(1)')")
    page.wait_for_function("latest('refused')?.why.startsWith('load: expected an address')")
    page.evaluate("say('constructor'), say('nosuch'), say('seek', 0.2)")
    page.wait_for_function("latest('frame')?.time === 0.2")


def test_another_motion_is_loaded_by_its_address(page):
    page.evaluate("heard.length = 0, say('load', 'other.html')")
    page.wait_for_function("latest('ready')?.end > 2")  # s; the first lasts 1.3


def test_a_script_of_the_same_origin_calls_it(served):
    served.evaluate("""() => {
      window.inner = document.querySelector("iframe").contentWindow;
      inner.addEventListener("llsrbm-frame", ({ detail }) => (window.told = detail.time));
      inner.llsrbm.replay.pause();
      inner.llsrbm.replay.seek(0.3);
    }""")
    served.wait_for_function("told === 0.3 && inner.llsrbm.replay.time === 0.3")
    assert not served.evaluate("inner.llsrbm.replay.playing")


@pytest.mark.parametrize("source", ["new ArrayBuffer(9)", "undefined", "new Blob(['<p>Hello'])"])
def test_bytes_of_something_else_are_refused_and_it_stays(served, source):
    served.evaluate(f"heard.length = 0, say('load', {source})")
    served.wait_for_function("latest('refused')?.why.endsWith('or the bytes of a replay')")
    served.evaluate("say('play')")
    served.wait_for_function("latest('frame')?.playing")


def test_another_motion_is_loaded_by_its_bytes(served):
    served.evaluate("""async () => {
      const bytes = await (await fetch("other.html")).arrayBuffer();
      heard.length = 0;
      say("load", bytes);
    }""")
    served.wait_for_function("latest('ready')?.end > 2")


def test_a_notebook_shows_it_in_a_frame_that_cannot_reach_the_notebook(browser, site):
    for page in shown(browser, f"{site}/notebook.html"):
        (_, frame) = page.frames
        assert frame.evaluate("window.origin") == "null"
        frame.wait_for_function("llsrbm.player.frames > 5")
        assert page.get_by_text("anymal, plan of twist 1: a replay of 1.").count() == 1
        page.evaluate("heard.length = 0, say('load', new Uint8Array(3))")
        page.wait_for_function("latest('refused')")


@pytest.fixture(scope="module")
def replay(browser, folder):
    with contextlib.closing(visitor(browser)) as context:
        page = context.new_page()
        page.goto((folder / "other.html").as_uri())
        page.wait_for_function("window.llsrbm?.player.clip")
        page.evaluate("llsrbm.replay.pause()")
        yield page


def test_its_charts_are_of_plan_and_simulation_and_go_where_they_are_pressed(replay):
    charts = replay.locator("#llsrbm-charts figure")
    titles = charts.locator("b").all_inner_texts()
    assert [title.split(" [")[0] for title in titles][:3] == [
        "Base angle, yaw",
        "Angular velocity, z",
        "Inertia, zz",
    ]
    for number in range(charts.count()):
        assert charts.nth(number).locator("path").count() >= 2
    area = charts.first.locator(".area").bounding_box()
    first = charts.first.locator("figcaption").inner_text()
    replay.mouse.click(area["x"] + 0.5 * area["width"], area["y"] + 20)
    ends = replay.evaluate("[llsrbm.replay.time, llsrbm.replay.end]")
    assert ends[0] == pytest.approx(0.5 * ends[1], abs=0.1 * ends[1])
    wait_until(lambda: charts.first.locator("figcaption").inner_text() != first, "its values")
    first = charts.first.locator("figcaption").inner_text()
    replay.evaluate("llsrbm.replay.seek(llsrbm.replay.end)")
    wait_until(lambda: charts.first.locator("figcaption").inner_text() != first, "other values")


def test_it_can_be_read(replay):
    assert findings(replay) == []
    sizes = replay.evaluate(
        """() => [...document.querySelectorAll("#llsrbm-transport *")].filter(e => e.innerText)
          .map(e => parseFloat(getComputedStyle(e).fontSize))"""
    )
    assert min(sizes) >= 12
