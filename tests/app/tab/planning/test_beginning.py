"""The draft of a motion that was there already is made while nobody waits."""

from dataclasses import replace

import pytest

from app.tab.effects import After, Queue
from app.tab.planning.beginning import LATER, Lasted
from app.tab.planning.refining import WholeBody
from app.tab.start.opening import TabOpened, example_design
from app.workers.reports import Failed, Planned
from app.workers.tasks import PlanJump
from tests.app.pure_tab import ROBOTS, PureTab, plan_of
from tests.app.synthetic_plan import refined_plan

DRAFT = plan_of(example_design(ROBOTS["anymal"]).jump)
WHOLE = refined_plan(replace(DRAFT, solution=None))


def opened(plan=WHOLE):
    """A tab that shows a motion, and the events that come later."""
    tab = PureTab()
    tab.take(WholeBody(True))
    tab.take(TabOpened(plan=plan))
    return tab, [after.event for after in tab.of(After) if after.seconds == LATER]


@pytest.fixture
def begun():
    """A tab whose draft is being made."""
    tab, (later,) = opened()
    assert tab.submits == []
    tab.take(later)
    (submit,) = tab.submits
    assert submit.queue is Queue.BEGINNING
    assert (submit.task.jump, submit.task.near) == (WHOLE.jump, None)
    return tab


def test_the_first_step_of_a_slider_begins_from_it(begun):
    status = begun.state.status
    begun.report(Planned(0, DRAFT))
    assert begun.state.plan is WHOLE
    assert begun.state.status == status
    begun.move(twist=WHOLE.jump.twist + 0.02)
    task = begun.submits[-1].task
    assert isinstance(task, PlanJump)
    assert task.near is DRAFT
    assert not task.patient


def test_all_goes_on_without_it(begun):
    begun.report(Failed(0, "the process was killed"))
    assert begun.state.plan is WHOLE
    assert begun.state.shown.centroidal is None
    begun.move(twist=0.3)
    assert begun.submits[-1].task.near is None


def test_it_is_dropped_where_another_plan_is_shown(begun):
    other = replace(DRAFT, jump=replace(DRAFT.jump, twist=0.7))
    begun.report(Planned(0, other))
    assert begun.state.shown.centroidal is None


def test_it_is_not_made_once_something_else_is_under_way():
    tab, (later,) = opened()
    tab.move(twist=0.3)
    asked = len(tab.submits)
    tab.take(later)
    assert len(tab.submits) == asked
    tab, _ = opened()
    tab.take(Lasted(DRAFT))
    assert tab.submits == []


def test_a_draft_that_is_shown_needs_none():
    assert opened(DRAFT)[1] == []
    tab, later = opened()
    tab.take(WholeBody(False))
    tab.take(later[0])
    assert tab.submits == []
