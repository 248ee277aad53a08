"""A push as the page has it: where it begins, dragged, simulated, undone, compared."""

from dataclasses import replace

import numpy as np
import pytest

from app.link import PlayerMoved, PushDragged
from app.motion.baked import ARROW_PER_SPEED, metres_per_newton_second, trunk_com
from app.panel.acts import Act
from app.tab.effects import Keep, Pause, Play, Seek
from app.tab.pushing import push_shown
from app.workers.reports import SimulatedSoFar
from app.workers.tasks import SimulateJump
from llsrbm.request.scenario import DURATION, LARGEST_IMPULSE, Push, Scenario
from tests.app.pure_tab import planned_tab
from tests.app.synthetic_plan import FLY, STAND

NOTHING = Push(0.0, (0.0, 0.0, 0.0))


@pytest.fixture
def tab():
    return planned_tab()


def pushes(tab):
    return tab.state.design.scenario.pushes


def stand_at(tab, time, *, playing=False):
    tab.take(PlayerMoved(time, playing))


def tick_push(tab, push=NOTHING, **scenario):
    return tab.take(Scenario(pushes=(push,), **scenario))


def pushed_tab(time=0.5, **scenario):
    tab = planned_tab()
    stand_at(tab, time)
    tick_push(tab, **scenario)
    return tab


def drag(tab, impulse, *, time=0.5, ended=True):
    x, y = metres_per_newton_second(tab.state.robot) * np.array(impulse[:2])
    return tab.take(PushDragged(time, float(x), float(y), ended))


# ---- where it begins


def test_a_push_begins_where_the_timeline_stands_and_the_page_shows_that(tab):
    stand_at(tab, 0.3)
    effects = tick_push(tab)
    (push,) = pushes(tab)
    assert push.time == 0.3
    assert np.linalg.norm(push.impulse) == pytest.approx(0.3 * tab.state.robot.mass, abs=0.5)
    assert [e for e in effects if not isinstance(e, Keep)] == [Pause(), Seek(0.3)]


@pytest.mark.parametrize(("time", "playing"), [(0.3, True), (0.0, False), (99.0, False)])
def test_of_no_instant_in_particular_it_begins_in_mid_flight(tab, time, playing):
    stand_at(tab, time, playing=playing)
    tick_push(tab)
    assert pushes(tab)[0].time == pytest.approx(STAND + FLY / 2)


def test_a_size_that_was_entered_before_is_kept(tab):
    tick_push(tab, Push(0.1, (1.0, -2.0, 0.5)))
    assert pushes(tab)[0].impulse == (1.0, -2.0, 0.5)


def test_another_time_is_shown_and_another_size_changes_nothing_else():
    tab = pushed_tab()
    push = pushes(tab)[0]
    effects = tick_push(tab, replace(push, time=0.2))
    assert Seek(0.2) in effects
    effects = tick_push(tab, Push(0.2, (3.0, 0.0, 0.0)))
    assert [type(e) for e in effects] == [Keep]


# ---- dragged


def test_the_end_of_a_drag_starts_a_simulation_and_nothing_before_does():
    tab = pushed_tab()
    for y in (1.0, 2.0, 3.0):
        assert drag(tab, (0.0, y, 0.0), ended=False) == ()
    assert pushes(tab)[0].impulse == (0.0, 3.0, 0.0)
    before = len(tab.submits)
    drag(tab, (0.0, 4.0, 0.0))
    (submit,) = tab.submits[before:]
    assert isinstance(submit.task, SimulateJump)
    assert submit.task.scenario.pushes == (Push(0.5, (0.0, 4.0, 0.0)),)
    assert tab.kept()[-1].scenario.pushes == (Push(0.5, (0.0, 4.0, 0.0)),)


def test_a_drag_is_one_step_back_and_the_next_one_another():
    tab = pushed_tab()
    first = pushes(tab)
    for way in (1.0, 2.0):
        drag(tab, (way, 0.0, 0.0), ended=False)
        drag(tab, (2 * way, 0.0, 0.0))
    tab.take(Act.UNDO)
    assert pushes(tab)[0].impulse == (2.0, 0.0, 0.0)
    tab.take(Act.UNDO)
    assert pushes(tab) == first
    tab.take(Act.REDO)
    assert pushes(tab)[0].impulse == (2.0, 0.0, 0.0)


def test_a_click_on_the_trunk_pushes_nobody():
    tab = pushed_tab()
    before, submits = pushes(tab), len(tab.submits)
    drag(tab, (0.0, 0.01, 0.0), time=0.7)
    assert pushes(tab) == before
    assert len(tab.submits) == submits


