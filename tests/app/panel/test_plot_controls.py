"""The choice of charts, spoken to as a browser (or a hostile script) would."""

from dataclasses import replace

import pytest

from app.link import ChartDropped
from app.panel.acts import Act
from app.plots.charts import csv_of
from app.plots.choice import DEFAULT, PRESETS, TORQUES, ChartChoice
from app.tab.effects import Download
from app.tab.plotting import layers_of
from tests.app.pure_tab import planned_tab

FEET = ChartChoice("foot_force", ("RH z",))


@pytest.fixture
def chosen(tab, session):
    """Waits until the charts that are chosen are as a condition asks."""

    def wait(condition, what):
        tab.wait(lambda: condition(session.state.plots), what)
        return session.state.plots

    return wait


def test_menus_and_buttons_choose_charts(tab, chosen):
    tab.set("Quantity", "Foot force")
    tab.wait(lambda: "RH z" in tab.control("Component")["props"]["options"], "the feet")
    tab.set("Component", "RH z")
    tab.press("Add chart")
    chosen(lambda plots: plots.charts == (*DEFAULT.charts, FEET), "the fifth chart")
    tab.wait(lambda: tab.control("Preset")["value"] == "Custom", "no preset")
    tab.wait(lambda: tab.value("Chart") == "Foot force, RH z", "the last one, to be removed")
    tab.set("Chart", "Inertia, zz")
    tab.press("Remove chart")
    zz = ChartChoice("inertia", ("zz",))
    chosen(lambda p: len(p.charts) == 4 and zz not in p.charts, "less one")
    tab.set("Preset", TORQUES)
    kinds = ["all joints", "HAA", "HFE", "KFE"]
    tab.wait(lambda: list(tab.control("Joints")["props"]["options"]) == kinds, "ANYmal's joints")
    tab.set("Joints", "HFE")
    tab.set("Landing zoom", True)
    plots = chosen(lambda plots: plots.landing, "the zoom")
    assert plots == replace(plots.with_preset(TORQUES).with_joints("HFE"), landing=True)


def test_moves_at_once_all_count(tab, chosen):
    """They come faster than the session draws."""
    tab.set("Preset", TORQUES)
    tab.set("Landing zoom", True)
    tab.set("Quantity", "Mode")
    chosen(lambda plots: plots.offered == ChartChoice("mode"), "the quantity")
    plots = chosen(lambda plots: plots.landing, "the zoom")
    assert plots.charts == PRESETS[TORQUES].charts


def test_what_cannot_be_chosen_is_told(tab, chosen):
    for label in ("Preset", "Quantity", "Component", "Chart"):
        tab.set(label, ["no", "such"])
    tab.set("Landing zoom", True)
    assert chosen(lambda plots: plots.landing, "the zoom").charts == DEFAULT.charts
    tab.wait(lambda: "Quantity: expected" in str(tab.notifications), "the complaint")
    tab.wait(lambda: tab.value("Quantity") == "CoM position", "the menu as it was")


def test_the_lines_that_are_shown_become_a_file():
    tab = planned_tab()
    tab.take(PRESETS["CoM position"])
    tab.take(Act.PIN)
    tab.take(Act.SAVE_LINES)
    content = csv_of(layers_of(tab.state), PRESETS["CoM position"])
    assert tab.one == Download("plots.csv", content)
    assert content.count(b"CoM position, z") == 2  # of the pin, and of the plan


def test_a_dropped_chart_shares_the_other_ones_place():
    tab = planned_tab()
    angle, force = "Base angle, yaw [\u00b0]", "Vertical force, all feet [N]"
    for dropped in (force, None):  # None: what is on offer
        tab.take(ChartDropped(dropped, angle))
    yaw, *_ = tab.state.plots.charts
    assert [part.signal for part in yaw.parts] == ["base_angle", "vertical_force"]
    assert len(tab.state.plots.charts) == 3
    before = tab.state.plots
    tab.take(ChartDropped("no such chart", angle))
    assert tab.state.plots == before
