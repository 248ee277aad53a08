import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.plots.figure import ABOVE, BELOW, POINTS, TimeGrid

GRID = TimeGrid.over(0.0, 2.0, (0.5, 1.2345))


@st.composite
def curve(draw, longest=1500):
    """Samples within the grid, as spiky as can be."""
    count = draw(st.integers(2, longest))
    seed = draw(st.integers(0, 2**32 - 1))
    rng = np.random.default_rng(seed)
    time = np.sort(rng.choice(np.linspace(0.0, 2.0, 4 * longest), count, replace=False))
    values = rng.normal(size=count)
    if draw(st.booleans()):
        values = np.round(values)
    if draw(st.booleans()):
        values = np.cumsum(values)
    if draw(st.booleans()):
        values[rng.random(count) < 0.95] = 0.0
    return time, values


@given(curve())
def test_no_extremum_is_lost(samples):
    time, values = samples
    seen = GRID.sample(time, values)
    assert np.nanmax(seen) == pytest.approx(values.max(), rel=1e-12)
    assert np.nanmin(seen) == pytest.approx(values.min(), rel=1e-12)


@given(st.integers(0, 2000))
def test_a_spike_is_drawn_where_it_is(tick):
    time = np.linspace(0.0, 2.0, 2001)
    values = np.sin(time)
    values[tick] = 9.0
    seen = GRID.sample(time, values)
    assert np.count_nonzero(seen == 9.0) >= 1
    assert np.abs(GRID.time[seen == 9.0] - time[tick]).max() <= 1.5 * GRID.spacing + 1e-9


def test_a_dip_and_a_peak_between_two_instants_keep_their_order():
    time = np.linspace(0.0, 2.0, 20001)
    for first, second in ((-1.0, 1.0), (1.0, -1.0)):
        values = np.zeros(len(time))
        values[[7003, 7008]] = first, second
        seen = GRID.sample(time, values)
        assert seen[seen != 0].tolist() == [first, second]


@given(curve(longest=150))
def test_values_are_the_samples_or_lie_between_them(samples):
    time, values = samples
    seen = GRID.sample(time, values)
    known = np.isfinite(seen)
    inside = known & (GRID.time >= time[0]) & (GRID.time <= time[-1])
    straight = np.interp(GRID.time, time, values)
    for k in np.flatnonzero(inside & ~np.isclose(seen, straight)):
        near = np.abs(time - GRID.time[k]) <= 1.5 * GRID.spacing + 1e-9
        around = values[near]
        if GRID.time[k] in GRID.marks:
            continue  # on the line between its neighbours
        assert np.isclose(around, seen[k]).any()


def test_there_is_nothing_where_a_curve_has_ended():
    time = np.linspace(0.3, 1.1, 50)
    seen = GRID.sample(time, np.ones(50))
    slack = 1.5 * GRID.spacing
    assert np.isnan(seen[(GRID.time < 0.3 - slack) | (GRID.time > 1.1 + slack)]).all()
    assert (seen[(GRID.time >= 0.3) & (GRID.time <= 1.1)] == 1).all()


def test_what_is_not_finite_is_absent():
    time = np.linspace(0.0, 2.0, 50)
    values = np.ones(50)
    values[[3, 17, 49]] = np.nan, np.inf, -np.inf
    seen = GRID.sample(time, values)
    assert (seen[: POINTS // 2] == 1).all()
    assert np.isnan(GRID.sample(time, np.full(50, np.nan))).all()
    assert np.isnan(GRID.sample(time + 5, np.ones(50))).all()


def test_steps_are_upright_at_marks():
    step = GRID.step(1.2345)
    rise = np.flatnonzero(np.diff(step))
    assert len(rise) == 1
    assert GRID.time[rise[0]] == GRID.time[rise[0] + 1] == 1.2345
    between = GRID.between(0.5, 1.2345)
    assert GRID.time[between == ABOVE][[0, -1]].tolist() == [0.5, 1.2345]
    assert set(between[GRID.time < 0.5]) == set(between[GRID.time > 1.2345]) == {BELOW}


def test_marks_outside_are_left_out():
    assert len(TimeGrid.over(1.0, 2.0, (0.5, 1.5, 2.5)).time) == POINTS + 2
