"""`llsrbm.largest`: how a component grows, where that begins, and what stops it."""

import math
from dataclasses import dataclass, field, replace

import numpy as np
import pytest

import llsrbm
from llsrbm import api, largest_jump
from llsrbm.certified_plan import CertifiedPlanner
from llsrbm.errors import JointNeed, NotConverged, Stop
from llsrbm.largest_jump import DIRECTIONS, NO_LIMIT, Direction
from llsrbm.motion.solve_report import Refinement
from llsrbm.ocp.horizon import Iterate
from llsrbm.planning.whole_body.refine import Moved
from llsrbm.request.jump import Jump
from tests.llsrbm.player.stages import stored_plan

NEED = JointNeed("RR_calf_joint", 15.7, 15.7, "rad/s", "at lift-off")
STOP = Stop("speed", "take-off", 0.7, 0.0, "rad/s", "speed", demand=NEED)
GO2 = Jump(robot="go2")


@dataclass
class Refines:
    """A refiner that plans what is `reachable`; where it has a table, from there `from_table`."""

    reachable: object
    from_table: object = None
    drafts: bool = True
    offset: float | None = None  # by which a landing can be moved forward
    tried: list = field(default_factory=list)
    rows = "rows"

    def nearby(self, jump, tuning):
        return None if self.from_table is None else Iterate("table", jump)

    def moved(self, task, nearby, wanted, price, watch):
        if self.offset is None:
            return None
        self.wanted = wanted
        offset = np.array([0.0, self.offset, 0.0, 0.0])
        return Moved(Iterate("moved", None), offset, None)

    def beside(self, task, nearby, watch, *, straighter=False):
        watch.begin("whatever is done for it")
        assert straighter == (nearby.variables == "moved")
        reachable = self.from_table if nearby.variables == "table" else self.reachable
        self.tried.append((nearby.variables, task.jump))
        return self._plan(task.jump, found=reachable(task.jump))

    def refine(self, draft, **_):
        return self._plan(draft.jump, found=self.drafts)

    def _plan(self, jump, *, found):
        self.solution = Iterate("last", jump)
        status = replace(stored_plan().refinement, status="solved" if found else "not-converged")
        return replace(stored_plan(), jump=jump, refinement=status)


@pytest.fixture
def search(monkeypatch):
    """`llsrbm.largest` by such a refiner; the edge's stop is `STOP`, drafts are made at once."""

    def run(refiner, jump, component, **options):
        monkeypatch.setattr(largest_jump.Search, "_refiner", refiner)
        return llsrbm.largest(jump, component, **options)

    edges = []

    @dataclass
    class Edge:
        rows: object
        solution: object
        before: object

        def stop(self):
            edges.append(self)
            return STOP

    def draft(self, jump, robot):
        return replace(stored_plan(), jump=jump, refinement=None)

    monkeypatch.setattr(largest_jump, "Edge", Edge)
    monkeypatch.setattr(api.Drafting, "draft", draft)
    run.edges = edges
    return run


def test_steps_are_halved_down_to_one_and_the_value_is_whole_steps(search):
    refiner = Refines(lambda jump: jump.forward <= 0.175)
    found = search(refiner, GO2, "forward")
    assert (found.component, found.value, found.unit) == ("forward", 0.17, "m")
    assert [jump.forward for _, jump in refiner.tried] == [
        0.05, 0.1, 0.15, 0.2, 0.17, 0.19, 0.18,
    ]  # fmt: skip
    assert [plan.jump.forward for plan in found.smaller] == [0.0, 0.05, 0.1, 0.15]
    assert found.plan.jump.forward == found.value
    assert found.plan.certified


def test_what_stops_it_is_what_grew_since_the_first_jump(search):
    found = search(Refines(lambda jump: jump.height <= 0.11), GO2, "up")
    assert found.limit == "RR_calf_joint is at its limit of 15.7 rad/s at lift-off"
    (edge,) = search.edges
    assert edge.solution.multipliers.height == 0.11
    assert edge.before.multipliers.height == 0.0


@pytest.mark.parametrize(
    ("component", "request_", "first"),
    [
        ("backward", {"forward": -0.2}, -0.25),
        ("backward", {"forward": 0.2}, -0.05),  # of the other side nothing is left
        ("forward", {"forward": 0.2, "lateral": 0.1}, 0.25),
        ("down", {}, -0.05),
        ("lateral", {"forward": 0.3}, 0.05),
        ("lateral-right", {"lateral": -0.1}, -0.15),
        ("twist-right", {"forward": 0.3}, math.radians(-10.0)),
    ],
)
def test_it_begins_at_the_request_and_the_rest_stays(search, component, request_, first):
    refiner = Refines(lambda jump: False)
    jump = replace(GO2, **request_)
    search(refiner, jump, component)
    name = DIRECTIONS[component].field
    assert getattr(refiner.tried[0][1], name) == pytest.approx(first)
    assert replace(refiner.tried[0][1], **{name: 0.0}) == replace(jump, **{name: 0.0})


