"""Successors of heavy processes, without processes."""

import threading

import pytest

from app.workers.crew import Crew
from tests.app.planners import SyntheticPlanner


@pytest.fixture
def crew():
    return Crew(SyntheticPlanner, 1, threading.RLock(), print, print, print)


def succeeded(crew):
    """The crew's one place taken over by its spare member: who had it, and who has it."""
    old, new = crew.members
    old.ready = old.heavy = True
    crew.renew()
    assert new.may_start
    new.ready = True
    crew.renew()
    assert (old.spare, new.spare) == (True, False)
    return old, new


def test_who_is_heavy_before_the_one_before_has_gone_gets_a_successor_too(crew):
    """Ends come late on a busy machine, when the next process may have said that it is heavy."""
    old, new = succeeded(crew)
    new.heavy = True
    crew.retire(old)
    crew.renew()
    assert old.may_start


def test_a_successor_that_has_failed_is_not_started_again_at_once(crew):
    old, new = succeeded(crew)
    new.heavy = True
    crew.renew()
    crew.retire(old)
    crew.renew()
    assert not old.may_start
    new.heavy = True  # it has said so again
    crew.renew()
    assert old.may_start
