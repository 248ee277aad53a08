from __future__ import annotations

import pytest

from app.plots.choice import (
    ALL_JOINTS,
    DEFAULT,
    MOST_CHARTS,
    OWN,
    PRESETS,
    TORQUES,
    ChartChoice,
    PlotChoice,
)


@pytest.mark.parametrize("name", PRESETS)
def test_a_preset_is_known_by_its_charts(name):
    assert PlotChoice((), open=False).with_preset(name).preset == name
    assert not PlotChoice((), open=False).with_preset(name).open
    added = PRESETS[name].with_offered()
    assert (added.preset == OWN) == (added != PRESETS[name])
    assert PRESETS[name].without(0).preset == OWN


def test_a_chart_is_added_once():
    choice = PlotChoice((), offered=ChartChoice("foot_force", ("LF",)))
    once = choice.with_offered()
    assert once.charts == (ChartChoice("foot_force", ("LF",)),)
    assert once.with_offered() == once
    assert once.without(0) == choice


def test_there_are_not_too_many_charts():
    choice = PlotChoice(tuple(ChartChoice("com", (str(i),)) for i in range(MOST_CHARTS)))
    assert choice.with_offered() == choice


def test_joints_are_those_of_the_loads():
    assert DEFAULT.joints is None
    assert DEFAULT.with_joints("KFE") == DEFAULT
    torques = PRESETS[TORQUES]
    assert torques.joints == ALL_JOINTS
    knees = torques.with_joints("KFE")
    assert (knees.joints, knees.preset) == ("KFE", TORQUES)
    assert knees.with_joints(ALL_JOINTS) == torques
