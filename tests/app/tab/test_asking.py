"""A part of the robot is asked what it does, and put into the plots."""

from __future__ import annotations

import pytest

from app.link import PartAsked, PartPlotted
from app.plots.choice import ChartChoice
from app.tab.effects import ShowPart
from tests.app.pure_tab import PureTab, planned_tab


@pytest.fixture(scope="module")
def shown():
    return planned_tab()


def test_a_part_says_what_it_does(shown):
    shown.take(PartAsked("LF_KFE"))
    (shows,) = shown.of(ShowPart)
    assert shows.reading["part"] == "LF_KFE"
    assert "Torque" in [row["title"] for row in shows.reading["rows"]]


def test_of_a_part_that_is_not_there_nothing_is_known(shown):
    shown.take(PartAsked("tail"))
    (shows,) = shown.of(ShowPart)
    assert shows.reading["rows"] == []


def test_before_there_is_a_motion_nothing_is_said():
    tab = PureTab()
    assert tab.take(PartAsked("LF_KFE")) == ()


def test_a_row_becomes_a_chart_once():
    tab = planned_tab()
    charts = tab.state.plots.charts
    for _ in range(2):
        tab.take(PartPlotted("LF_KFE", 2))
        assert tab.state.plots.charts == (*charts, ChartChoice("joint_torque", ("LF_KFE",)))
    assert tab.state.plots.open
    tab.take(PartPlotted("LF_KFE", 99))
    tab.take(PartPlotted("tail", 0))
    assert len(tab.state.plots.charts) == len(charts) + 1
