"""From what is chosen to what is drawn and written: choices, figures, tables."""

import csv
import io
from dataclasses import replace

import numpy as np
import pytest

from app.motion import colours
from app.motion.baked import bake_plan
from app.plots.charts import Layer, charts, csv_of, shown_layers
from app.plots.choice import (
    ALL_JOINTS,
    DEFAULT,
    LANDING,
    MOST_CHARTS,
    OVERVIEW,
    OWN,
    PRESETS,
    TORQUES,
    ChartChoice,
    PlotChoice,
)
from app.plots.drawing import legend
from app.plots.figure import ABOVE, figure
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot
from tests.app.synthetic_plan import FLY, STAND, synthetic_plan


@pytest.fixture(scope="module")
def layers(planned, rollout):
    pinned = [
        Layer(f"pin {i}", rgb, planned, rollout, True) for i, rgb in enumerate(colours.PINNED)
    ]
    return (*pinned, *shown_layers(planned, rollout))


@pytest.fixture
def both(planned, rollout):
    return shown_layers(planned, rollout)


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
        "touchdown planned": planned.plan.phase_start[2],
        "touchdown": outcome.touchdown_true_s,
        "detected": outcome.touchdown_detected_s,
    }
    # A tick of 2.5 ms can be told apart.
    assert drawn.grid.spacing < 0.0025
    assert drawn.grid.time[0] < min(marked.values()) - 0.09
    assert drawn.grid.time[-1] > max(marked.values()) + 0.2


def test_a_robot_that_never_landed_has_no_such_mark(planned, rollout):
    outcome = replace(rollout.outcome, touchdown_true_s=None, touchdown_detected_s=None)
    flying = replace(rollout, outcome=outcome)
    for group, expected in ((LANDING, ["touchdown planned"]), ("Overview", [])):
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
    assert [mark.title for mark in drawn.marks] == ["touchdown planned"] * 3
    # Only the last one is looked at closely.
    assert drawn.grid.time[0] > starts[2]
    assert legend(drawn).count("touchdown planned") == 1


# ---- as a table


def read(content):
    """Column -> its cells, without the empty ones at the end."""
    header, *rows = csv.reader(io.StringIO(content.decode("utf-8")))
    columns = zip(*rows, strict=True)
    return {name: [c for c in cells if c] for name, cells in zip(header, columns, strict=True)}


@pytest.mark.parametrize("choice", PRESETS.values(), ids=PRESETS)
def test_every_line_is_there_at_its_own_instants(both, choice):
    columns = read(csv_of(both, choice))
    names, time = iter(columns.items()), None
    found = {}
    for name, cells in names:
        if name.startswith("time of "):
            assert name.endswith(" [s]")
            time = np.array(cells, dtype=float)
        else:
            found[name] = (time, np.array(cells, dtype=float))
    for chart in charts(choice, both):
        for line in chart.lines:
            unit = f" [{line.unit}]" if line.unit else ""
            time, values = found.pop(f"{chart.title}, {line.name}{unit}")
            assert time == pytest.approx(line.time, abs=1e-8)
            assert values == pytest.approx(line.values, rel=1e-8, abs=1e-300)
    assert found == {}


def test_lines_with_the_same_instants_share_a_time_column(both):
    columns = read(csv_of(both, PRESETS["CoM position"]))
    assert list(columns) == [
        "time of plan [s]",
        *(f"CoM position, {axis}, plan [m]" for axis in "xyz"),
        "time of simulation [s]",
        *(f"CoM position, {axis}, simulation [m]" for axis in "xyz"),
    ]


def test_there_is_neither_nan_nor_negative_zero(both):
    plan = both[0]
    motion = plan.motion.motion
    motion.com[0] = -0.0
    motion.com[1] = np.nan
    (x, *_) = [c for n, c in read(csv_of([plan], PRESETS["CoM position"])).items() if "x, " in n]
    assert x[0] == "0"
    assert len(x) == len(motion.time) - 1


def test_names_cannot_break_the_table(both):
    nasty = Layer('=1+1,"\n', colours.PINNED[0], both[0].motion, None, pinned=True)
    choice = PlotChoice((ChartChoice("com", ("z",)),))
    assert len(read(csv_of([nasty], choice))) == 2


# ---- choices


@pytest.mark.parametrize("name", PRESETS)
def test_a_preset_is_known_by_its_charts(name):
    assert PlotChoice((), open=False).with_preset(name).preset == name
    assert not PlotChoice((), open=False).with_preset(name).open
    added = PRESETS[name].with_offered()
    assert (added.preset == OWN) == (added != PRESETS[name])
    assert PRESETS[name].without_removed().preset == OWN


def test_a_chart_is_added_once():
    choice = PlotChoice((), offered=ChartChoice("foot_force", ("LF",)))
    once = choice.with_offered()
    assert once.charts == (ChartChoice("foot_force", ("LF",)),)
    assert once.with_offered() == once
    assert once.without_removed() == choice


def test_a_chart_is_dropped_onto_another_one():
    com, yaw, force = (ChartChoice(key) for key in ("com", "base_angle", "vertical_force"))
    choice = PlotChoice((com, yaw, force))
    joined = choice.with_joined(force, com)
    assert joined.charts == (replace(com, more=(force,)), yaw)
    # What was joined is one chart like others; what is on offer need not have been one.
    again = joined.with_joined(joined.charts[0], yaw).with_joined(ChartChoice("mode"), yaw)
    assert again.charts == (replace(yaw, more=(com, force)),)
    assert choice.with_joined(com, com) == choice
    many = replace(com, more=(yaw, force, ChartChoice("mode")))
    full = PlotChoice((many, ChartChoice("detection")))
    assert full.with_joined(full.charts[1], many) == full


def test_joints_are_those_of_the_loads():
    assert DEFAULT.joints is None
    assert DEFAULT.with_joints("KFE") == DEFAULT
    torques = PRESETS[TORQUES]
    assert torques.joints == ALL_JOINTS
    knees = torques.with_joints("KFE")
    assert (knees.joints, knees.preset) == ("KFE", TORQUES)
    assert knees.with_joints(ALL_JOINTS) == torques


def test_there_are_not_too_many_charts():
    choice = PlotChoice(tuple(ChartChoice("com", (str(i),)) for i in range(MOST_CHARTS)))
    assert choice.with_offered() == choice
