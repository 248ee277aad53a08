"""The plots of a tab, as they go over the line."""

import math
from dataclasses import replace

import numpy as np
import pytest

from app.guard.policy import Guard
from app.guard.token import Access
from app.motion import colours
from app.motion.baked import bake_plan
from app.page_template import page as designer_page
from app.plots.charts import Layer, shown_layers
from app.plots.choice import DEFAULT, FEWER, PRESETS, TORQUES, ChartChoice, of_jump
from app.plots.plots import Plots
from app.plots.signals import SIGNALS
from app.viser_private import DesignerServer
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot
from tests.app.raw_tab import RawTab
from tests.app.synthetic_plan import synthetic_plan
from tests.app.waits import wait_until

MINIMISED = "GuiSetPanelCollapsedMessage"


def charts(tab):
    """Props of the charts in sight, by title."""
    found = [m["props"] for m in tab.controls.values() if m["type"] == "GuiUplotMessage"]
    return {props["title"]: props for props in found if props["visible"]}


def lines(props):
    return [series["label"] for series in props["series"] if series.get("scale") == "y"]


class PlotPage:
    """Plots alone."""

    def __init__(self, designer_server, tab):
        self.tab = tab
        client = max(designer_server.get_clients().items())[1]
        self.plots = Plots(client, ("open", "seen", "add"))

    def draw(self, layers, choice, **how):
        self.plots.draw(layers, 1.3, choice, **how)

    def draw_overview(self, layers):
        self.draw(layers, DEFAULT)
        self.tab.wait(lambda: len(charts(self.tab)) == 4, "the overview")


@pytest.fixture(scope="module")
def served():
    guard = Guard(Access(None), (), loopback=True)
    server = DesignerServer("127.0.0.1", 0, guard, designer_page)
    guard.access.port = server.get_port()
    yield server
    server.stop()


@pytest.fixture
def page(served):
    with RawTab(served.get_port()) as tab:
        tab.wait(lambda: served.get_clients(), "the connection")
        made = PlotPage(served, tab)
        tab.wait(lambda: len(tab.scripts) == 1, "the scripts")
        yield made
    wait_until(lambda: not served.get_clients(), "the end of it")


@pytest.fixture(scope="module")
def layers(planned):
    return shown_layers(planned, None)


def test_only_chosen_charts_are_sent(page, layers):
    page.draw_overview(layers)
    page.draw(layers, PRESETS["CoM position"])
    titles = [f"CoM position, {axis} [m]" for axis in "xyz"]
    page.tab.wait(lambda: list(charts(page.tab)) == titles, "three charts")
    for props in charts(page.tab).values():
        assert lines(props) == ["plan"]
        assert len(props["series"]) == len(props["data"])
        assert {len(row) for row in props["data"]} == {len(props["data"][0])}


def test_nothing_is_sent_where_nothing_changed(page, layers, planned):
    page.draw_overview(layers)
    drawn = page.tab.received["GuiUpdateMessage"]
    page.draw(layers, DEFAULT)
    # Layers that were made anew of the same motions.
    page.draw(shown_layers(planned, None), DEFAULT)
    page.draw(layers, replace(DEFAULT, offered=ChartChoice("mode")))
    page.draw(layers, replace(DEFAULT, landing=True))
    page.tab.wait(lambda: page.tab.received["GuiUpdateMessage"] > drawn, "other data")
    assert page.tab.received["GuiUpdateMessage"] - drawn <= 4 * 3 + 1, (
        "scales, series and data, once, and the legend"
    )


def test_a_closed_area_gets_no_data(page, layers):
    page.draw_overview(layers)
    before = page.tab.received[MINIMISED]
    page.draw(layers, replace(DEFAULT, open=False))
    page.tab.wait(lambda: page.tab.received[MINIMISED] == before + 1, "minimised")
    assert charts(page.tab) == {}
    page.draw_overview(layers)
    assert page.tab.received[MINIMISED] == before + 2


def test_what_the_page_closed_is_not_closed_again(page, layers):
    page.draw_overview(layers)
    before = page.tab.received[MINIMISED]
    page.draw(layers, replace(DEFAULT, open=False), area_open=False)
    page.tab.wait(lambda: charts(page.tab) == {}, "no charts")
    assert page.tab.received[MINIMISED] == before


def test_pinned_designs_lie_under_the_one_that_is_shown(page, layers):
    slider = bake_plan(synthetic_plan(Jump(robot="slider")), load_robot("slider"))
    pinned = Layer("pin", colours.PINNED[0], slider, None, pinned=True)
    page.draw((pinned, *layers), PRESETS[TORQUES])
    page.tab.wait(lambda: len(charts(page.tab)) == 4, "the charts")
    shown = charts(page.tab)["Largest joint speed / limit"]
    assert lines(shown) == ["limit", "pin", "plan"]
    page.draw((), PRESETS[TORQUES])
    page.tab.wait(lambda: charts(page.tab) == {}, "nothing")


@pytest.mark.parametrize(
    ("jump", "first", "axis"),
    [
        (Jump(twist=1.5), ("base_angle", ("yaw",)), "z"),
        (Jump(robot="go2", type="flip", pitch=-math.tau), ("turned", ("y",)), "y"),
        (Jump(robot="go2", type="barrel-roll", roll=math.tau), ("turned", ("x",)), "x"),
        (Jump(forward=0.3), ("com", ("z",)), None),
        (Jump(lateral=0.2), ("com", ("z",)), None),
    ],
)
@pytest.mark.parametrize("choice", [DEFAULT, FEWER])
def test_an_overview_is_of_what_the_jump_is_about_and_keeps_its_name(choice, jump, first, axis):
    """Of a turn its rate and the inertia are shown however few charts there is room for."""
    found = of_jump(choice, jump)
    assert (found.preset, len(found.charts)) == (choice.preset, len(choice.charts))
    assert of_jump(found, Jump(twist=1.5)) == choice  # back again
    if choice is DEFAULT or axis is None:
        assert (found.charts[0].signal, found.charts[0].components) == first
    if axis:
        rate = ChartChoice("angular_velocity", (axis,)), ChartChoice("inertia", (2 * axis,))
        assert [*rate] == [chart for chart in found.charts if chart in rate]


def test_charts_of_ones_own_are_those_of_every_jump():
    own = PRESETS["Principal inertias"]
    assert of_jump(own, Jump(forward=0.3)) is own


def test_a_flips_angle_goes_around_without_a_step():
    flip = synthetic_plan(Jump(robot="go2", type="flip", pitch=-math.tau))
    robot = load_robot("go2")
    layers = shown_layers(bake_plan(flip, robot), None)
    turned = SIGNALS["turned"].of(layers[0].series)
    column = [component.name for component in turned.components].index("y")
    angle = turned.values[:, column]
    expected = np.degrees(np.trapezoid(layers[0].series.motion.angular_velocity[:, 1], turned.time))
    assert angle[-1] == pytest.approx(expected)
    assert np.abs(np.diff(angle)).max() < 90
