"""Files in a real Chromium."""

import contextlib
import random
import threading
from pathlib import Path

import pytest

from app.guard.limits import MAX_UPLOAD
from app.workers.opened_file import uploaded_design
from llsrbm.request.design import dump_design, examples
from tests.app.chromium import PACE, drop, fill, visitor
from tests.app.design_page import design_page

HUGE = 100_000_000  # bytes


@pytest.fixture(scope="module")
def server():
    with design_page() as running:
        yield running


@pytest.fixture(scope="module")
def huge(tmp_path_factory):
    path = tmp_path_factory.mktemp("files") / "huge.json"
    with path.open("wb") as file:
        file.truncate(HUGE)
    yield path
    path.unlink()


@contextlib.contextmanager
def opened(browser, server):
    page = visitor(browser).new_page()
    page.goto(f"http://127.0.0.1:{server.port}")
    page.get_by_role("button", name="Save design").wait_for(timeout=20_000)
    yield page
    page.context.close()


@pytest.fixture(scope="module")
def page(browser, server):
    with opened(browser, server) as one:
        yield one


def resident():
    """Memory of this process, in which the server runs, bytes."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return 4096 * pages


@contextlib.contextmanager
def growth():
    """A list that holds, afterwards, by how much this process grew at most, bytes."""
    before, most, done = resident(), [0], threading.Event()

    def watch():
        while not done.wait(0.01):
            most[0] = max(most[0], resident() - before)

    watching = threading.Thread(target=watch)
    watching.start()
    try:
        yield most
    finally:
        done.set()
        watching.join()


def move_slider(page, server, value):
    fill(page, "Twist [deg]", value)
    assert server.next() == ("slider", value)


def test_a_design_is_opened_and_saved_by_hand(page, server, tmp_path):
    design = examples()["go2-twist"]
    path = tmp_path / "mine.jump.json"
    path.write_text(dump_design(design))
    page.locator("input[type=file]").set_input_files(path)
    kind, name, content = server.next()
    assert (kind, name) == ("upload", "mine.jump.json")
    assert uploaded_design(name, content) == design
    page.wait_for_timeout(PACE)
    page.get_by_role("button", name="Save design").click()
    assert server.next() == ("save",)


def test_100_mb_are_not_even_sent(page, server, huge):
    with growth() as grown:
        page.locator("input[type=file]").set_input_files(huge)
        page.get_by_text("huge.json: too large; expected at most 20 MB").wait_for()
        page.get_by_text("Uploading huge.json").wait_for(state="detached", timeout=5000)
    assert grown[0] < 20e6
    move_slider(page, server, 30)
    assert page.get_by_role("button", name="Open").is_enabled()


def test_a_file_of_the_largest_size_comes_whole(page, server, tmp_path):
    path = tmp_path / "some.npz"
    path.write_bytes(random.Random(1).randbytes(MAX_UPLOAD))
    page.locator("input[type=file]").set_input_files(path)
    kind, name, content = server.next()
    assert (kind, name, content == path.read_bytes()) == ("upload", "some.npz", True)
    page.wait_for_timeout(PACE)


def test_a_file_is_dropped_anywhere(page, server):
    for where in ("canvas", "#root", "[role=slider]"):
        drop(page, "dropped.json", b"{}", where)
        assert server.next() == ("upload", "dropped.json", b"{}")
        page.wait_for_timeout(PACE)
    veil = page.locator("#llsrbm-drop")
    drop(page, "held.json", b"{}", "canvas", let_go=False)
    assert veil.is_visible()
    page.evaluate("dispatchEvent(new DragEvent('dragleave', {relatedTarget: null}))")
    assert not veil.is_visible()
    # What is no file is the page's own business.
    page.evaluate("dispatchEvent(new DragEvent('drop', {dataTransfer: new DataTransfer()}))")
    move_slider(page, server, 35)
