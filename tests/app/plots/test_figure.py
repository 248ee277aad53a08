from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.motion import colours
from app.motion.baked import bake_plan
from app.plots.charts import Layer, charts, shown_layers
from app.plots.choice import LANDING, OVERVIEW, PRESETS
from app.plots.drawing import legend
from app.plots.figure import figure
from app.plots.time_grid import ABOVE
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot
from tests.app.synthetic_plan import FLY, STAND, synthetic_plan
from tests.llsrbm.synthetic_rollout import synthetic_rollout


@pytest.fixture(scope="module")
def planned():
    return bake_plan(synthetic_plan(Jump(twist=1.0)), load_robot("anymal"))


@pytest.fixture(scope="module")
def rollout(planned):
    return synthetic_rollout(planned.plan)


@pytest.fixture(scope="module")
def layers(planned, rollout):
    pinned = [
        Layer(f"pin {i}", rgb, planned, rollout, True) for i, rgb in enumerate(colours.PINNED)
    ]
    return (*pinned, *shown_layers(planned, rollout))


@pytest.mark.parametrize("group", PRESETS)
def test_a_curve_has_at_most_400_points(group, layers, rollout):
    drawn = figure(PRESETS[group], layers, rollout.time[-1])
    assert drawn.charts
    count = len(drawn.grid.time)
    assert count <= 400
    assert (np.diff(drawn.grid.time) >= 0).all()
    for chart in drawn.charts:
        assert {line.values.shape for line in chart.lines} == {(count,)}


def test_peaks_of_every_curve_are_drawn(layers, rollout):
    drawn = figure(PRESETS["Contact forces"], layers, rollout.time[-1])
    for sampled, chart in zip(drawn.charts, charts(PRESETS["Contact forces"], layers), strict=True):
        for points, line in zip(sampled.lines, chart.lines, strict=True):
            assert points.look == line.look
            assert np.nanmax(points.values) == pytest.approx(line.values.max())
            assert np.nanmin(points.values) == pytest.approx(line.values.min())


def test_the_plan_ends_before_the_simulation(planned, rollout):
    drawn = figure(PRESETS["CoM position"], shown_layers(planned, rollout), rollout.time[-1])
    ends = {}
    for line in drawn.charts[0].lines:
        ends[line.title] = line.time[np.isfinite(line.values)][-1]
    slack = 1.5 * drawn.grid.spacing
    assert ends["plan"] == pytest.approx(planned.plan.duration, abs=slack)
    assert ends["simulation"] == pytest.approx(rollout.time[-1], abs=slack)


@pytest.mark.parametrize(("end", "axis"), [(1.3, 1.5), (1.5, 1.5), (1.501, 1.75), (2.3, 2.5)])
def test_time_axes_do_not_follow_every_plan(planned, end, axis):
    drawn = figure(PRESETS[OVERVIEW], shown_layers(planned, None), end)
    assert drawn.grid.time[[0, -1]].tolist() == [0.0, axis]


def test_flight_is_shaded(planned):
    drawn = figure(PRESETS[OVERVIEW], shown_layers(planned, None), planned.plan.duration)
    shaded = drawn.grid.time[drawn.flight == ABOVE]
    assert shaded[[0, -1]] == pytest.approx([STAND, STAND + FLY])
    assert drawn.marks == ()


def test_touchdowns_are_marked(planned, rollout):
    drawn = figure(PRESETS[LANDING], shown_layers(planned, rollout), rollout.time[-1])
    marked = {
        mark.title: mark.time[np.flatnonzero(np.diff(mark.values))[0]] for mark in drawn.marks
    }
    outcome = rollout.outcome
    assert marked == {
        "touch-down planned": planned.plan.phase_start[2],
        "touch-down": outcome.touchdown_true_s,
        "detected": outcome.touchdown_detected_s,
    }
    # A tick of 2.5 ms can be told apart.
    assert drawn.grid.spacing < 0.0025
    assert drawn.grid.time[0] < min(marked.values()) - 0.09
    assert drawn.grid.time[-1] > max(marked.values()) + 0.2


def test_a_robot_that_never_landed_has_no_such_mark(planned, rollout):
    outcome = replace(rollout.outcome, touchdown_true_s=None, touchdown_detected_s=None)
    flying = replace(rollout, outcome=outcome)
    for group, expected in ((LANDING, ["touch-down planned"]), ("Overview", [])):
        drawn = figure(PRESETS[group], shown_layers(planned, flying), rollout.time[-1])
        assert [mark.title for mark in drawn.marks] == expected


def test_pinned_designs_have_no_marks(layers, rollout):
    drawn = figure(PRESETS[OVERVIEW], layers, rollout.time[-1])
    assert [mark.colour for mark in drawn.marks] == [colours.SIMULATED]


def test_every_flight_is_shaded_and_its_touchdown_marked():
    hops = bake_plan(synthetic_plan(Jump(type="hops", hops=3)), load_robot("anymal"))
    layers = shown_layers(hops, None)
    drawn = figure(PRESETS[OVERVIEW], layers, hops.plan.duration)
    shaded = drawn.flight == ABOVE
    edges = drawn.grid.time[np.flatnonzero(np.diff(shaded.astype(int)))]
    starts = [STAND + k * (STAND + FLY) for k in range(3)]
    assert edges == pytest.approx(np.add.outer(starts, [0, FLY]).ravel())
    drawn = figure(PRESETS[LANDING], layers, hops.plan.duration)
    assert [mark.title for mark in drawn.marks] == ["touch-down planned"] * 3
    # Only the last one is looked at closely.
    assert drawn.grid.time[0] > starts[2]
    assert legend(drawn).count("touch-down planned") == 1
