"""Power, currents and heat, against integrals and energies that others make of the same motion."""

import json
from dataclasses import replace

import mujoco
import numpy as np
import pytest

import llsrbm
from llsrbm import cli
from llsrbm.analysis.summaries import plan_summary, power_forecast, rollout_summary
from llsrbm.analysis.wording import power_cut, power_rows
from llsrbm.certificate import Certificate
from llsrbm.certificate.certificate import certify_stretches
from llsrbm.certificate.power import CUT, DrivePower
from llsrbm.certificate.sampled_motion import SampledMotion
from llsrbm.motion.surroundings import Surroundings
from llsrbm.robots import load_robot
from llsrbm.robots.drives.variants import with_drives
from llsrbm.simulation.scene import build_scene
from tests.llsrbm.formats.jumps import planned, simulated
from tests.llsrbm.robots.edited import with_table

CONSTANT, RESISTANCE, VOLTAGE = np.tile([0.6, 0.6, 1.2], 4), 0.2, 25.0
ELECTRICAL = f"""
torque_constant = [0.6, 0.6, 1.2]
resistance = {RESISTANCE}
voltage = {VOLTAGE}
"""


def robot_file(folder, limits=""):
    """Go2 with these electrical numbers, and limits of them."""
    path = folder / "mine.toml"
    path.write_text(with_table("go2", "drives.electrical", ELECTRICAL + limits))
    return path


def of(rollout, path):
    """The rollout as if it were of the robot in that file."""
    jump = replace(rollout.jump, robot=str(path))
    return replace(rollout, jump=jump, plan=replace(rollout.plan, jump=jump))


def test_the_work_of_the_drives_is_the_gain_in_energy_and_what_friction_takes():
    """In flight, with MuJoCo's energies and its joints' friction and damping."""
    rollout = simulated("go2")
    scene = build_scene(load_robot("go2"), Surroundings(0.0, ()), rollout.disturbance, 1e-3)
    model, data = scene.model, mujoco.MjData(scene.model)
    model.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_ENERGY
    flight = np.flatnonzero(~rollout.contact.any(axis=1))[5:-5]
    assert (np.diff(flight) == 1).all()
    q = [model.joint(name).qposadr[0] for name in rollout.joint_names]
    v = [model.joint(name).dofadr[0] for name in rollout.joint_names]
    energy = []
    for tick in flight[[0, -1]]:
        data.qpos[:7], data.qpos[q] = rollout.qpos[tick, :7], rollout.qpos[tick, 7:]
        data.qvel[:6], data.qvel[v] = rollout.qvel[tick, :6], rollout.qvel[tick, 6:]
        mujoco.mj_forward(model, data)
        energy.append(data.energy.sum())
    flown = replace(
        rollout, time=rollout.time[flight], qvel=rollout.qvel[flight], torque=rollout.torque[flight]
    )
    found = power_forecast(flown)
    speed = np.abs(flown.qvel[:, 6:])
    damping = model.dof_damping.reshape(model.nv, -1)[v, 0]
    taken = np.trapezoid((speed * (model.dof_frictionloss[v] + damping * speed)).sum(1), flown.time)
    work = found.energy_j - found.energy_back_j
    gross = found.energy_j + found.energy_back_j
    assert gross > 2.0
    assert work == pytest.approx(energy[1] - energy[0] + taken, abs=0.02 * gross)


def near(power, time, instant):
    """The most within 6 ms of an instant: of two peaks that are as high either may be stated."""
    return power[np.abs(time - instant) <= 0.006].max()


def test_a_rollouts_figures_are_integrals_of_its_file(tmp_path):
    path = tmp_path / "rollout.npz"
    of(simulated("go2"), robot_file(tmp_path)).save(path)
    with np.load(path) as file:
        time, torque, speed = file["time"], file["torque"], file["qvel"][:, 6:]
        names = list(file["joint_names"])
    power = torque * speed
    given, back = np.clip(power, 0, None).sum(axis=1), np.clip(-power, 0, None).sum(axis=1)
    # A torque is held for a tick, in which a foot that strikes changes the speeds.
    held = torque[:-1] * speed[1:]
    most_given = np.maximum(given[:-1], np.clip(held, 0, None).sum(axis=1))
    most_back = np.maximum(back[:-1], np.clip(-held, 0, None).sum(axis=1))
    heating = RESISTANCE * (torque / CONSTANT) ** 2
    battery = (power + heating).sum(axis=1)
    found = llsrbm.load(path)
    for stated in (rollout_summary(found)["power"], llsrbm.certify(found).power.as_dict()):
        assert stated["peak_w"] == pytest.approx(given.max(), rel=0.06)
        assert near(most_given, time[:-1], stated["peak_s"]) == pytest.approx(given.max(), rel=0.06)
        assert stated["back_w"] == pytest.approx(back.max(), rel=0.06)
        assert near(most_back, time[:-1], stated["back_s"]) == pytest.approx(back.max(), rel=0.06)
        assert stated["energy_j"] == pytest.approx(np.trapezoid(given, time), rel=0.03)
        assert stated["energy_back_j"] == pytest.approx(np.trapezoid(back, time), rel=0.03)
        assert stated["electrical_peak_w"] == pytest.approx(battery.max(), rel=0.06)
        assert stated["battery_current_a"] == stated["electrical_peak_w"] / VOLTAGE
        heat = [stated["heat_j"][name] for name in names]
        np.testing.assert_allclose(heat, np.trapezoid(heating, time, axis=0), rtol=0.02)


