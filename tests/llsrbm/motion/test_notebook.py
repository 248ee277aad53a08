"""A plan and a rollout in a notebook."""

import html
import re
from dataclasses import replace

import pytest

from llsrbm.errors import InputError
from llsrbm.motion import notebook
from tests.llsrbm.processes import printed
from tests.llsrbm.synthetic import synthetic_plan
from tests.llsrbm.synthetic_rollout import synthetic_rollout


class Page:
    """A format that writes a page of a size, or cannot."""

    suffix, defaults = ".html", None

    def __init__(self, text='<p>A "page" & more</p>', fault=None):
        self.text, self.fault = text, fault

    def load(self):
        return self

    def write(self, trajectory, path, options):
        if self.fault:
            raise self.fault
        path.write_text(self.text, encoding="utf-8")


@pytest.fixture
def installed(monkeypatch):
    """Choose what is found as format `html`."""
    return lambda *found: monkeypatch.setattr(notebook, "entry_points", lambda **_: found)


@pytest.fixture(params=["plan", "rollout"])
def motion(request):
    return synthetic_plan() if request.param == "plan" else synthetic_rollout()


def test_it_is_the_replay_in_a_frame_of_its_own_with_its_size(installed, motion):
    page = Page()
    installed(page)
    shown = motion._repr_html_()
    (content,) = re.findall(r'srcdoc="([^"]*)"', shown)
    assert html.unescape(content) == page.text
    assert "allow-same-origin" not in shown
    assert "0.0 MB" in shown


@pytest.mark.parametrize(
    ("found", "why"),
    [
        ([], "not installed"),
        ([Page(fault=InputError("the motion holds numbers that are not finite"))], "not finite"),
        ([Page("x" * (notebook.LARGEST + 1))], "4.0 MB, more than the 4 MB"),
    ],
)
def test_else_it_is_a_table_that_says_why(installed, motion, found, why):
    installed(*found)
    shown = motion._repr_html_()
    assert "<iframe" not in shown
    assert why in shown
    assert f"{motion.duration:.2f} s" in shown


def test_words_are_no_markup(installed):
    installed()
    plan = synthetic_plan()
    hostile = replace(plan, jump=replace(plan.jump, model="<b>x</b>"))
    assert "<b>" not in hostile._repr_html_()


def test_the_page_is_loaded_where_it_is_wanted():
    """A module that registers one format may be imported before those of the others."""
    code = "import sys, llsrbm.motion.notebook; assert 'app' not in sys.modules; import app.replay;"
    code += "from llsrbm.formats import FORMATS; assert FORMATS['html']"
    printed(code)


def test_as_text_it_is_a_line():
    plan = synthetic_plan(twist=0.5)
    for motion, begins in ((plan, "<Plan of anymal: "), (synthetic_rollout(plan), "<Rollout of ")):
        assert repr(motion).startswith(begins)
        assert "twist 0.5" in repr(motion)
        assert len(repr(motion)) < 200
        assert "\n" not in repr(motion)
