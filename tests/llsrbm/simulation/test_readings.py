"""A robot's own sensors: errors as stated, and what is left is MuJoCo's motion."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from llsrbm.mechanics import rotation_matrices, tilt, yaw
from llsrbm.simulation import readings as module
from llsrbm.simulation.readings import AttitudeFilter, Instruments
from llsrbm.simulation.world import TickResult
from tests.llsrbm.simulation.anymal_world import (
    ANYMAL,
    JOINTS,
    TICK,
    in_the_air,
    springs,
    world_of,
)

FORCE = np.array([[0.0, 0.0, 100.0], [30.0, 0.0, 40.0], [0.0, 0.0, 0.0], [0.0, 0.0, 7.0]])
LAST = replace(TickResult.unknown(4, JOINTS), torque=np.full(JOINTS, 10.0), contact_force=FORCE)
STANDING = ANYMAL.posture, np.zeros(ANYMAL.model.nv)
SEEDS = range(100)


@pytest.fixture
def perfect(monkeypatch):
    """Sensors that do not err, but for their range."""
    for name in vars(module):
        if name.endswith(("_NOISE", "_BIAS", "_WALK", "_SCALE")) or name == "JOINT_ZERO":
            monkeypatch.setattr(module, name, 0.0)
    monkeypatch.setattr(module, "ENCODER_STEP", 1e-9)


def read(seed=0, ticks=1, state=STANDING, last=LAST, **options):
    instruments = Instruments(ANYMAL, TICK, seed, **options)
    return [instruments.read(k * TICK, state, last) for k in range(ticks)]


def test_the_same_seed_reads_the_same():
    for one, other in zip(read(3, 5), read(3, 5), strict=True):
        for name, value in vars(one).items():
            np.testing.assert_array_equal(value, getattr(other, name))
    assert not np.array_equal(read(3)[0].gyro, read(4)[0].gyro)


def test_errors_at_rest_are_as_stated():
    first = [read(seed)[0] for seed in SEEDS]
    # Half a degree or so of tilt comes from the accelerometer's bias; the yaw is true at first.
    assert np.std([r.gyro for r in first]) == pytest.approx(
        np.hypot(module.GYRO_BIAS, module.GYRO_NOISE * 20), rel=0.15
    )
    tilts = tilt(np.array([r.quat for r in first]))
    expected = np.sqrt(2) * np.hypot(module.ACCELERATION_BIAS, module.ACCELERATION_NOISE * 20)
    assert np.sqrt(np.mean(tilts**2)) == pytest.approx(expected / 9.81, rel=0.15)
    assert np.abs(yaw(np.array([r.quat for r in first]))).max() < 1e-3
    q = np.array([r.q - ANYMAL.posture[7:] for r in first])
    assert q.std() == pytest.approx(module.JOINT_ZERO, rel=0.1)
    assert np.array([r.dq for r in first]).std() == pytest.approx(module.SPEED_NOISE, rel=0.1)
    torque = np.array([r.torque for r in first]) / 10
    noise = module.TORQUE_NOISE * ANYMAL.torque_limit.mean() / 10
    assert torque.mean() == pytest.approx(1, abs=0.01)
    assert torque.std() == pytest.approx(np.hypot(module.TORQUE_SCALE, noise), rel=0.15)


def test_noise_is_white_about_a_bias():
    readings = read(1, 2000)
    gyro = np.array([r.gyro for r in readings])
    noise = (gyro - gyro.mean(axis=0))[:, 0]
    assert noise.std() == pytest.approx(module.GYRO_NOISE * 20, rel=0.1)
    assert abs(np.corrcoef(noise[1:], noise[:-1])[0, 1]) < 0.1


def test_encoders_have_steps():
    q = read()[0].q / module.ENCODER_STEP
    np.testing.assert_allclose(q, np.round(q), atol=1e-9)


def test_only_feet_that_feel_read_forces():
    assert read()[0].foot_force is None
    felt = np.array([read(seed, foot_force=True)[0].foot_force for seed in SEEDS])
    assert not felt[:, 2].any()
    np.testing.assert_allclose(felt[:, :2].mean(axis=0), [100, 50], rtol=0.1)
    np.testing.assert_allclose(felt % module.FOOT_FORCE_STEP, 0, atol=1e-9)


@pytest.mark.usefixtures("perfect")
def test_integrated_readings_are_mujocos_motion():
    """Thrown, turning and hitting the ground: attitude and velocity come out again."""
    world, instruments = world_of(), Instruments(ANYMAL, TICK, 0)
    q, v = in_the_air(0.25)
    v[:6] = [0.5, 0.2, 0.0, 0.5, -1.0, 2.0]
    world.reset(q, v)
    instruments.read(0.0, world.state())
    R = pin.Quaternion(q[3:7]).toRotationMatrix()
    velocity, hit = R @ v[:3], False
    for k in range(160):
        last = world.advance(springs(world, q))
        hit |= bool(last.contact.any())
        reading = instruments.read((k + 1) * TICK, world.state(), last)
        middle = R @ pin.exp3(reading.gyro * TICK / 2)
        R = R @ pin.exp3(reading.gyro * TICK)
        velocity = velocity + TICK * (middle @ reading.acceleration - [0, 0, 9.81])
        true_q, true_v = world.state()
        R_true = pin.Quaternion(true_q[3:7]).toRotationMatrix()
        np.testing.assert_allclose(R, R_true, atol=1e-9)
        np.testing.assert_allclose(velocity, R_true @ true_v[:3], atol=1e-9)
        np.testing.assert_allclose(reading.q, true_q[7:], atol=1e-8)
        np.testing.assert_allclose(reading.dq, true_v[6:], atol=1e-12)
        np.testing.assert_array_equal(reading.torque, last.torque)
    assert hit


@pytest.mark.usefixtures("perfect")
def test_what_exceeds_the_range_is_lost_and_a_jump_of_the_state_is_none():
    instruments = Instruments(ANYMAL, TICK, 0)
    q, v = STANDING
    fast = v.copy()
    fast[[2, 5]] = 3.0, 50.0
    instruments.read(0.0, (q, v))
    assert instruments.read(TICK, (q, fast)).acceleration[2] == module.ACCELERATION_RANGE
    instruments.forget()
    reading = instruments.read(2 * TICK, (q, fast))
    np.testing.assert_allclose(reading.acceleration, [0, 0, 9.81], atol=1e-12)
    assert reading.gyro[2] == module.GYRO_RANGE


def test_the_units_tilt_is_bounded_and_its_yaw_is_not():
    for seed in range(1):
        readings = read(seed, 4000)
        tilts = tilt(np.array([r.quat for r in readings]))
        headings = yaw(np.array([r.quat for r in readings]))
        bias = np.mean([r.gyro[2] for r in readings])
        assert tilts.max() < np.radians(2.5)
        assert headings[-1] == pytest.approx(10 * bias, rel=0.1, abs=2e-3)


def test_gravity_corrects_a_tilt_only_while_it_is_alone():
    up, still = np.array([0.0, 0.0, 9.81]), np.zeros(3)
    for force, share in ((up, np.exp(-1)), (1.5 * up, 1.0)):
        unit = AttitudeFilter(TICK)
        leaning = rotation_matrices([1, 0.05, 0.0, 0])
        first = unit.update(still, leaning.T @ up, np.array([1.0, 0, 0, 0]))
        for _ in range(round(module.FILTER_TIME / TICK)):
            last = unit.update(still, force, np.array([1.0, 0, 0, 0]))
        np.testing.assert_allclose(tilt(last) / tilt(first), share, rtol=0.01)
