"""The guarded page in a real Chromium, off loopback: entering, its content policy, other sites."""

import contextlib
import http.server
import socket
import threading

import pytest

from app.designer import Designer
from llsrbm.look.visuals import link_visuals
from llsrbm.robots import load_robot
from tests.app.chromium import dark, picture, status, visitor
from tests.app.planners import SyntheticPlanner
from tests.app.waits import wait_until

FRAGMENT = "#design=abc"


@pytest.fixture(scope="module")
def designer():
    running = Designer("0.0.0.0", 0, planner=SyntheticPlanner)
    yield running
    running.close()


@pytest.fixture(scope="module")
def other_site():
    """`serve(html)` makes it the page of another site, and returns its address."""
    pages = []

    class Handler(http.server.BaseHTTPRequestHandler):
        def do_GET(self):
            self.send_response(200)
            self.send_header("Content-Type", "text/html")
            self.end_headers()
            self.wfile.write(pages[-1].encode())

        def log_message(self, *_):
            pass

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()

    def serve(html):
        pages.append("<!doctype html>" + html)
        return f"http://localhost:{server.server_port}/"

    yield serve
    server.shutdown()
    server.server_close()


@pytest.fixture(scope="module")
def page(browser, designer):
    """A visitor's, who opened the address that was printed; with meshes from the start."""
    link_visuals(load_robot("anymal"), coarse=True)
    context = visitor(browser)
    context.grant_permissions(["clipboard-read", "clipboard-write"])
    page = context.new_page()
    page.console = []
    page.on("console", lambda message: page.console.append(message.text))
    page.goto(designer.url + FRAGMENT)
    status(page, "Feasible")
    page.evaluate("llsrbm.player.pause()")  # drawing takes the processor from all else
    yield page
    context.close()


@contextlib.contextmanager
def beside(page):
    """A further tab of the same visitor."""
    further = page.context.new_page()
    further.console = []
    further.on("console", lambda message: further.console.append(message.text))
    try:
        yield further
    finally:
        further.close()


def own(designer):
    return f"http://127.0.0.1:{designer.port}/"


def test_the_page_works_and_nothing_of_it_is_blocked(page, designer):
    status(page, "Feasible")
    assert page.url == own(designer)  # no token
    assert page.evaluate("window.llsrbmFragment") == FRAGMENT  # what the link was about
    wait_until(lambda: dark(picture(page)).sum() > 3000, "the robot")
    with page.expect_download() as download:
        page.get_by_role("button", name="Export", exact=True).click()
    assert download.value.suggested_filename.endswith(".npz")
    page.evaluate("navigator.clipboard.writeText('a link')")
    assert page.evaluate("navigator.clipboard.readText()") == "a link"
    assert not [text for text in page.console if "Security Policy" in text or "policy" in text]


def test_a_reload_needs_no_token(page, designer):
    assert page.request.get(own(designer)).status == 200
    assert page.evaluate("document.cookie") == ""  # scripts do not see it


def elsewhere_asked(browser, designer, patience, **options):
    """Whether a page connects to another server, which its address names."""
    with socket.create_server(("127.0.0.1", 0)) as listener:
        elsewhere = f"127.0.0.1:{listener.getsockname()[1]}"
        context = visitor(browser, **options)
        context.request.get(designer.url)  # enters, by a cookie
        page = context.new_page()
        page.goto(f"{own(designer)}?websocket=ws://{elsewhere}")
        attempts = f"""() => {{
          fetch("http://{elsewhere}/").catch(() => 0);
          new Image().src = "http://{elsewhere}/x.png";
          const script = document.createElement("script");
          script.src = "http://{elsewhere}/x.js";
          document.head.append(script);
        }}"""
        page.evaluate(attempts)
        listener.settimeout(patience)
        try:
            listener.accept()[0].close()
        except TimeoutError:
            return False
        finally:
            context.close()
        return True


def test_the_page_talks_to_nobody_else(browser, designer):
    assert elsewhere_asked(browser, designer, 60.0, bypass_csp=True)
    assert not elsewhere_asked(browser, designer, 2.0)


@pytest.mark.parametrize("address", ["{url}", "{own}"])
def test_a_link_on_another_site_leads_to_the_page(page, designer, other_site, address):
    address = address.format(url=designer.url, own=own(designer)) + FRAGMENT
    with beside(page) as further:
        further.goto(other_site(f'<a href="{address}">jumps</a>'))
        further.get_by_text("jumps").click()
        further.get_by_role("status").wait_for(timeout=60_000)
        assert further.url == own(designer)
        assert further.evaluate("window.llsrbmFragment") == FRAGMENT


def test_another_visitor_stays_outside_and_a_link_leads_him_to_the_hint(
    browser, designer, other_site
):
    context = visitor(browser)
    page = context.new_page()
    assert page.goto(own(designer)).status == 401
    assert "?token=" in page.inner_text("body")
    page.goto(other_site(f'<a href="{own(designer)}">jumps</a>'))
    page.get_by_text("jumps").click()
    page.get_by_text("?token=").wait_for()
    assert page.locator("canvas").count() == 0
    context.close()


def test_another_site_neither_frames_nor_reads_nor_connects(page, designer, other_site):
    address = own(designer)
    with beside(page) as further:
        further.goto(other_site(f'<iframe src="{address}"></iframe>'))
        wait_until(lambda: any("frame" in text.lower() for text in further.console), "a refusal")
        outcome = further.evaluate(
            """address => new Promise(async (done) => {
              const read = await fetch(address, {mode: "no-cors", credentials: "include"})
                .then(() => "read", () => "refused");
              const socket = new WebSocket(address.replace("http", "ws"));
              socket.onopen = () => done([read, "open"]);
              socket.onerror = () => done([read, "refused"]);
            })""",
            address,
        )
        assert outcome == ["refused", "refused"]
