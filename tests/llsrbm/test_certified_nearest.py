"""What is done where the table, a landing that is moved, and a draft lead to different jumps."""

import math
from dataclasses import dataclass, field, replace

import pytest

import llsrbm
from llsrbm import certified_nearest
from llsrbm.certified_nearest import all_or_less, whole_or_nearest
from llsrbm.certified_plan import CertifiedPlanner, Nearest
from llsrbm.errors import NotConverged, Stop
from llsrbm.motion.solve_report import Refinement
from llsrbm.planning.problem.placement import make_task
from llsrbm.request.tuning import Tuning
from llsrbm.robots import load_robot
from llsrbm.robots.payload import with_payload
from tests.llsrbm.formats.jumps import planned
from tests.llsrbm.player.stages import stored_plan

ALL = llsrbm.Jump(robot="go2", twist=math.radians(80), forward=0.4, lateral=0.1)
HARD = replace(ALL, twist=math.pi, forward=0.6, lateral=0.3, height=0.25)
LESS = replace(ALL, twist=math.radians(70))


def certified_of(jump):
    return replace(stored_plan(), jump=jump)


def less_of_all(stop=None):
    return Nearest(certified_of(LESS), stop)


@dataclass(frozen=True)
class Whole:
    """A planner that knows some jumps from a table, and from drafts finds some or nothing."""

    table: tuple = ()
    near: Nearest | None = None
    drafts: tuple = ()
    robot: None = None
    guesses: bool = True
    finer: bool = True
    searched: list = field(default_factory=list)

    def from_table(self, task, intervals):
        self.searched.append("table")
        return certified_of(task.jump) if task.jump in self.table else None

    def nearest(self, task, intervals, *, less):
        self.searched.append("nearest" if less else "all")
        return self.near

    def plan(self, draft):
        self.searched.append("finer" if self.finer else "draft")
        if draft.jump in self.drafts:
            return certified_of(draft.jump)
        failed = Refinement("not-converged", 200, 2.0, 2.0, 0.0, 1.0)
        return replace(draft, refinement=failed)


def task(jump):
    return make_task(jump, load_robot("go2"))


def draft(jump):
    return replace(planned("go2"), jump=jump)


def test_what_the_table_leads_to_is_taken():
    whole = Whole(table=(ALL,))
    assert all_or_less(whole, task(ALL)).plan.jump == ALL
    assert whole.searched == ["table"]


@pytest.mark.parametrize("less", [True, False])
def test_else_a_landing_is_moved(less):
    whole = Whole(near=less_of_all())
    assert all_or_less(whole, task(ALL), less=less).plan.jump == LESS
    assert whole.searched == ["table", "nearest" if less else "all"]


def test_what_is_unlikely_is_not_solved_as_it_is():
    whole = Whole(near=less_of_all())
    assert all_or_less(whole, task(HARD)).plan.jump == LESS
    with pytest.raises(NotConverged):
        whole_or_nearest(whole, draft(HARD), HARD, whole.near)
    assert whole.searched == ["nearest"]


def test_a_draft_of_all_of_it_may_lead_there_where_less_is_found():
    whole = Whole(near=less_of_all(), drafts=(ALL,))
    assert whole_or_nearest(whole, draft(ALL), ALL, whole.near).jump == ALL
    assert whole.searched == ["finer"]


def test_less_is_the_nearest_and_says_what_stops_more():
    stop = Stop("speed", "take-off", 0.4, 0.0, "1", title="a calf is too slow")
    for draft_of in (ALL, LESS):
        with pytest.raises(NotConverged, match="a calf is too slow") as refusal:
            whole_or_nearest(Whole(), draft(draft_of), ALL, less_of_all(stop))
        assert refusal.value.nearest.jump == LESS
        assert refusal.value.nearest.certified
        assert refusal.value.stops == (stop,)
        assert "70° instead of 80°" in str(refusal.value)


def test_where_nothing_is_known_to_stop_it_that_is_said():
    with pytest.raises(NotConverged) as refusal:
        whole_or_nearest(Whole(), draft(ALL), ALL, less_of_all())
    assert refusal.value.reason == certified_nearest.NOT_FOUND


def test_without_a_table_a_draft_of_less_is_solved_on_one_grid():
    whole = Whole(drafts=(LESS,))
    assert whole_or_nearest(whole, draft(LESS), ALL, None).jump == LESS
    assert not whole_or_nearest(Whole(), draft(ALL), ALL, None).certified
    assert whole.searched == ["draft"]


@pytest.mark.parametrize(
    ("limits", "unlikely"),
    [
        ({}, True),
        ({"torque_share": 0.6, "clearance": 0.05}, True),
        ({"torque_share": 1.0}, False),  # whether it can be done with more is not known
        ({"clearance": 0.0}, False),
        ({"torque_share": 0.6, "clearance": 0.0}, False),
    ],
)
def test_what_is_unlikely_stays_so_with_tighter_limits(limits, unlikely):
    assert certified_nearest.is_unlikely(HARD, Tuning(limits=limits)) is unlikely
    assert not certified_nearest.is_unlikely(ALL, Tuning(limits=limits))


def test_nothing_nearer_is_looked_for_where_much_is_given_up():
    near = less_of_all()
    some = replace(ALL, twist=0.9 * ALL.twist)
    assert not certified_nearest.gives_up(near, task(replace(LESS, twist=LESS.twist + 0.05)))
    assert certified_nearest.gives_up(near, task(replace(some, lateral=some.lateral + 0.1)))


@pytest.mark.parametrize("jump", [ALL, HARD])
def test_of_what_is_likely_the_table_is_sure(jump):
    assert certified_nearest.is_likely(jump, Tuning()) is (jump == ALL)
    assert not certified_nearest.is_likely(jump, Tuning(limits={"torque_share": 0.6}))


def test_of_a_robot_that_carries_something_no_table_is_missed(caplog):
    loaded = replace(ALL, payload=(2.0, 0.0, 0.0, 0.1))
    robot = with_payload(load_robot("go2"), loaded.payload)
    assert not certified_nearest.is_unlikely(loaded, Tuning())
    assert CertifiedPlanner().from_table(make_task(loaded, robot)).certified
    assert not caplog.records
