"""Motions that were there before come back as they were, without planning."""

from app.panel.acts import Act
from app.panel.status import Verdict
from app.tab.effects import Submit
from tests.app.pure_tab import PureTab


def moved(tab, **changes):
    tab.move(**changes)
    tab.settle()
    return tab.state.plan


def test_undo_and_redo_show_the_plans_of_before_without_planning():
    tab = PureTab()
    first, second = moved(tab, forward=0.1), moved(tab, twist=0.3)
    tab.take(Act.UNDO)
    assert tab.state.plan is first
    assert not tab.of(Submit)
    assert tab.told[0] is Verdict.DRAFT
    tab.take(Act.REDO)
    assert tab.state.plan is second
    assert not tab.of(Submit)


def test_what_was_not_planned_to_its_end_is_planned_when_it_comes_back():
    tab = PureTab()
    moved(tab, forward=0.1)
    tab.move(twist=0.3)  # and not waited for
    tab.move(height=0.1)
    tab.take(Act.UNDO)
    assert tab.of(Submit)
