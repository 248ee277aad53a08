"""Whose turn it is: rules checked on made-up queues, without processes."""

import itertools

from hypothesis import given
from hypothesis import strategies as st

from app.workers.tasks import (
    ExportMotion,
    FindLargest,
    OpenFile,
    PlanJump,
    Prepare,
    SimulateJump,
    SimulateSeeds,
    solver_of,
)
from app.workers.waiting import Entry, Member, Waiting
from llsrbm.request.jump import Jump
from llsrbm.request.scenario import Scenario
from llsrbm.request.tuning import Tuning

PLAN = PlanJump(Jump())
OTHER = PlanJump(Jump(model="srbm"))
SIMULATION = SimulateJump(None, Scenario())  # which plan does not matter here
TABLE, LOG = (ExportMotion(None, (name,)) for name in ("csv", "mcap"))
FILE = OpenFile("a.npz", b"", "anymal")
SEARCH = FindLargest(Jump(), Tuning(), "up")
TASKS = (PLAN, OTHER, SIMULATION, Prepare("anymal"), TABLE, LOG, FILE)

numbers = itertools.count(1)


def entry(tab, task=PLAN):
    return Entry(tab, next(numbers), task, print)


def members(count=2):
    return [Member(None, reserved=0 < i == count - 1, ready=True) for i in range(count)]


def turns_that_know(*tasks):
    turns = Waiting()
    for task in tasks or TASKS:
        turns.note_done(task)
    return turns


def give(turns, crew):
    """Hand out what can be; [(tab, member's index)]."""
    given_out = []
    while (turn := turns.next(crew)) is not None:
        item, task, member = turn
        assert member.idle
        member.working_on, member.task = item, task
        given_out.append((item.tab, crew.index(member)))
    return given_out


def test_a_simulation_leaves_the_reserved_process_alone():
    turns, crew = turns_that_know(), members()
    for tab in "abc":
        turns.put(entry(tab, SIMULATION))
    assert give(turns, crew) == [("a", 0)]
    turns.put(entry("d"))
    assert give(turns, crew) == [("d", 1)]
    assert [item.tab for item in turns] == ["b", "c"]


def test_while_the_only_other_process_searches_the_reserved_one_takes_all_else():
    turns, crew = turns_that_know(*TASKS, SEARCH), members()
    for tab in "ab":
        turns.put(entry(tab, SEARCH))
    assert give(turns, crew) == [("a", 0)]  # and b's waits
    turns.put(entry("c", SIMULATION))
    assert give(turns, crew) == [("c", 1)]
    turns, crew = turns_that_know(*TASKS, SEARCH), members(3)
    for tab, task in (("a", SEARCH), ("b", SIMULATION), ("c", SIMULATION)):
        turns.put(entry(tab, task))
    assert give(turns, crew) == [("a", 0), ("b", 1)]


def test_a_visitors_file_leaves_the_reserved_process_alone_and_a_second_one_waits():
    turns, crew = turns_that_know(), members(4)
    turns.put(entry("a", FILE))
    turns.put(entry("b", FILE))
    assert len(give(turns, crew)) == 1
    assert crew[-1].idle
    for member in crew:
        member.working_on = member.task = None
    assert [tab for tab, _ in give(turns, crew)] == ["b"]


def test_seeds_are_simulated_side_by_side_and_other_tabs_have_their_turn():
    turns, crew = turns_that_know(), members(4)
    turns.put(entry("a", SimulateSeeds(None, Scenario(), tuple(range(20)))))
    assert give(turns, crew) == [("a", 0), ("a", 1), ("a", 2)]  # the fourth is reserved
    turns.put(entry("b", SIMULATION))
    turns.put(entry("c"))
    assert give(turns, crew) == [("c", 3)]
    crew[0].working_on = crew[0].task = None
    crew[1].working_on = crew[1].task = None
    assert sorted(give(turns, crew)) == [("a", 0), ("b", 1)]
    seeds = [member.task.scenario.seed for member in crew[:1] + crew[2:3]]
    assert seeds == [3, 2]


def test_files_need_nothing_that_has_to_be_built_first():
    turns, crew = Waiting(), members()
    turns.put(entry("a", PLAN))  # builds a solver
    turns.put(entry("b", TABLE))
    assert give(turns, crew) == [("a", 0), ("b", 1)]


