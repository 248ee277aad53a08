"""The last design comes back from the browser; nothing there stops the page."""

from __future__ import annotations

import time

import pytest

from app.session.stored_design import recall, remember
from llsrbm.design import Design, dump_design
from llsrbm.examples import examples
from llsrbm.jump import Jump
from tests.app.design_page import design_page
from tests.app.raw_tab import RawTab

BOX = examples()["slider-box"]


@pytest.fixture(scope="module")
def page():
    with design_page() as running:
        yield running


@pytest.fixture
def tab(page):
    with RawTab(page.port) as opened:
        opened.client, _ = page.tabs.get(timeout=20)
        yield opened


def test_the_last_design_comes_back(tab):
    for twist in (0.1, 0.2, 0.3):
        remember(tab.client, Design(Jump(twist=twist)))
    remember(tab.client, BOX)
    tab.wait(lambda: dump_design(BOX) in tab.storage.values(), "the design")
    complaints = []
    assert recall(tab.client, 5, complaints) == BOX
    assert complaints == []
    assert len(tab.storage) == 1


def test_a_browser_that_kept_nothing_is_no_complaint(tab):
    complaints = []
    assert recall(tab.client, 5, complaints) is None
    assert complaints == []


@pytest.mark.parametrize(
    ("kept", "complaint"),
    [
        ("[1, 2", "the design that this browser kept: not a JSON file: "),
        ("{}", "the design that this browser kept: not a design; expected an object"),
        (dump_design(Design(Jump(robot="gone"))), "kept: jump.robot: expected one of anymal"),
        ("x" * 100_000, "kept: too large for a design"),
    ],
)
def test_what_is_no_design_of_this_page_is_said(tab, kept, complaint):
    remember(tab.client, BOX)
    tab.wait(lambda: tab.storage, "the design")
    tab.storage = dict.fromkeys(tab.storage, kept)
    complaints = []
    assert recall(tab.client, 5, complaints) is None
    assert complaint in complaints[0]
    assert len(complaints) == 1


@pytest.mark.parametrize("value", [7, ["a"], {}, True])
def test_what_a_script_answers_is_nothing(tab, value):
    remember(tab.client, BOX)
    tab.wait(lambda: tab.storage, "the design")
    tab.storage = dict.fromkeys(tab.storage, value)
    complaints = []
    assert recall(tab.client, 5, complaints) is None
    assert complaints == []


def test_a_browser_that_forbids_storage_answers_at_once(tab):
    tab.storage_error = "The operation is insecure."
    remember(tab.client, BOX)
    start = time.monotonic()
    assert recall(tab.client, 5, []) is None
    assert time.monotonic() - start < 1


def test_a_browser_that_does_not_answer_is_not_waited_for(tab, monkeypatch):
    monkeypatch.setattr(tab, "send", lambda message: None)
    start = time.monotonic()
    assert recall(tab.client, 0.2, []) is None
    assert time.monotonic() - start < 1


@pytest.mark.filterwarnings("ignore:Queued a .* on a closed connection")
def test_a_tab_that_has_gone_is_not_waited_for(page):
    with RawTab(page.port) as gone:
        client, _ = page.tabs.get(timeout=20)
        gone.send = lambda message: None
    start = time.monotonic()
    assert recall(client, 60, []) is None
    assert time.monotonic() - start < 10
