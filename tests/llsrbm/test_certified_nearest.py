"""`plan_or_nearest`: less of a jump where the whole body does not do all of a draft's."""

import math
from dataclasses import dataclass, field, replace

import pytest

import llsrbm
from llsrbm.certified_nearest import plan_or_nearest
from llsrbm.certified_plan import CertifiedPlanner
from llsrbm.motion.solve_report import Refinement
from tests.llsrbm.formats.jumps import planned
from tests.llsrbm.player.stages import stored_plan

ALL = llsrbm.Jump(robot="go2", twist=math.radians(80), forward=0.4, lateral=0.1)


@dataclass(frozen=True)
class Whole:
    """A planner whose robot turns by a share of ALL's twist; from drafts it finds nothing."""

    twist: float
    robot: None = None
    guesses: bool = True
    finer: bool = True
    searched: list = field(default_factory=list)

    def nearby(self, draft, jump):
        does = jump.twist <= self.twist * ALL.twist
        return replace(stored_plan(), jump=jump) if does else None

    def plan(self, draft):
        self.searched.append(draft.jump)
        failed = Refinement("not-converged", 200, 2.0, 2.0, 0.0, 1.0)
        return replace(draft, refinement=failed)


def answer(whole, draft, wanted):
    return plan_or_nearest(whole, replace(planned("go2"), jump=draft), wanted)


def test_of_a_request_all_components_are_reduced_alike_in_whole_steps():
    whole = Whole(twist=0.6)
    found = answer(whole, ALL, ALL)
    assert found.certified
    assert whole.searched == [ALL]
    assert math.degrees(found.jump.twist) == pytest.approx(40)  # half of it
    assert (found.jump.forward, found.jump.lateral) == pytest.approx((0.2, 0.05))


def test_only_what_the_draft_gives_up_is_reduced_further():
    whole, draft = Whole(twist=0.6), replace(ALL, twist=math.radians(70))
    found = answer(whole, draft, ALL)
    assert found.certified
    assert not whole.searched
    assert math.degrees(found.jump.twist) == pytest.approx(43)  # 5/8 of 70 degrees
    assert (found.jump.forward, found.jump.lateral) == (0.4, 0.1)


def test_what_is_unlikely_is_not_searched_from_its_draft():
    hard = replace(ALL, twist=math.pi, forward=0.6, lateral=0.3, height=0.25)
    whole = Whole(twist=1.2)
    found = answer(whole, hard, hard)
    assert found.certified
    assert not whole.searched
    assert math.degrees(found.jump.twist) == pytest.approx(90)  # half of it


def test_what_the_draft_does_is_taken_where_the_whole_body_does_it():
    draft = replace(ALL, twist=math.radians(70))
    assert answer(Whole(twist=0.9), draft, ALL).jump == draft


def test_where_nothing_less_is_known_the_draft_is_left_and_says_so():
    whole = Whole(twist=-1.0)
    for draft in (ALL, replace(ALL, twist=math.radians(70))):
        found = answer(whole, draft, ALL)
        assert not found.certified
        assert found.jump == draft
    assert whole.searched == [ALL, draft]


def test_a_table_answers_for_less_of_a_draft():
    draft = planned("go2")
    less = replace(draft.jump, twist=draft.jump.twist / 2)
    found = CertifiedPlanner().nearby(draft, less)
    assert found.certified
    assert found.jump == less
    assert CertifiedPlanner(guesses=False).nearby(draft, less) is None


def test_of_types_without_a_table_no_less_is_looked_for():
    draft = planned("go2")
    assert CertifiedPlanner().nearby(draft, replace(draft.jump, type="gap", forward=0.0)) is None


def test_there_is_no_less_of_a_route():
    route = llsrbm.Jump(robot="go2", route=({"forward": 0.3}, {"forward": 0.2, "twist": 0.3}))
    found = answer(Whole(twist=1.0), route, route)
    assert (found.jump, found.certified) == (route, False)
