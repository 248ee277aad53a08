"""`CertifiedPlanner`: the whole body's plan of a draft, again where its certificate fails."""

from dataclasses import replace
from threading import Event

import pytest

from llsrbm import certified_plan
from llsrbm.certificate import certify
from llsrbm.certified_plan import WITHOUT_ROWS, CertifiedPlanner
from llsrbm.errors import Cancelled
from llsrbm.planning.problem.placement import make_task
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot
from tests.llsrbm.formats.jumps import planned
from tests.llsrbm.player.stages import stored_plan


def draft():
    return planned("go2")


plan = stored_plan  # of the same jump


def test_a_plan_that_is_cancelled_while_it_is_checked_is_none(monkeypatch):
    found, begun, release = plan(), Event(), Event()
    monkeypatch.setattr(certified_plan, "refined", lambda *_, **__: found)
    monkeypatch.setattr(certified_plan, "certified", lambda *_: begun.set() or release.wait(30))
    with pytest.raises(Cancelled):
        CertifiedPlanner(cancelled=begun.is_set).plan(draft())
    release.set()


@pytest.mark.nightly
@pytest.mark.parametrize("holds", [True, False])
def test_where_the_certificate_does_not_hold_it_is_planned_on_a_finer_grid(monkeypatch, holds):
    tried = []

    def judged(found, *_):
        tried.append(found)
        checks = dict(plan().certificate)
        if len(tried) == 1 or not holds:
            checks["dynamics"] = {**checks["dynamics"], "holds": False}
        return replace(found, certificate=checks)

    monkeypatch.setattr(certified_plan, "certified", judged)
    found = CertifiedPlanner(guesses=False).plan(draft())
    coarse, fine = tried
    assert len(fine.time) > 1.4 * len(coarse.time)
    assert found.certified is holds
    assert len(found.time) == len((fine if holds else coarse).time)
    both = coarse.refinement.iterations + fine.refinement.iterations
    assert found.refinement.iterations == both
    if holds:
        assert certify(found).holds


def test_what_a_table_leads_to_is_planned_on_a_finer_grid_as_well(monkeypatch):
    tried = []

    def judged(found, *_):
        tried.append(found)
        checks = dict(plan().certificate)
        if len(tried) == 1:
            checks["dynamics"] = {**checks["dynamics"], "holds": False}
        return replace(found, certificate=checks)

    monkeypatch.setattr(certified_plan, "certified", judged)
    found = CertifiedPlanner().from_table(make_task(draft().jump, load_robot("go2")))
    coarse, fine = tried
    assert len(found.time) == len(fine.time) > 1.4 * len(coarse.time)
    assert fine.certificate is None  # no certificate but its own
    assert certify(found).holds


def test_power_that_no_row_holds_is_no_reason_for_a_finer_grid(monkeypatch):
    tried = []

    def judged(found, *_):
        tried.append(found)
        checks = dict(plan().certificate)
        broken = {name: {**checks[name], "holds": False} for name in WITHOUT_ROWS}
        return replace(found, certificate=checks | broken)

    monkeypatch.setattr(certified_plan, "certified", judged)
    found = CertifiedPlanner(guesses=False).plan(draft())
    assert not found.certified
    assert len(tried) == 1


def test_a_route_begins_from_plans_of_its_jumps_of_which_none_is_checked(monkeypatch):
    parts, checked = [], []
    route = Jump(robot="go2", route=({"forward": 0.3, "slope": 0.1}, {"forward": 0.2}))

    def through(task, _counts, begun, **_):
        parts.extend(begun)
        return replace(plan(), jump=task.jump)

    monkeypatch.setattr(certified_plan, "planned_through", through)
    monkeypatch.setattr(
        certified_plan, "planned", lambda task, *_, **__: replace(plan(), jump=task.jump)
    )
    monkeypatch.setattr(
        certified_plan, "certified", lambda found, *_: checked.append(found.jump) or found
    )
    found = CertifiedPlanner().from_table(make_task(route, load_robot("go2")))
    first, second = (part.jump for part in parts)
    assert (first.forward, first.slope, second.takeoff_slope) == (0.3, 0.1, 0.1)
    assert checked == [found.jump] == [route]
