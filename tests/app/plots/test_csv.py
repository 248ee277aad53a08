from __future__ import annotations

import csv
import io

import numpy as np
import pytest

from app.motion import colours
from app.motion.baked import bake_plan
from app.plots.charts import Layer, charts, csv_of, shown_layers
from app.plots.choice import LANDING, PRESETS, ChartChoice, PlotChoice
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot
from tests.app.synthetic_plan import synthetic_plan
from tests.llsrbm.synthetic_rollout import synthetic_rollout


@pytest.fixture(scope="module")
def layers():
    planned = bake_plan(synthetic_plan(Jump(twist=1.0)), load_robot("anymal"))
    return shown_layers(planned, synthetic_rollout(planned.plan))


def read(content):
    """Column -> its cells, without the empty ones at the end."""
    header, *rows = csv.reader(io.StringIO(content.decode("utf-8")))
    columns = zip(*rows, strict=True)
    return {name: [c for c in cells if c] for name, cells in zip(header, columns, strict=True)}


@pytest.mark.parametrize("choice", PRESETS.values(), ids=PRESETS)
def test_every_line_is_there_at_its_own_instants(layers, choice):
    columns = read(csv_of(layers, choice))
    names, time = iter(columns.items()), None
    found = {}
    for name, cells in names:
        if name.startswith("time of "):
            assert name.endswith(" [s]")
            time = np.array(cells, dtype=float)
        else:
            found[name] = (time, np.array(cells, dtype=float))
    for chart in charts(choice, layers):
        for line in chart.lines:
            unit = f" [{line.unit}]" if line.unit else ""
            time, values = found.pop(f"{chart.title}, {line.name}{unit}")
            assert time == pytest.approx(line.time, abs=1e-8)
            assert values == pytest.approx(line.values, rel=1e-8, abs=1e-300)
    assert found == {}


def test_lines_with_the_same_instants_share_a_time_column(layers):
    columns = read(csv_of(layers, PRESETS["CoM position"]))
    assert list(columns) == [
        "time of plan [s]",
        *(f"CoM position, {axis}, plan [m]" for axis in "xyz"),
        "time of simulation [s]",
        *(f"CoM position, {axis}, simulation [m]" for axis in "xyz"),
    ]


def test_there_is_neither_nan_nor_negative_zero(layers):
    plan = layers[0]
    motion = plan.motion.motion
    motion.com[0] = -0.0
    motion.com[1] = np.nan
    (x, *_) = [c for n, c in read(csv_of([plan], PRESETS["CoM position"])).items() if "x, " in n]
    assert x[0] == "0"
    assert len(x) == len(motion.time) - 1


def test_names_cannot_break_the_table(layers):
    nasty = Layer('=1+1,"\n', colours.PINNED[0], layers[0].motion, None, pinned=True)
    choice = PlotChoice((ChartChoice("com", ("z",)),))
    assert len(read(csv_of([nasty], choice))) == 2


def test_nothing_is_an_empty_table(layers):
    assert csv_of((), PRESETS[LANDING]) == b""
    assert csv_of(layers, PlotChoice(())) == b""
