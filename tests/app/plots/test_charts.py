from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial.transform import Rotation

from app.motion import colours
from app.motion.baked import bake_plan
from app.plots.charts import Layer, charts, shown_layers
from app.plots.choice import (
    LANDING,
    PRESETS,
    TORQUES,
)
from app.plots.figure import figure
from app.plots.signals import joint_kinds
from llsrbm.motion.rollout import Disturbance
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot
from tests.app.plots.lines import TWIST, at
from tests.app.synthetic_plan import FLY, GRAVITY, STAND, TORQUE_SHARE, synthetic_plan
from tests.llsrbm.synthetic_rollout import THRESHOLD, YAW_SHORTFALL, synthetic_rollout

MIDDLE = STAND + FLY / 2


def chosen(name, joints="all joints"):
    """A preset."""
    return PRESETS[name].with_joints(joints)


def drawn(group, planned, rollout=None, joints="all joints"):
    """Lines by chart and layer."""
    found = charts(chosen(group, joints), shown_layers(planned, rollout))
    return {chart.heading: {line.title: line for line in chart.lines} for chart in found}


def simulated(group, planned, rollout, joints="all joints"):
    """(T, n) of the simulation's lines, in the charts' order."""
    lines = drawn(group, planned, rollout, joints).values()
    return np.stack([chart["simulation"].values for chart in lines], axis=1)


# ---- the plan


def test_planned_curves_in_mid_flight(planned, robot):
    plan = {title: chart["plan"] for title, chart in drawn("Overview", planned).items()}
    height = robot.com[2] + GRAVITY * FLY**2 / 8
    assert at(plan["Base angle, yaw [°]"], MIDDLE) == pytest.approx(np.degrees(TWIST / 2), abs=0.5)
    assert at(plan["Angular velocity, z [rad/s]"], MIDDLE) == pytest.approx(TWIST / FLY, rel=1e-3)
    inertia = planned.plan.inertia[:, 2, 2]
    assert inertia.min() <= at(plan["Inertia, zz [kg m²]"], MIDDLE) <= inertia.max()
    assert at(plan["Vertical force, all feet [N]"], MIDDLE) == 0
    risen = drawn("CoM position", planned)["CoM position, z [m]"]["plan"]
    assert at(risen, MIDDLE) == pytest.approx(height, abs=1e-3)
    norm = drawn(LANDING, planned)["Spatial velocity ‖v_G‖"]["plan"]
    # At the apex nothing moves but the turning body.
    assert at(norm, MIDDLE) == pytest.approx(TWIST / FLY, rel=1e-3)


def test_planned_torques_lie_under_the_simulated_ones(planned, rollout):
    alone, both = drawn(TORQUES, planned), drawn(TORQUES, planned, rollout)
    shares = [
        "Largest torque / limit",
        "Largest torque / limit at its speed",
        "Largest joint speed / limit",
    ]
    assert list(alone) == list(both) == [*shares, "Power of the drives [W]"]
    for title in shares:
        assert list(alone[title]) == ["limit", "plan"]
        assert list(both[title]) == ["limit", "plan", "simulation"]
    for title in shares[:2]:
        assert at(alone[title]["plan"], STAND / 2) == pytest.approx(abs(TORQUE_SHARE))
        assert at(alone[title]["plan"], MIDDLE) == 0
    # Stiff legs do next to no work: between knots the body turns smoothly.
    assert np.abs(alone["Power of the drives [W]"]["plan"].values).max() < 2.0
    assert list(drawn(LANDING, planned)) == ["Spatial velocity ‖v_G‖"]


def test_power_is_torque_times_speed(planned, rollout):
    power = drawn(TORQUES, planned, rollout)["Power of the drives [W]"]["simulation"].values
    expected = np.einsum("tj,tj->t", rollout.torque, rollout.qvel[:, 6:])
    assert power == pytest.approx(expected)


# ---- the simulation, against the recorded arrays


def test_every_group_has_both_layers(planned, rollout):
    for group, choice in PRESETS.items():
        found = charts(choice, shown_layers(planned, rollout))
        assert 2 <= len(found) <= 5, group
        for chart in found:
            assert "simulation" in {line.title for line in chart.lines}, chart.title
            for line in chart.lines:
                assert line.time.shape == line.values.shape
                assert np.isfinite(line.values).all(), chart.title


def test_vectors_are_the_recorded_ones(planned, rollout):
    for group, values in (
        ("CoM position", rollout.com),
        ("Linear momentum", rollout.linear_momentum),
        ("Angular momentum", rollout.angular_momentum),
    ):
        assert np.array_equal(simulated(group, planned, rollout), values)


