"""The plots of a tab, as they go over the line."""

from __future__ import annotations

import numpy as np

from app.motion import colours
from app.motion.planned_motion import bake_plan
from app.plots.charts import GROUPS, TORQUES, Layer, shown_layers
from app.plots.plots import Plots
from app.plots.time_grid import ABOVE
from llsrbm.jump import Jump
from llsrbm.robots import load_robot
from tests.app.synthetic_plan import synthetic_plan


def charts(tab):
    """Props of the charts in sight, by title."""
    found = [m["props"] for m in tab.controls.values() if m["type"] == "GuiUplotMessage"]
    return {props["title"]: props for props in found if props["visible"]}


def lines(props):
    return [series["label"] for series in props["series"] if series.get("scale") == "y"]


def choose(tab, group):
    tab.set("Quantity", group)
    first = {
        "Overview": "Base yaw [°]",
        "CoM position": "CoM x [m]",
        TORQUES: "Joint speed / limit",
    }[group]
    tab.wait(lambda: first in charts(tab), group)


def test_only_the_chosen_group_is_sent(tab):
    assert len(charts(tab)) == 4
    choose(tab, "CoM position")
    shown = charts(tab)
    assert list(shown) == ["CoM x [m]", "CoM y [m]", "CoM z [m]"]
    for props in shown.values():
        assert lines(props) == ["plan"]
        assert len(props["series"]) == len(props["data"])
        assert {len(row) for row in props["data"]} == {len(props["data"][0])}


def test_charts_are_in_the_folder(tab):
    uuids = {m["props"].get("label"): m["uuid"] for m in tab.controls.values()}
    containers = {
        m["container_uuid"] for m in tab.controls.values() if m["type"] == "GuiUplotMessage"
    }
    (container,) = containers
    assert tab.controls[container]["container_uuid"] == uuids["Plots"]


def test_a_simulation_joins_the_plan(tab):
    tab.press("Simulate")
    tab.wait_for_status("Landed")
    tab.wait(lambda: lines(charts(tab)["CoM height [m]"]) == ["plan", "simulation"], "both")
    props = charts(tab)["CoM height [m]"]
    strokes = {series["label"]: series.get("stroke") for series in props["series"]}
    assert strokes["plan"] == colours.css(colours.PLANNED)
    assert strokes["simulation"] == colours.css(colours.SIMULATED)
    assert props["scales"]["x"] == {"time": False, "range": [0.0, 2.5]}
    assert "simulation" in tab.text()
    # A new plan takes the simulation away.
    tab.set("Twist [deg]", 30)
    tab.wait(lambda: lines(charts(tab)["CoM height [m]"]) == ["plan"], "the plan alone")


def test_joints_are_chosen_where_there_are_torques(tab):
    assert not tab.control("Joints")["props"]["visible"]
    choose(tab, TORQUES)
    assert tab.control("Joints")["props"]["visible"]
    assert list(tab.control("Joints")["props"]["options"]) == ["all", "HAA", "HFE", "KFE"]
    tab.set("Joints", "HFE")
    tab.wait(lambda: "Joint speed / limit, HFE" in charts(tab), "the hips")
    choose(tab, "Overview")
    assert not tab.control("Joints")["props"]["visible"]


def test_what_cannot_be_chosen_is_ignored(tab):
    choose(tab, "CoM position")
    tab.set("Quantity", ["no", "group"])
    tab.wait(lambda: "Base yaw [°]" in charts(tab), "the first group instead")
    tab.set("Twist [deg]", 30)
    tab.wait(lambda: charts(tab)["Base yaw [°]"]["data"][-1][-60] > 29, "the next plan")


def test_a_scrubbed_motion_has_a_cursor(tab, session, monkeypatch):
    # A page whose scripts do not answer draws no cursor of its own.
    monkeypatch.setattr(session._stage, "_give_up_at", 0.0)
    tab.set("Time [s]", 0.7)

    def cursor():
        time, _, step = charts(tab)["CoM height [m]"]["data"][:3]
        return time[step == ABOVE][0] if (step == ABOVE).any() else np.inf

    tab.wait(lambda: abs(cursor() - 0.7) < 0.02, "the cursor")


def test_pinned_designs_lie_under_the_one_that_is_shown(tab, designer):
    client = max(designer._server.get_clients().items())[1]
    slider, anymal = (
        bake_plan(synthetic_plan(Jump(robot=name)), load_robot(name))
        for name in ("slider", "anymal")
    )
    pinned = Layer("pin", colours.PINNED[0], slider, None, pinned=True)
    plots = Plots(client)

    def labelled(label):
        return [m for m in tab.controls.values() if m["props"].get("label") == label]

    # Beside those of the session, which stay as they are.
    tab.wait(lambda: len(labelled("Joints")) == 2, "further plots")
    choice = {"uuid": labelled("Quantity")[1]["uuid"], "updates": {"value": TORQUES}}
    tab.send({"type": "GuiUpdateMessage"} | choice)
    tab.wait(lambda: plots._group.value == TORQUES, "the choice")
    plots.draw((*shown_layers(anymal, None), pinned), 1.3)

    def joints():
        return list(labelled("Joints")[1]["props"]["options"])

    # The choice is of the shown robot's joints.
    tab.wait(lambda: joints() == ["all", "HAA", "HFE", "KFE"], "ANYmal's joints")
    assert lines(charts(tab)["Joint speed / limit"]) == ["limit", "pin", "plan"]


def test_labels_are_none_of_the_contracts():
    """Tests find controls by parts of their labels."""
    for label in ("Quantity", "Joints"):
        for taken in ("Robot", "Model", "Format", "Inertia ellipsoids", "Seed", "Disturb"):
            assert taken.lower() not in label.lower()
    assert next(iter(GROUPS)) == "Overview"
