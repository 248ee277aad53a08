"""What the design controls tell, whatever a tab sends."""

import pytest

from app.panel.file_controls import FileChoice
from app.workers.opened_file import uploaded_design
from llsrbm.errors import InputError
from llsrbm.request.design import Design, dump_design
from llsrbm.request.jump import Jump
from llsrbm.robots import names
from tests.app.design_page import design_page
from tests.app.raw_tab import RawTab

ROBOTS = ", ".join(names())


@pytest.fixture(scope="module")
def page():
    with design_page() as running:
        yield running


@pytest.fixture
def tab(page):
    with RawTab(page.port) as opened:
        opened.client, opened.controls_of_page = page.tabs.get(timeout=20)
        opened.control("Save design")
        yield opened


def html(tab):
    found = [m["props"] for m in tab.controls.values() if m["type"] == "GuiHtmlMessage"]
    return found[1]  # after the one that says what is being saved


def test_what_is_shown_has_its_note(tab):
    tab.controls_of_page.show("a <b> & note", FileChoice(), "")
    tab.wait(lambda: html(tab)["visible"], "the note")
    assert "a &lt;b&gt; &amp; note" in html(tab)["content"]
    tab.controls_of_page.show("", FileChoice(), "")
    tab.wait(lambda: not html(tab)["visible"], "no note")


@pytest.mark.parametrize(
    ("jump", "complaint"),
    [
        (
            Jump(robot="/tmp/mine.toml"),
            f"a.json: jump.robot: expected one of {ROBOTS}",
        ),
        (
            Jump(robot="nosuch"),
            f"a.json: jump.robot: expected one of {ROBOTS}, got 'nos",
        ),
        (Jump(model="nosuch"), "a.json: jump.model: expected one of srbm, llsrbm, llsrbm-plus,"),
    ],
)
def test_only_what_the_page_has_can_be_uploaded(jump, complaint):
    with pytest.raises(InputError) as refused:
        uploaded_design("a.json", dump_design(Design(jump)).encode())
    assert str(refused.value).startswith(complaint)


def test_a_refusal_names_the_file():
    with pytest.raises(InputError, match=r"^cat\?\.json: not a JSON file: Expecting value"):
        uploaded_design("cat\n.json", b"meow")