def test_a_tab_has_one_job_of_a_kind_running_besides_those_that_stop():
    turns, crew = turns_that_know(), members()
    turns.put(entry("a"))
    give(turns, crew)
    turns.put(entry("a"))
    assert give(turns, crew) == []
    turns.put(entry("a", SIMULATION))
    assert give(turns, crew) == [("a", 0)]
    crew[0].working_on = crew[0].task = None
    crew[1].stopping = True
    turns.put(entry("a"))
    assert give(turns, crew) == [("a", 0)]


def test_the_process_that_has_the_solver_is_preferred():
    crew = members(3)
    crew[1].loaded[solver_of(OTHER.jump)] = OTHER
    turns = turns_that_know()
    turns.put(entry("a", OTHER))
    turns.put(entry("b", PLAN))
    assert give(turns, crew) == [("a", 1), ("b", 2)]


def test_a_solver_is_built_once_beside_others_and_not_on_the_reserved_process():
    turns, crew = Waiting(), members(4)
    for tab, task in (("a", PLAN), ("b", PLAN), ("c", OTHER)):
        turns.put(entry(tab, task))
    assert give(turns, crew) == [("a", 0), ("c", 1)]
    turns.put(entry("d", Prepare("go2")))
    turns.put(entry("e", Prepare("slider")))
    assert give(turns, crew) == [("d", 2)]
    turns.note_done(PLAN)
    assert give(turns, crew) == [("b", 3)]


requests = st.tuples(st.sampled_from("abcdef"), st.sampled_from(TASKS))


@given(st.lists(requests | st.integers(0, 3), max_size=80), st.integers(1, 4))
def test_rules_hold_in_every_order(happenings, count):
    """Requests come in, processes finish (a number says which); in the end all are served."""
    turns, crew = Waiting(), members(count)
    asked, served = set(), set()

    def finish(member):
        if member.working_on is not None:
            turns.note_done(member.task)
            member.working_on = member.task = None

    for happening in happenings:
        if isinstance(happening, int):
            finish(crew[happening % count])
        else:
            asked.add(happening[0])
            turns.put(entry(*happening))
        served |= {tab for tab, _ in give(turns, crew)}
        running = [m.working_on for m in crew if m.working_on is not None]
        claims = [(item.tab, item.task.kind) for item in running]
        assert len(set(claims)) == len(claims)
        built = [item.task.needs for item in running if turns.is_new(item.task)]
        assert len(set(built)) == len(built)
        assert sum(isinstance(item.task, OpenFile) for item in running) <= 1
        if count > 1 and crew[-1].working_on is not None:
            assert not crew[-1].task.kind.long
    while len(turns):
        for member in crew:
            finish(member)
        given_out = give(turns, crew)
        assert given_out
        served |= {tab for tab, _ in given_out}
    assert served == asked


@given(st.lists(st.sampled_from("abcde"), min_size=1, max_size=60))
def test_who_has_waited_longest_is_next_however_often_others_ask(order):
    turns, crew = turns_that_know(), members(1)
    waiting = []
    for i, tab in enumerate(order):
        turns.put(entry(tab))
        if tab not in waiting:
            waiting.append(tab)
        if i % 3 == 2:
            crew[0].working_on = crew[0].task = None
            assert give(turns, crew) == [(waiting.pop(0), 0)]


def test_with_thirty_tabs_five_that_simulate_do_not_starve_ten_that_drag():
    """Each turn is as long as a plan, 0.1 s; a simulation takes thirty of them."""
    turns, crew = turns_that_know(), members(2)
    ends, answers, simulated = {}, dict.fromkeys(range(10), 0), dict.fromkeys(range(10, 15), 0)
    for now in range(600):
        for member in [m for m in crew if m.working_on and ends[m.working_on] <= now]:
            tab = member.working_on.tab
            (answers if tab < 10 else simulated)[tab] += 1
            member.working_on = member.task = None
        busy = {m.working_on.tab for m in crew if m.working_on}
        if now % 3 == 0:
            for tab in answers:
                turns.put(entry(tab, PLAN))
        waiting = {item.tab for item in turns}
        for tab in simulated.keys() - busy - waiting:
            turns.put(entry(tab, SIMULATION))
        while (turn := turns.next(crew)) is not None:
            item, task, member = turn
            member.working_on, member.task = item, task
            ends[item] = now + (30 if item.task is SIMULATION else 1)
    # One process is theirs, of whose 600 turns each of the ten has about a tenth.
    assert min(answers.values()) >= 50
    # The other one takes twenty simulations in that time.
    assert sum(simulated.values()) >= 15
    assert min(simulated.values()) >= 3
