"""One tab, spoken to as a browser (or a hostile script) would."""

import math
import threading
import time
from dataclasses import replace

import numpy as np
import pytest
from viser._assignable_props_api import AssignablePropsBase

from app.tab.start.initial_plan import example
from llsrbm import models
from llsrbm.formats import FORMATS
from llsrbm.mechanics import turns_about_z
from llsrbm.robots import load_robot, names
from tests.app import planners
from tests.app.raw_tab import RawTab, choose, planned
from tests.app.waits import wait_until


def test_the_first_plan_comes_by_itself_and_the_page_plays_it(tab, session, script):
    assert session.state.plan.jump == example("anymal")
    assert tab.status().startswith("Feasible 1/1 checks Yaw inertia Izz, flight")
    assert "2.0e−07 N" in tab.text()
    tab.wait(lambda: script.calls("player.play") == [[]], "its motion")
    assert script.end == pytest.approx(session.state.plan.duration)
    assert {"/com", "/links/base", "/ellipsoid/srbm/wires", "/arrows/3"} < script.nodes()
    for time_shown in (0.0, 0.65, 1.3):
        position, wxyz, _ = script.at("/links/base", time_shown)
        plan = session.state.plan
        expected = [np.interp(time_shown, plan.time, axis) for axis in plan.base_position.T]
        assert position == pytest.approx(expected, abs=0.02)
        assert np.linalg.norm(wxyz) == pytest.approx(1, abs=1e-6)


def test_nothing_is_sent_while_the_page_plays(tab, script):
    script.say(kind="state", time=0.1, playing=True)
    time.sleep(0.5)
    before = tab.received.total()
    time.sleep(0.7)
    assert tab.received.total() == before


def test_every_label_of_the_contract_is_there(tab):
    for label in ("Twist [deg]", "Forward [m]", "Lateral [m]", "Landing height [m]"):
        assert tab.control(label)["type"] == "GuiSliderMessage"
    for label in ("Robot", "Model", "Format"):
        assert tab.control(label)["type"] == "GuiDropdownMessage"
    assert tab.control("Inertia ellipsoids")["type"] == "GuiCheckboxMessage"
    for label in ("Simulate", "Cancel", "Export", "Open"):
        assert tab.control(label)["type"] in ("GuiButtonMessage", "GuiUploadButtonMessage")
    titles = [load_robot(name).file.title for name in names()]
    assert tab.control("Robot")["props"]["options"] == titles
    assert tab.control("Model")["props"]["options"] == ["SRBM", "LL-SRBM", "LL-SRBM+"]
    assert len(models.MODELS) == 3
    offered = tab.control("Format")["props"]["options"]
    assert [title.partition(" ")[0] for title in offered] == list(FORMATS)


def test_the_last_of_many_slider_values_wins(tab, session):
    for twist in range(90, -91, -1):
        tab.set("Twist [deg]", twist)
    planned(tab, session, lambda jump: jump.twist == pytest.approx(-math.pi / 2), "the last value")
    tab.wait_for_status("Feasible")
    time.sleep(0.2)
    assert session.state.plan.jump.twist == pytest.approx(-math.pi / 2)


def test_the_model_reaches_the_planner(tab, session):
    tab.set("Model", "srbm")
    assert planned(tab, session, lambda jump: jump.model == "srbm", "a plan with srbm").solved


def test_a_robot_brings_its_ranges_and_its_example(tab, session):
    tab.set("Forward [m]", 0.6)
    tab.set("Model", "srbm")
    tab.set("Board under the feet [mm]", 60)
    planned(tab, session, lambda jump: jump.forward == 0.6, "a plan out of SLIDER's range")
    choose(tab, session, "slider")
    file = load_robot("slider").file
    forward = tab.control("Forward [m]")
    assert (forward["props"]["min"], forward["props"]["max"]) == file.task.forward
    assert session.state.plan.jump.model == "srbm"
    shown = {
        "twist": math.radians(tab.value("Twist [deg]")),
        "forward": forward["value"],
        "height": tab.value("Landing height [m]"),
    }
    for name, value in shown.items():
        assert value == pytest.approx(getattr(file.example, name), abs=0.01)
        assert getattr(session.state.plan.jump, name) == pytest.approx(value)
    choose(tab, session, "go2")
    assert tab.control("Board under the feet [mm]")["props"]["max"] == 40
    assert (
        tab.value("Board under the feet [mm]") == 0
    )  # what was asked of the other robot is not for this one
    assert not tab.notifications


@pytest.mark.parametrize(
    ("label", "value", "shown", "told"),
    [
        ("Twist [deg]", 999.0, 180.0, "expected −180 to 180, got 999; the nearest is taken"),
        ("Forward [m]", -5.0, -0.3, "expected −0.3 to 0.6, got −5; the nearest is taken"),
        ("Lateral [m]", math.nan, 0.0, "expected a number, got nan"),
        ("Landing height [m]", math.inf, 0.0, "expected a number, got inf"),
        ("Model", "<b>x</b>", "LL-SRBM+", "expected one of SRBM, LL-SRBM, LL-SRBM+"),
        ("Robot", "nosuch", "ANYmal B", "expected one of Unitree A1"),
        ("Board under the feet [mm]", 999, 70, "expected 0 to 70, got 999; the nearest is taken"),
        ("Seed", -3, 0, "expected 0 to 9999, got −3; the nearest is taken"),
    ],
)
def test_a_value_no_control_offers_is_corrected_and_said(tab, session, label, value, shown, told):
    tab.set("Disturb", True)  # a seed counts only then
    tab.set(label, value)
    tab.wait(lambda: tab.notifications, "a notification")
    title, body = tab.notifications[0]
    assert title == "Corrected"
    assert body.startswith(f"{label}: {told}")
    tab.wait(lambda: tab.value(label) == shown, "the corrected value")
    tab.wait_for_status("Feasible")


