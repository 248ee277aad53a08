"""Edges and apex of the timeline, dragged: which limits they become, and that they are undone."""

import numpy as np
import pytest

from app.link import ApexDragged, PhasesDragged
from app.panel.acts import Act
from app.tab.shaping import handles_of
from llsrbm.planning.problem.placement import limits_of, make_task
from tests.app.pure_tab import planned_tab

# Of the synthetic plan: it stands for 0.4 s, flies for 0.5 s and stands for 0.4 s.


def limits(tab):
    return dict(tab.state.design.tuning.limits)


def middle(tab, name):
    """Of what a limit's two ends leave, which is little."""
    ends = [limits(tab)[f"{name}_{end}"] for end in ("min", "max")]
    assert 1e-3 <= ends[1] - ends[0] < 4e-3
    return np.mean(ends)


def test_the_handles_are_where_the_plan_has_edges_and_apex():
    handles = handles_of(planned_tab().state)
    assert [edge.name for edge in handles.edges] == [
        "End of take-off",
        "End of flight",
        "End of landing",
    ]
    assert [edge.time for edge in handles.edges] == pytest.approx([0.4, 0.9, 1.3])
    assert [edge.phases for edge in handles.edges] == [2, 3, 3]
    assert handles.apex.time == pytest.approx(0.65)
    rise = handles.apex.height - planned_tab().state.plan.com[0, 2]
    assert rise == pytest.approx(9.81 * 0.25**2 / 2)
    for part in (*handles.edges, handles.apex):
        value = part.height if part is handles.apex else part.time
        assert part.low < value < part.high


def test_edges_end_where_phases_have_limits_of_their_own():
    tab = planned_tab()
    tab.take(tab.state.design.jump.__class__(robot="anymal", type="rear-last"))
    tab.settle()
    assert [edge.name for edge in handles_of(tab.state).edges] == ["End of take-off"]


def test_phases_last_as_long_as_their_edges_say():
    tab = planned_tab()
    tab.take(PhasesDragged((0.43, 0.47), begins=True))
    assert (middle(tab, "takeoff"), middle(tab, "flight")) == pytest.approx((0.43, 0.47))
    assert "landing_min" not in limits(tab)
    tab.take(PhasesDragged((), begins=True))
    assert not tab.state.design.tuning


def test_flights_rise_as_high_as_the_apex_says_and_last_as_they_like():
    tab = planned_tab()
    height = handles_of(tab.state).apex.height
    tab.take(PhasesDragged((0.43, 0.47), begins=True))
    tab.settle()
    tab.take(ApexDragged(height - 0.05, begins=True))
    assert middle(tab, "apex") == pytest.approx(height - 0.05, abs=1e-3)
    assert {"flight_min", "flight_max"}.isdisjoint(limits(tab))
    assert middle(tab, "takeoff") == pytest.approx(0.43)
    tab.take(PhasesDragged((0.43, 0.47), begins=True))
    assert {"apex_min", "apex_max"}.isdisjoint(limits(tab))
    tab.take(ApexDragged(height, begins=True))
    tab.take(ApexDragged(None, begins=True))
    assert {"apex_min", "apex_max"}.isdisjoint(limits(tab))


@pytest.mark.parametrize(("rise", "end"), [(0.3, "flight_max"), (-0.25, "flight_min")])
def test_an_apex_that_takes_other_flights_than_the_robots_has_them(rise, end):
    tab = planned_tab()
    tab.take(ApexDragged(handles_of(tab.state).apex.height + rise, begins=True))
    own = limits_of(tab.state.robot)[end][1]
    assert (limits(tab)[end] - own) * rise > 0


def test_nothing_is_dragged_to_where_no_plan_may_be():
    rng = np.random.default_rng(5)
    tab = planned_tab()
    for _ in range(100):
        if rng.random() < 0.5:
            tab.take(PhasesDragged(tuple(rng.uniform(0, 3, rng.integers(0, 9))), begins=True))
        else:
            tab.take(ApexDragged(rng.uniform(-2, 9), begins=True))
        make_task(tab.state.design.jump, tab.state.robot, None, limits(tab))


def test_one_drag_is_one_step_back():
    tab = planned_tab()
    before = tab.state.design
    for number, height in enumerate((0.60, 0.61, 0.62)):
        tab.take(ApexDragged(height, begins=number == 0))
    tab.take(PhasesDragged((0.45, 0.5), begins=True))
    tab.settle()  # the hand rests
    tab.take(PhasesDragged((0.46, 0.49), begins=False))
    tab.take(Act.UNDO)
    assert middle(tab, "apex") == pytest.approx(0.62)
    tab.take(Act.UNDO)
    assert tab.state.design == before


def test_twenty_edits_are_undone_to_the_last_bit():
    rng = np.random.default_rng(44)
    tab = planned_tab()
    before = []
    for number in range(20):
        before.append((tab.state.design, tab.state.shown))
        durations = tuple(rng.uniform(0.3, 0.6, 2 + number % 2).tolist())
        height = rng.uniform(0.6, 0.9)
        tab.take(ApexDragged(height, True) if number % 3 else PhasesDragged(durations, True))
        tab.settle()
    for design, shown in reversed(before):
        tab.take(Act.UNDO)
        assert tab.state.design == design
        assert tab.state.shown is shown


def test_without_a_plan_of_the_design_nothing_can_be_dragged():
    tab = planned_tab()
    tab.move(type="rear-last")
    design = tab.state.design
    assert handles_of(tab.state) is None
    assert tab.take(PhasesDragged((0.4,), begins=True)) == ()
    assert tab.take(ApexDragged(0.7, begins=True)) == ()
    assert tab.state.design == design