def test_a_plans_figures_are_sums_over_its_intervals():
    plan = planned("anymal")  # whose file has no electrical numbers
    middles = (plan.joint_velocity[1:] + plan.joint_velocity[:-1]) / 2
    work = plan.joint_torque[:-1] * middles * np.diff(plan.time)[:, None]
    stated = plan_summary(plan)["power"]
    assert stated["energy_j"] - stated["energy_back_j"] == pytest.approx(work.sum())
    assert stated["energy_j"] == pytest.approx(np.clip(work, 0, None).sum(), rel=0.02)
    assert stated["heat_j"] is stated["electrical_peak_w"] is stated["battery_current_a"] is None
    unknown = plan_summary(replace(plan, joint_torque=None))["power"]
    assert set(unknown) == set(stated)
    assert set(unknown.values()) == {None}


@pytest.fixture
def sampled():
    """At rest for a second but for one calf, which turns at 2 rad/s against 12 Nm."""
    motion = SampledMotion.of(simulated("go2"))
    count = len(motion.time)
    torque, v = np.zeros((count, 12)), np.zeros_like(motion.v)
    torque[:, 2], v[:, 8] = -12.0, 2.0
    time = np.linspace(0.0, 1.0, count)
    return replace(motion, time=time, v=v, recorded_torque=torque)


def found(motion, name):
    return certify_stretches([motion])[name]


@pytest.mark.parametrize(("share", "holds"), [(1.009, True), (1.011, False)])
def test_limits(sampled, tmp_path, share, holds):
    """10 A through 0.2 ohm: 20 W of heat; 24 W of work come back, so the battery gives -4 W."""
    motion = replace(
        sampled, robot=with_drives(load_robot(sampled.robot.name), regeneration=24.0 / share)
    )
    name = sampled.robot.joint_names[2]
    broken = found(motion, "regeneration")
    assert (broken.holds, broken.where, broken.limit) == (holds, name, 24.0 / share)
    assert broken.worst == pytest.approx(share)
    limits = f"heat = {20.0 / share}\ncharge_current = {4.0 / VOLTAGE / share}"
    motion = replace(sampled, robot=load_robot(str(robot_file(tmp_path, limits))))
    cuts = [found(motion, check) for check in ("battery_current", "winding_heat")]
    for cut in cuts:
        assert cut.worst == pytest.approx(share)
        assert (cut.holds, cut.why) == (holds, "" if holds else CUT)
    assert cuts[0].where == "battery takes back"
    assert (cuts[1].where, cuts[1].beyond_s is None) == (name, holds)
    if not holds:  # the heat passes 1.01 of its limit shortly before the end
        assert cuts[1].time_s == pytest.approx(1.01 / share, abs=2 / len(motion.time))
    words = power_cut(Certificate(tuple(cuts)))
    assert words == ("" if holds else "The robot will cut its power at 0.00 s: battery current.")


def test_without_numbers_nothing_can_be_violated(sampled):
    for name in ("regeneration", "battery_current", "winding_heat"):
        nothing = found(sampled, name)
        assert (nothing.worst, nothing.holds) == (None, True)
        assert "the robot's file has no" in nothing.why


def test_words(sampled, tmp_path):
    robot = load_robot(str(robot_file(tmp_path)))
    rows = dict(power_rows(DrivePower.of(replace(sampled, robot=robot)).forecast()))
    assert rows == {
        "Peak power": "0 W at 0.00 s, takes back 24 W at 0.00 s; 0 J given, 24 J back",
        "Battery": "gives up to −4 W, 0 A; 20 J of heat in the winding of FL_calf_joint",
    }


def test_check_says_when_the_robot_will_cut_its_power(tmp_path, capfd):
    path = tmp_path / "rollout.npz"
    of(simulated("go2"), robot_file(tmp_path, "current = 5.0")).save(path)
    assert cli.main(["check", str(path)]) == 1
    out = capfd.readouterr().out
    assert "The robot will cut its power at " in out
    assert "Battery: gives " in out
    assert cli.main(["check", str(path), "--json"]) == 1
    result = json.loads(capfd.readouterr().out)
    assert result["power"]["battery_current_a"] > 5.0
    assert set(result["drives"]) == {"armature", "friction", "damping", "delay"}
    # The finding goes with the file.
    llsrbm.certified(llsrbm.load(path)).save(path)
    assert llsrbm.load(path).certificate["battery_current"]["why"] == CUT