def test_a_crash_is_shown_and_survived(tab, session, capfd):
    tab.set("Twist [deg]", math.degrees(planners.CRASH))
    assert "ended unexpectedly (exit status 9) and was restarted" in tab.wait_for_status("Failed")
    tab.set("Twist [deg]", 20.0)
    tab.wait_for_status("Feasible")


def drag(tab, session, wxyz, position, name="/goal"):
    """As viser's page does when a handle is dragged and let go."""
    names = {"name": name, "owner": str(session._client.client_id)}
    pose = {"wxyz": wxyz, "position": position}
    tab.send({"type": "TransformControlsDragStartMessage", **names})
    tab.send({"type": "TransformControlsUpdateMessage", **pose, **names})
    tab.send({"type": "TransformControlsDragEndMessage", **names})


def test_the_landing_handle_moves_the_sliders_and_the_plan(tab, session):
    yaw = math.radians(30)
    drag(tab, session, (math.cos(yaw / 2), 0, 0, math.sin(yaw / 2)), (0.352, -0.118, 0.4))
    jump = planned(tab, session, lambda jump: jump.forward == 0.35, "the plan").jump
    assert (jump.twist, jump.lateral, jump.height) == pytest.approx((yaw, -0.12, 0))
    shown = {"Twist [deg]": 30, "Forward [m]": 0.35, "Lateral [m]": -0.12}
    tab.wait(lambda: {label: tab.value(label) for label in shown} == shown, "the sliders")
    # Let go, it stands on the sliders' steps.
    tab.wait(
        lambda: list(tab.nodes["/goal"].get("position", ())) == pytest.approx([0.35, -0.12, 0]),
        "the handle",
    )


def test_a_foots_handle_moves_where_it_alone_lands(tab, session):
    foot, jump = "/footholds/1", session.state.design.jump
    tab.wait(lambda: "position" in tab.nodes.get(foot, {}), "the handle")
    at = np.array(tab.nodes[foot]["position"])
    ahead = turns_about_z(jump.twist) @ [0.05, 0.02, 0.0]
    drag(tab, session, tab.nodes[foot]["wxyz"], tuple((at + ahead).tolist()), foot)
    moved = planned(tab, session, lambda jump: bool(jump.stones), "the plan").jump
    assert moved == replace(jump, stones={"RF": (0.05, 0.02)})
    tab.press("Undo")
    planned(tab, session, lambda now: now == jump, "the plan before")
    tab.wait(lambda: list(tab.nodes[foot]["position"]) == pytest.approx(at), "the handle")


def test_tabs_do_not_see_each_other(designer, tab, session):
    with RawTab(designer.port) as other:
        other.wait_for_status("Feasible")
        other.set("Forward [m]", 0.5)
        other.wait(lambda: designer.sessions[-1].state.plan.jump.forward == 0.5, "the other's plan")
        assert session.state.plan.jump.forward == 0.0
        assert tab.value("Forward [m]") == 0.0


def test_a_closed_tab_leaves_nothing_behind(designer):
    before = len(designer.sessions)
    with RawTab(designer.port) as passing:
        passing.wait_for_status("Feasible")
        thread = designer.sessions[-1]._thread
    thread.join(5)
    assert not thread.is_alive()
    wait_until(lambda: len(designer.sessions) <= before, "its end")


def test_the_robots_meshes_fit_into_a_megabyte(designer):
    with RawTab(designer.port) as fresh:

        def links():
            return [name for name in list(fresh.nodes) if name.startswith("/links/")]

        fresh.wait(lambda: len(links()) >= 13, "all links of the robot")
        assert len(links()) == 13
        assert fresh.received_bytes < 1_000_000


def test_while_a_plan_is_awaited_pins_and_charts_are_drawn(tab, session):
    tab.set("Twist [deg]", round(math.degrees(planners.STUBBORN)))
    tab.wait(lambda: session.state.planning, "a plan that takes its time")
    tab.press("Pin")
    tab.wait(lambda: tab.control("Pinned")["props"]["visible"], "the pin")
    assert "Status" in tab.text()  # the table that compares it
    titles = lambda: [m["props"].get("title") for m in list(tab.controls.values())]  # noqa: E731
    before = titles()
    tab.set("Preset", "Base rates")
    tab.wait(lambda: titles() != before, "its charts")
    assert session.state.planning
    tab.press("Cancel")
    tab.wait_for_status("Cancelled")


def test_controls_are_written_by_their_sessions_thread_alone(designer, monkeypatch):
    writers, write = set(), AssignablePropsBase.__setattr__

    def noted(handle, name, value):
        if type(handle).__name__.startswith("Gui") and name != "_impl":
            writers.add((threading.current_thread().name.split("-")[0], type(handle).__name__))
        write(handle, name, value)

    with RawTab(designer.port) as tab:
        tab.wait_for_status("Feasible")
        monkeypatch.setattr(AssignablePropsBase, "__setattr__", noted)
        tab.set("Format", "csv")
        tab.wait(lambda: tab.control("Frames per second")["props"]["visible"], "its options")
        for label, value in (("csv", True), ("Push", True), ("Disturb", True), ("Dark mode", True)):
            tab.set(label, value)
        tab.set("Preset", "Base rates")
        tab.press("Pin")
        tab.wait(lambda: tab.control("Pinned")["props"]["visible"], "the pin")
        tab.press("Simulate")
        tab.wait_for_status("Landed")
    assert {thread for thread, _ in writers} == {"session"}, writers
