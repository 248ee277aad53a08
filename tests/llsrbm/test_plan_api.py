"""`llsrbm.plan`: the whole body's plan with its certificate, unless a draft is asked for."""

from dataclasses import replace
from functools import cache

import pytest

import llsrbm
from llsrbm import certified_plan, drafting
from llsrbm.analysis.wording import plan_rows
from llsrbm.errors import NotConverged
from llsrbm.motion.solve_report import Refinement

JUMP = llsrbm.Jump(robot="go2", forward=0.2, twist=0.3)


@cache
def draft():
    return llsrbm.plan(JUMP, draft=True)


@cache
def plan():
    return llsrbm.plan(JUMP)


def certificate_row(of):
    return dict(plan_rows(of))["Certificate"]


def test_a_plan_is_the_whole_bodys_and_its_certificate_holds():
    assert plan().refined
    assert plan().certified
    assert plan().certificate == llsrbm.certify(plan()).as_dict()
    assert certificate_row(plan()) == "holds"


def test_a_draft_is_the_first_stages_and_carries_no_certificate():
    assert draft().refinement is None
    assert draft().certificate is None
    assert not draft().certified
    assert (
        certificate_row(draft())
        == "none that holds, a draft: its drives were looked at in knots only"
    )


def test_where_the_whole_bodys_plan_is_not_found_it_is_a_draft_that_says_so(monkeypatch):
    effort = Refinement("not-converged", 200, 2.0, 2.0, 0.0, 1.0)
    monkeypatch.setattr(
        certified_plan, "refined", lambda first, *_, **__: replace(first, refinement=effort)
    )
    found = llsrbm.plan(JUMP, guesses=False)
    assert found.solved
    assert not found.certified
    assert certificate_row(found) == "none that holds, a draft: the whole body's plan was not found"


@pytest.mark.parametrize("as_draft", [False, True])
def test_the_nearest_jumps_plan_is_likewise(monkeypatch, as_draft):
    failed = replace(draft(), report=replace(draft().report, status="not-converged"))

    class Refusing:
        def plan(self, jump, **_):
            raise NotConverged("too far", failed, nearest=draft(), reason="its knees")

    monkeypatch.setattr(drafting, "planner_of", lambda *_, **__: Refusing())
    with pytest.raises(
        NotConverged, match="too far" if as_draft else "its knees; nearest:"
    ) as caught:
        llsrbm.plan(JUMP, draft=as_draft, guesses=False)
    assert caught.value.reason == "its knees"
    assert caught.value.nearest.certified is not as_draft
