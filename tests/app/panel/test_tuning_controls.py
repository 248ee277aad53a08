from __future__ import annotations

import asyncio
import contextlib
import math
import re
from html import unescape
from types import SimpleNamespace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.panel.tuning_controls import TuningControls
from llsrbm.planning.costs import COSTS, default_weights
from llsrbm.planning.limits import limits_of
from llsrbm.robots import load_robot
from llsrbm.tuning import Tuning

ROBOT = load_robot("anymal")
COST_NAMES = [cost.name for cost in COSTS]


class Handle(SimpleNamespace):
    """A control: what was asked for, and who listens."""

    def listen(self, callback):
        self.callback = callback

    on_update = on_click = listen

    def told(self, client_id=1):
        asyncio.run(self.callback(SimpleNamespace(client_id=client_id)))

    def remove(self):
        self.owner.numbers.pop(self.label)


class Gui:
    """As much of viser's as the controls use."""

    def __init__(self):
        self.numbers = {}

    def add_html(self, content):
        self.html = Handle(content=content)
        return self.html

    def add_button(self, label, **props):
        self.button = Handle(label=label, **props)
        return self.button

    def add_folder(self, *_, **__):
        return contextlib.nullcontext()

    def add_number(self, label, value, **props):
        assert label not in self.numbers
        self.numbers[label] = Handle(label=label, value=value, owner=self, **props)
        return self.numbers[label]

    def number(self, name):
        label = name.replace("_", " ")
        (found,) = (h for text, h in self.numbers.items() if text.split(" [")[0] == label)
        return found

    def told(self):
        return unescape(re.sub(r"<[^>]*>", "\n", self.html.content))


class Page:
    def __init__(self, robot=ROBOT):
        self.gui, self.changes = Gui(), 0
        self.controls = TuningControls(SimpleNamespace(gui=self.gui), self._changed)
        self.controls.show_robot(robot)

    def _changed(self):
        self.changes += 1


@pytest.fixture
def page():
    return Page()


@pytest.mark.parametrize("robot", ["anymal", "slider"])
def test_every_weight_and_limit_has_a_number_with_unit_default_and_effect(robot):
    robot = load_robot(robot)
    page = Page(robot)
    limits = limits_of(robot)
    assert len(page.gui.numbers) == len(COSTS) + len(limits)
    weights = default_weights() | dict(robot.file.planning)
    for cost in COSTS:
        handle = page.gui.number(cost.name)
        assert handle.label.endswith(f" [{cost.unit}]")
        assert handle.value == weights[cost.name]
        assert handle.min == 0
        assert cost.effect in handle.hint
    for name, (limit, default) in limits.items():
        handle = page.gui.number(name)
        assert handle.label.endswith(f" [{limit.unit}]")
        assert (handle.value, handle.min, handle.max) == (default, limit.lowest, limit.highest)
        assert limit.effect in handle.hint


def test_nothing_changed_is_an_empty_tuning(page):
    assert page.controls.read() == (Tuning(), [])
    assert page.gui.button.disabled


def test_only_what_is_changed_is_asked_for_and_told(page):
    handle = page.gui.number(COST_NAMES[0])
    handle.value = 3 * handle.value + 1
    handle.told()
    assert page.changes == 1
    assert page.controls.read() == (Tuning(weights={COST_NAMES[0]: handle.value}), [])
    assert f"{handle.label}: {handle.value:g} instead of" in page.gui.told()
    assert not page.gui.button.disabled


def test_reset_puts_the_robots_own_back(page):
    page.controls.show(Tuning(weights={COST_NAMES[1]: 77.0}))
    page.gui.button.told()
    assert page.changes == 1
    assert page.controls.read() == (Tuning(), [])
    assert page.gui.button.disabled
    assert "instead of" not in page.gui.told()


def test_what_the_page_sets_itself_is_no_request(page):
    page.gui.number(COST_NAMES[0]).told(client_id=None)
    page.gui.button.told(client_id=None)
    assert page.changes == 0


def within(limit, default):
    """Numbers in a limit's range that are not its default."""
    return st.floats(limit.lowest, limit.highest).filter(
        lambda value: not math.isclose(value, default, rel_tol=1e-6, abs_tol=1e-6)
    )


LIMITS = limits_of(ROBOT)
TUNINGS = st.builds(
    Tuning,
    st.fixed_dictionaries({}, optional={n: st.floats(1e5, 1e6) for n in COST_NAMES}),
    st.fixed_dictionaries({}, optional={n: within(*entry) for n, entry in LIMITS.items()}),
)


@settings(max_examples=30)
@given(TUNINGS, TUNINGS)
def test_what_is_shown_is_what_is_read_whatever_was_shown_before(before, tuning):
    page = Page()
    page.controls.show(before)
    page.controls.show(tuning)
    assert page.controls.read() == (tuning, [])


@pytest.mark.parametrize("name", [COST_NAMES[0], next(iter(LIMITS))])
@pytest.mark.parametrize(("beyond", "end"), [(-1.0, "min"), (-1e9, "min"), (1e9, "max")])
def test_beyond_its_range_the_nearest_is_taken_and_said(page, name, beyond, end):
    handle = page.gui.number(name)
    handle.value = beyond
    tuning, complaints = page.controls.read()
    assert (tuning.weights | tuning.limits) == {name: getattr(handle, end)}
    (told,) = complaints
    assert told.startswith(f"{handle.label}: expected ")
    assert told.endswith("; the nearest is taken")


@pytest.mark.parametrize("nonsense", ["12", None, [1.0], math.nan, math.inf, True])
def test_what_is_no_number_is_said(page, nonsense):
    handle = page.gui.number(COST_NAMES[0])
    handle.value = nonsense
    _, (told,) = page.controls.read()
    assert told.startswith(f"{handle.label}: expected a number, got ")


def test_another_robot_has_numbers_of_its_own(page):
    page.controls.show(Tuning(weights={COST_NAMES[0]: 123.0}))
    slider = load_robot("slider")
    page.controls.show_robot(slider)
    assert page.controls.read() == (Tuning(), [])
    defaults = {name: default for name, (_, default) in limits_of(slider).items()}
    shown = {name: page.gui.number(name).value for name in defaults}
    assert shown == defaults