def test_a_push_is_drawn_where_there_was_none(tab):
    stand_at(tab, 0.5)
    drag(tab, (0.0, 6.0, 0.0), ended=False)
    assert pushes(tab) == (Push(0.5, (0.0, 6.0, 0.0)),)
    assert push_shown(tab.state).impulse == (0.0, 6.0, 0.0)
    before = len(tab.submits)
    drag(tab, (0.0, 6.0, 0.0))
    (submit,) = tab.submits[before:]
    assert submit.task.scenario.pushes == pushes(tab)


def test_a_push_that_begins_there_keeps_its_instant_and_its_vertical_part():
    tab = pushed_tab()
    tick_push(tab, Push(0.5, (0.0, 1.0, 3.0)))
    drag(tab, (2.0, 0.0, 0.0), time=0.5 + DURATION / 2)
    assert pushes(tab) == (Push(0.5, (2.0, 0.0, 3.0)),)
    drag(tab, (2.0, 0.0, 0.0), time=0.7)
    assert pushes(tab) == (Push(0.7, (2.0, 0.0, 0.0)),)


def test_beyond_the_largest_push_its_direction_counts():
    tab = pushed_tab()
    drag(tab, (3e4, -4e4, 0.0))
    push = np.array(pushes(tab)[0].impulse)
    assert LARGEST_IMPULSE - 0.2 <= np.linalg.norm(push) <= LARGEST_IMPULSE
    assert push / np.linalg.norm(push) == pytest.approx([0.6, -0.8, 0], abs=1e-3)


def test_further_pushes_of_a_design_stay_and_so_does_the_moment():
    tab = planned_tab()
    pair = (Push(0.4, (1.0, 0.0, 0.0), (0.0, 0.0, 2.0)), Push(0.9, (0.0, 5.0, 0.0)))
    tab.take(Scenario(pushes=pair))
    drag(tab, (0.0, 2.0, 0.0), time=0.6)
    first, second = pushes(tab)
    assert first == Push(0.6, (0.0, 2.0, 0.0), (0.0, 0.0, 2.0))
    assert second == pair[1]


def test_a_dragged_push_is_played_from_where_it_was_drawn():
    tab = pushed_tab()
    drag(tab, (0.0, 4.0, 0.0))
    tab.finish_simulation()
    assert [e for e in tab.effects if isinstance(e, Seek | Play)] == [Seek(0.5), Play()]
    tab.take(Act.SIMULATE)
    tab.finish_simulation()
    assert not tab.of(Play)


def test_it_is_played_once_as_soon_as_there_is_enough_to_see():
    tab = pushed_tab()
    drag(tab, (0.0, 4.0, 0.0))
    qpos = tab.state.robot.posture
    state = np.concatenate([qpos[:3], qpos[6:7], qpos[3:6], qpos[7:]])

    def report(end):
        time = np.arange(round(60 * end)) / 60
        tab.report(SimulatedSoFar(0, 0.5, time, np.tile(state, (len(time), 1))))
        return bool(tab.of(Play))

    before = tab.state.shown
    assert [report(end) for end in (0.2, 0.5)] == [False, False]
    assert tab.state.shown is before  # it does not go back to where the simulation is
    assert [report(end) for end in (1.1, 1.3)] == [True, False]
    assert tab.state.shown.so_far.end == pytest.approx(1.3, abs=0.02)
    tab.finish_simulation()
    assert not tab.of(Play)


# ---- its arrow


def test_the_arrow_begins_at_the_trunk_and_is_as_long_as_the_speed_that_it_gives():
    tab = pushed_tab()
    drag(tab, (0.0, 0.1 * tab.state.robot.mass, 0.0), ended=False)
    stand_at(tab, 0.5)
    shown = push_shown(tab.state)
    frames = tab.state.shown.planned.frames
    at = int(np.abs(frames.time - 0.5).argmin())
    assert shown.origin == pytest.approx(trunk_com(tab.state.robot, frames)[at], abs=0.05)
    length = np.linalg.norm(np.subtract(shown.tip, shown.origin))
    assert length == pytest.approx(0.1 * ARROW_PER_SPEED, rel=0.05)


def test_at_another_instant_the_arrow_begins_anew():
    tab = pushed_tab()
    stand_at(tab, 0.5 + DURATION / 2)
    assert push_shown(tab.state).impulse == pushes(tab)[0].impulse
    stand_at(tab, 0.8)
    shown = push_shown(tab.state)
    assert shown.impulse == (0.0, 0.0, 0.0)
    assert shown.time == 0.8
    assert shown.tip == shown.origin


def test_while_anything_moves_there_is_nothing_to_drag():
    tab = pushed_tab()
    stand_at(tab, 0.5, playing=True)
    assert push_shown(tab.state) is None
    stand_at(tab, 0.5)
    assert push_shown(tab.state) is not None
    tab.take(Act.SIMULATE)
    assert push_shown(tab.state) is None
    tab.finish_simulation()
    assert push_shown(tab.state) is not None