def test_velocities_are_the_slopes_of_positions(planned, rollout):
    slope = np.gradient(rollout.com, rollout.time, axis=0)
    assert simulated("CoM velocity", planned, rollout) == pytest.approx(slope, abs=0.06)
    yaw = simulated("Base angles", planned, rollout)[:, 0]
    rate = simulated("Base rates", planned, rollout)[:, 2]
    assert rate == pytest.approx(np.gradient(np.radians(yaw), rollout.time), abs=0.05)


def test_the_velocity_is_that_of_the_simulated_mass(planned, rollout, robot):
    model = robot.model.copy()
    trunk = model.inertias[1]
    model.inertias[1] = pin.Inertia(1.08 * trunk.mass, trunk.lever, 1.08 * trunk.inertia)
    heavier = pin.computeTotalMass(model) / robot.mass
    assert heavier > 1.02
    heavy = replace(
        rollout,
        linear_momentum=heavier * rollout.linear_momentum,
        disturbance=Disturbance(trunk_mass_factor=1.08),
    )
    velocity = simulated("CoM velocity", planned, rollout)
    assert simulated("CoM velocity", planned, heavy) == pytest.approx(velocity, abs=1e-9)


def test_angles_are_eulers_of_any_attitude(planned, rollout):
    rng = np.random.default_rng(3)
    yaw, pitch, roll = np.cumsum(rng.normal(size=(3, len(rollout.time))), axis=1) * 0.02
    pitch = np.clip(pitch, -1.5, 1.5)
    attitude = Rotation.from_euler("ZYX", np.stack([yaw, pitch, roll], axis=1))
    tumbling = replace(rollout, base_quat=attitude.as_quat(scalar_first=True))
    expected = np.degrees(np.stack([yaw, pitch, roll], axis=1))
    assert simulated("Base angles", planned, tumbling) == pytest.approx(expected, abs=1e-6)


def test_rates_are_in_the_world(planned, rollout):
    """A tilted base turns about another axis than its own."""
    tilt = Rotation.from_euler("x", 0.5)
    base = Rotation.from_quat(rollout.base_quat, scalar_first=True)
    qvel = rollout.qvel.copy()
    qvel[:, 3:6] = tilt.inv().apply(qvel[:, 3:6])
    leaning = replace(rollout, base_quat=(base * tilt).as_quat(scalar_first=True), qvel=qvel)
    upright = simulated("Base rates", planned, rollout)
    assert simulated("Base rates", planned, leaning) == pytest.approx(upright, abs=1e-9)


def test_principal_inertias_are_the_eigenvalues(planned, rollout):
    stretch = 1 + 0.3 * np.sin(rollout.time)
    inertia = rollout.inertia * stretch[:, None, None]
    found = drawn("Principal inertias", planned, replace(rollout, inertia=inertia)).values()
    lines = [chart["simulation"] for chart in found]
    moments = np.stack([line.values for line in lines], axis=1)
    kept = np.searchsorted(rollout.time, lines[0].time)
    assert 200 < len(kept) <= 400
    assert np.sort(moments, axis=1) == pytest.approx(np.linalg.eigvalsh(inertia[kept]), rel=1e-9)
    # ANYmal is longer than it is wide: rolling is easiest.
    assert (moments[:, 0] < moments[:, 1:].min(axis=1)).all()


def test_forces_of_the_feet_add_up(planned, rollout, robot):
    forces = simulated("Contact forces", planned, rollout)
    assert forces.shape[1] == 1 + len(robot.legs)
    assert forces[:, 0] == pytest.approx(forces[:, 1:].sum(axis=1))
    assert np.array_equal(forces[:, 1:], rollout.contact_force[..., 2])


def test_torques_are_shares_of_the_robots_limits(planned, rollout, robot):
    found = drawn(TORQUES, planned, rollout, "KFE")
    assert list(found) == [
        "Largest torque / limit, KFE",
        "Largest torque / limit at its speed, KFE",
        "Largest joint speed / limit, KFE",
        "Power of the drives, KFE [W]",
    ]
    knees = [k for k, name in enumerate(rollout.joint_names) if name.endswith("KFE")]
    assert len(knees) == 4
    limits = robot.file.limits
    torque = np.abs(rollout.torque[:, knees])
    speed = np.abs(rollout.qvel[:, 6:][:, knees])
    for title, expected in zip(
        list(found)[:3],
        (
            torque / limits.torque,
            torque / rollout.torque_limit[:, knees],
            speed / limits.joint_speed,
        ),
        strict=True,
    ):
        assert found[title]["simulation"].values == pytest.approx(expected.max(axis=1))
        assert found[title]["limit"].values.tolist() == [1.0, 1.0]
    of_all = drawn(TORQUES, planned, rollout)["Largest torque / limit"]["simulation"].values
    assert of_all.max() == pytest.approx(np.abs(rollout.torque).max() / limits.torque)