def test_it_begins_where_the_robots_table_goes_furthest(search):
    refiner = Refines(lambda jump: jump.forward <= 0.5, from_table=lambda jump: jump.forward < 0.5)
    found = search(refiner, GO2, "forward")
    assert [jump.forward for _, jump in refiner.tried[:2]] == [0.6, 0.45]  # of the file's range
    assert found.value == 0.5
    assert [plan.jump.forward for plan in found.smaller] == [0.45]


def test_where_the_last_jump_leads_nowhere_the_table_is_continued(search):
    refiner = Refines(lambda jump: False, from_table=lambda jump: jump.forward <= 0.7)
    found = search(refiner, GO2, "forward")
    assert found.value == 0.7  # beyond what the robot's file takes
    assert refiner.tried[1:3] == [
        ("last", replace(GO2, forward=0.65)),
        ("table", replace(GO2, forward=0.65)),
    ]


def test_a_search_ends_where_nothing_stops_it(search):
    found = search(Refines(lambda jump: True), GO2, "twist")
    assert math.degrees(found.value) == pytest.approx(720)
    assert found.limit == NO_LIMIT
    assert not search.edges


def test_a_check_that_does_not_hold_is_what_stops_it(search, monkeypatch):
    def held(self, plan):
        if plan.jump.forward <= 0.05:
            return plan
        own = plan.certificate["joint_speed"]
        fast = own | {"worst": 1.1, "limit": 20.0, "where": "RR_calf_joint", "time_s": 0.7}
        broken = fast | {"holds": False}
        return replace(plan, certificate=plan.certificate | {"joint_speed": broken})

    monkeypatch.setattr(CertifiedPlanner, "held", held)
    found = search(Refines(lambda jump: True), GO2, "forward")
    assert found.value == 0.05
    assert found.limit == "RR_calf_joint needs 22 rad/s at 0.70 s, it has 20"


def test_its_progress_says_how_far_it_has_come(search):
    told = []
    refiner = Refines(lambda jump: jump.forward <= 0.06)
    search(refiner, GO2, "forward", progress=lambda step: told.append(step.text))
    assert [line for line in dict.fromkeys(told) if "trying" in line][:3] == [
        "0.00 m holds, trying 0.05 m",
        "0.05 m holds, trying 0.10 m",
        "0.05 m holds, trying 0.07 m",
    ]


def test_without_a_plan_to_begin_from_there_is_none(search):
    with pytest.raises(NotConverged, match="no jump to begin from"):
        search(Refines(lambda jump: True, drafts=False), GO2, "forward")


@pytest.mark.parametrize(
    ("jump", "component", "message"),
    [
        (GO2, "sideways", 'no component "sideways"'),
        (Jump(robot="go2", type="flip", pitch=-math.tau), "up", "turn over"),
        (Jump(robot="go2", route=2 * ({"forward": 0.3},)), "forward", "a request without a route"),
        # It was 0 m, stopped by a sentence about the next step of the search.
        (Jump(robot="go2", type="over-gap", gap=0.2), "forward", "forward: jumps of type over-gap"),
        (Jump(robot="go2", lateral=4.0), "up", "lateral 4 m is out of range"),
        (Jump(robot="nobody"), "up", "nobody"),
    ],
)
def test_what_cannot_be_asked_for_is_refused(jump, component, message):
    with pytest.raises(llsrbm.InputError, match=message):
        llsrbm.largest(jump, component)


@pytest.mark.nightly
def test_go2_jumps_higher_than_its_file_takes(monkeypatch):
    """A real search, cut short."""
    monkeypatch.setitem(DIRECTIONS, "up", Direction("height", 1, "m", 1, 26))
    found = llsrbm.largest(GO2, "up")
    assert found.value == 0.26  # of 0.25
    assert found.plan.certified
    assert llsrbm.certify(found.plan).holds
    assert Refinement(**vars(found.plan.refinement)).status == "solved"


def test_a_landing_is_moved_as_far_as_it_can_be_at_once(search):
    refiner = Refines(
        lambda jump: jump.forward < 0.745, lambda jump: jump.forward < 0.7, offset=0.1451
    )
    found = search(refiner, GO2, "forward")
    assert refiner.wanted == pytest.approx([0.0, 3.0 - 0.6, 0.0, 0.0])
    assert found.value == pytest.approx(0.74)
    assert len(found.smaller) == 1  # 0.60 m, of the table
    moved = [jump.forward for of, jump in refiner.tried if of == "moved"]
    assert moved == pytest.approx([0.74])


def test_where_its_certificate_does_not_hold_some_steps_before_are_tried(search):
    refiner = Refines(
        lambda jump: jump.forward < 0.715, lambda jump: jump.forward < 0.7, offset=0.1451
    )
    found = search(refiner, GO2, "forward")
    moved = [jump.forward for of, jump in refiner.tried if of == "moved"]
    assert moved == pytest.approx([0.74, 0.73, 0.71])
    assert found.value == pytest.approx(0.71)
