"""Any quantity can be plotted, by components, alone or with others in a chart."""

from dataclasses import replace

import numpy as np
import pytest

from app.motion import colours
from app.motion.baked import bake_plan
from app.plots.charts import charts, components_offered, everything, shown_layers
from app.plots.choice import (
    OVERVIEW,
    PRESETS,
    ChartChoice,
    PlotChoice,
)
from app.plots.figure import figure
from app.plots.signals import SIGNALS
from app.plots.time_series import TimeSeries
from llsrbm.files.quantity import TIME, derived, quantities
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot
from llsrbm.robots.drives.table import Electrical
from tests.app.plots.lines import at
from tests.app.synthetic_plan import synthetic_plan


def one(key, *components, each=False):
    return PlotChoice((ChartChoice(key, components, each),))


def test_what_plans_and_rollouts_declare_can_be_plotted(planned, rollout):
    declared = {
        name
        for of in (Plan, Rollout)
        for name, quantity in (quantities(of) | derived(of)).items()
        if quantity.listed and quantity.axes[:1] == (TIME,)
    }
    renamed = {"torque": "joint_torque", "torque_limit": "joint_torque_limit"}
    assert {renamed.get(name, name) for name in declared - {"time"}} <= set(SIGNALS)
    layers = shown_layers(planned, rollout)
    for key in set(SIGNALS) - {"electrical_power"}:  # no shipped file has numbers for it
        assert charts(one(key), layers), key
        assert len(charts(one(key), layers)) == 1


def test_declared_quantities_are_the_recorded_ones(planned, rollout):
    layers = shown_layers(planned, rollout)
    for key, recorded in (
        ("base_velocity", rollout.base_velocity),
        ("foot_position", rollout.foot_position),
        ("reference_com", rollout.reference_com),
        ("mode", rollout.mode),
        ("inertia", rollout.inertia[:, [0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]),
    ):
        (chart,) = charts(one(key), layers)
        lines = [line.values for line in chart.lines if line.title == "simulation"]
        assert np.array_equal(np.stack(lines, axis=1), recorded.reshape(len(rollout.time), -1)), key
    # Those of the plan alone, at its knots.
    (chart,) = charts(one("leg_com", "LF"), layers)
    assert [line.name for line in chart.lines] == ["plan LF x", "plan LF y", "plan LF z"]
    time, leg = planned.plan.time, planned.plan.leg_com[:, 0, 2]
    middle = time[len(time) // 2]
    assert at(chart.lines[2], middle) == pytest.approx(np.interp(middle, time, leg), abs=1e-3)


def test_the_battery_gives_work_and_heat(rollout):
    series = TimeSeries.of_rollout(rollout, None)
    assert SIGNALS["electrical_power"].of(series) is None
    motor = Electrical(torque_constant=2.0, resistance=0.1)
    file = series.robot.file
    file = file.model_copy(update={"drives": file.drives.model_copy(update={"electrical": motor})})
    motion = replace(series.motion, robot=replace(series.robot, file=file))
    found = SIGNALS["electrical_power"].of(replace(series, motion=motion)).values[:, 0]
    torque, speed = motion.joint_torque, motion.joint_velocity
    np.testing.assert_allclose(found, (torque * speed + 0.1 * (torque / 2.0) ** 2).sum(axis=1))


def test_joints_by_name(planned, rollout):
    layers = shown_layers(planned, rollout)
    name = "LF_KFE"
    (chart,) = charts(one("joint_torque", name), layers)
    assert chart.heading == "Joint torque, LF_KFE [Nm]"
    assert [line.name for line in chart.lines] == ["plan", "simulation"]
    column = rollout.joint_names.index(name)
    assert np.array_equal(chart.lines[1].values, rollout.torque[:, column])
    (leg,) = charts(one("joint_torque", "LF"), layers)
    assert leg.title == "Joint torque, LF"
    assert len(leg.lines) == 6
    # Colours are the components', line styles the motions'.
    looks = {(line.component, line.colour) for line in leg.lines}
    assert len({rgb for _, rgb in looks}) == len(looks) == 3
    assert {(line.title, line.dash) for line in leg.lines} == {
        (line.title, line.dash) for line in chart.lines
    }
    assert len({line.dash for line in chart.lines}) == 2
    assert chart.lines[-1].dash == ()  # what is drawn solid
    each = charts(one("joint_torque", "LF", each=True), layers)
    assert [chart.title for chart in each] == [
        f"Joint torque, LF_{k}" for k in ("HAA", "HFE", "KFE")
    ]


def test_signals_that_share_a_chart(planned, rollout):
    layers = shown_layers(planned, rollout)
    z, force = ChartChoice("com", ("z",)), ChartChoice("vertical_force")
    share = ChartChoice("largest_torque_share", ("all joints",))
    (chart,) = charts(PlotChoice((replace(z, more=(force, share)),)), layers)
    assert chart.title == "CoM position, z · Vertical force, all feet · Largest torque / limit"
    assert chart.unit == "m or N"
    alone = charts(PlotChoice((z, force, share)), layers)
    expected = [line.values for each in alone for line in each.lines]
    assert all(map(np.array_equal, (line.values for line in chart.lines), expected))
    colour_of = {line.component: line.colour for line in chart.lines}
    assert colour_of.keys() == {"", *chart.title.split(" · ")}  # "": the limit
    assert len(set(colour_of.values())) == 4


def test_a_component_has_one_colour_in_all_charts(planned):
    layers = shown_layers(planned, None)
    whole, part = charts(PlotChoice((ChartChoice("com"), ChartChoice("com", ("y", "z")))), layers)
    by_name = {line.component: line.colour for line in whole.lines}
    assert {line.component: line.colour for line in part.lines}.items() <= by_name.items()
    assert not set(by_name.values()) & {colours.PLANNED, colours.SIMULATED, *colours.PINNED}
    # Alone in its chart, a line has its motion's colour.
    (alone,) = charts(one("com", "z"), layers)
    assert [line.colour for line in alone.lines] == [colours.PLANNED]
    # Twelve joints are told apart.
    (joints,) = charts(one("joint_torque"), layers)
    assert len({line.colour for line in joints.lines}) == len(joints.lines) == 12


def test_components_that_can_be_chosen(planned, rollout):
    layers = shown_layers(planned, rollout)
    assert components_offered("com", layers) == ("all", "a chart each", "x", "y", "z")
    assert components_offered("mode", layers) == ("all",)
    feet = components_offered("foot_force", layers)
    assert feet[:6] == ("all", "a chart each", "LF", "x", "y", "z")
    assert "RH z" in feet
    joints = components_offered("joint_velocity", layers)
    assert {"HAA", "LF", "RH_KFE"} <= set(joints)
    assert components_offered("com", ()) == ("all",)


def test_sliding_joints_have_their_own_unit():
    robot = load_robot("slider")
    layers = shown_layers(bake_plan(synthetic_plan(Jump(robot="slider")), robot), None)
    (chart,) = charts(one("joint_position", "left"), layers)
    units = {line.component: line.unit for line in chart.lines}
    assert units["left_slide_joint" if "left_slide_joint" in units else "left_slide"] == "m"
    assert chart.unit == "rad or m"


def test_what_there_is_not_is_left_out(planned):
    layers = shown_layers(planned, None)
    assert charts(one("no such signal"), layers) == ()
    assert charts(one("com", "no such axis"), layers) == ()
    assert charts(one("mode"), layers) == ()  # of simulations alone
    assert len(figure(everything(), layers, 1.3).charts) > 50
    assert charts(PRESETS[OVERVIEW], ()) == ()