def test_a_drive_that_can_give_nothing(planned, rollout):
    """Is at no limit if it gives nothing, and beyond all of them where a plan asks for torque."""
    title = "Largest torque / limit at its speed"
    spent = replace(
        rollout, torque=np.zeros_like(rollout.torque), torque_limit=0 * rollout.torque_limit
    )
    assert (drawn(TORQUES, planned, spent)[title]["simulation"].values == 0).all()
    motion = replace(planned.motion, joint_torque_limit=0 * planned.motion.joint_torque_limit)
    without = replace(planned, motion=motion)
    shares = drawn(TORQUES, without)[title]["plan"]
    assert at(shares, STAND / 2) == np.inf
    assert at(shares, MIDDLE) == 0
    chart = figure(PRESETS[TORQUES], shown_layers(without, None), 1.3).charts[1]
    assert np.nanmax(chart.lines[1].values) == 2.0, "what is drawn ends at twice the limit"


@pytest.mark.parametrize(
    ("name", "kinds"),
    [
        ("anymal", ("all joints", "HAA", "HFE", "KFE")),
        ("go2", ("all joints", "hip", "thigh", "calf")),
        ("slider", ("all joints", "roll", "pitch", "slide", "yaw", "ankle_pitch", "ankle_roll")),
    ],
)
def test_joints_are_chosen_by_their_place_in_the_leg(name, kinds):
    assert joint_kinds(load_robot(name)) == kinds


def test_yaw_is_compared_with_the_plans(planned, rollout):
    off = drawn(LANDING, planned, rollout)["Yaw − planned yaw [°]"]["simulation"]
    instant = rollout.outcome.touchdown_true_s
    plan = np.interp(
        instant, planned.plan.time, TWIST * np.clip((planned.plan.time - STAND) / FLY, 0, 1)
    )
    ours = np.degrees(
        np.interp(
            instant,
            rollout.time,
            np.unwrap(
                Rotation.from_quat(rollout.base_quat, scalar_first=True).as_euler("ZYX")[:, 0]
            ),
        )
        - plan
    )
    # Between knots the plan's rate changes smoothly, the straight line's at once.
    assert at(off, instant) == pytest.approx(ours, abs=1.0)
    assert abs(ours) > np.degrees(YAW_SHORTFALL) / 2
    assert off.values[-1] == pytest.approx(0.0, abs=0.1)


def test_detection_is_in_units_of_its_threshold(planned, rollout):
    found = drawn(LANDING, planned, rollout)["Detection signal / |threshold|"]
    assert found["threshold"].values.tolist() == [1.0, 1.0]
    highest = (rollout.detection_signal / THRESHOLD).max()
    assert found["simulation"].values.max() == pytest.approx(highest)
    hard = replace(rollout, detection_signal=rollout.detection_signal * 1e4)
    chart = figure(PRESETS[LANDING], shown_layers(planned, hard), 2.3).charts[1]
    assert np.nanmax(chart.lines[-1].values) == 3.0
    # The norm's signal is compared with a negative number.
    negative = replace(rollout, detection_threshold=-THRESHOLD)
    found = drawn(LANDING, planned, negative)["Detection signal / |threshold|"]
    assert found["threshold"].values.tolist() == [-1.0, -1.0]


# ---- several designs


def test_pinned_designs_may_be_of_another_robot(planned, rollout):
    slider = load_robot("slider")
    other = bake_plan(synthetic_plan(Jump(robot="slider", twist=0.5)), slider)
    pin_layer = Layer("pin", colours.PINNED[0], other, synthetic_rollout(other.plan), pinned=True)
    layers = (pin_layer, *shown_layers(planned, rollout))
    forces = {
        chart.heading: len(chart.lines) for chart in charts(PRESETS["Contact forces"], layers)
    }
    assert forces["Vertical force, all feet [N]"] == 3
    assert forces["Foot force, LF z [N]"] == 2
    assert forces["Foot force, left z [N]"] == 1
    for choice in PRESETS.values():
        assert charts(choice, layers)
    lines = charts(chosen(TORQUES, "KFE"), layers)[0].lines
    assert [line.title for line in lines] == ["limit", "plan", "simulation"]
