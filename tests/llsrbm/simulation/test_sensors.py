"""Measurements: white noise as drawn, and estimators that err within what is stated."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from llsrbm.errors import InputError
from llsrbm.mechanics import tilt, yaw
from llsrbm.motion.rollout import Disturbance
from llsrbm.request.scenario import Scenario
from llsrbm.robots import load_robot
from llsrbm.simulation import sensors as module
from llsrbm.simulation.sensors import DELAY, ESTIMATORS, Drift, Sensors
from llsrbm.simulation.simulate import simulate
from llsrbm.simulation.world import TickResult
from tests.llsrbm.planning.solved import solved

ROBOT = load_robot("anymal")
TICK = 1 / 400
JOINTS = 12
AIR = TickResult.unknown(4, JOINTS)
GROUND = replace(AIR, contact=np.ones(4, dtype=bool))
STANDING = np.ones(4, dtype=bool)


def sensors(disturbance=None, tick=TICK, **scenario):
    return Sensors(ROBOT, disturbance or Disturbance(), Scenario(**scenario), tick)


def state(rng):
    q = pin.integrate(ROBOT.model, ROBOT.posture, rng.normal(scale=0.5, size=18))
    return q, rng.normal(size=18)


def test_the_truth_is_measured_at_once():
    rng, measuring = np.random.default_rng(0), sensors()
    for k in range(5):
        q, v = state(rng)
        measured = measuring.measure(k * TICK, (q, v), AIR, STANDING)
        assert measured.time == k * TICK
        assert measured.q.tolist() == q.tolist()
        assert measured.v.tolist() == v.tolist()
        assert measured.torque.tolist() == [0.0] * JOINTS


def test_noise_is_white_and_the_seeds():
    """The numbers of earlier versions: what a seed disturbs must not change."""
    world = Disturbance(base_velocity_noise=0.1, joint_velocity_noise=0.2)
    q, v = state(np.random.default_rng(1))
    measuring = sensors(world, seed=5)
    noise = np.array([measuring.measure(0, (q, v), AIR, STANDING).v - v for _ in range(200)])
    scale = np.r_[np.full(6, 0.1), np.full(12, 0.2)]
    expected = np.random.default_rng([5, 1]).standard_normal((200, 18)) * scale
    np.testing.assert_allclose(noise, expected, atol=1e-15)


class Run:
    """What `drift` makes of a robot that stands, then flies: errors over K ticks."""

    def __init__(self, seed, *, flying, ticks=400, tick=TICK):
        estimator, last = Drift(ROBOT, tick, seed), AIR if flying else GROUND
        q, v = state(np.random.default_rng(seed))
        q[3:7] = [0, 0, np.sin(seed), np.cos(seed)]  # upright, with any heading
        R = pin.Quaternion(q[3:7]).toRotationMatrix()
        place, speed, turn, joints = [], [], [], []
        for _ in range(ticks):
            eq, ev, _ = estimator.estimate(0.0, (q, v), last, STANDING)
            place.append(eq[:3] - q[:3])
            speed.append(R @ (ev - v)[:3])
            turn.append(pin.Quaternion(eq[3:7]).toRotationMatrix() @ R.T)
            joints.append((eq[7:] - q[7:], ev[3:] - v[3:]))
            assert np.linalg.norm(eq[3:7]) == pytest.approx(1)
        assert not any(np.any(each) for pair in joints for each in pair)
        self.place, self.speed, self.turn = np.array(place), np.array(speed), np.array(turn)


SEEDS = range(100)


@pytest.fixture(scope="module")
def stance():
    return [Run(seed, flying=False) for seed in SEEDS]


def test_the_position_drifts_horizontally_as_stated(stance):
    """A standard deviation of 1 cm after a second, from 0 on; feet that touch keep the height."""
    places = np.array([run.place for run in stance])
    assert not places[:, 0].any()
    assert not places[..., 2].any()
    spread = places[:, -1, :2].std()
    assert spread == pytest.approx(module.POSITION_DRIFT, rel=0.15)
    quarter = places[:, 100, :2].std()
    assert spread / quarter == pytest.approx(2.0, rel=0.25)


def test_the_velocity_errs_as_stated_and_its_sum_is_the_drift(stance):
    speeds = np.array([run.speed for run in stance])
    assert speeds.std() == pytest.approx(module.VELOCITY_ERROR, rel=0.05)
    for run in stance[:5]:
        summed = np.cumsum(run.speed, axis=0)[:-1] * TICK
        np.testing.assert_allclose(run.place[1:, :2], summed[:, :2], atol=1e-12)


def test_tilt_is_bounded_and_yaw_is_not(stance):
    """Half a degree each of roll and pitch; a heading that is 0.3 deg off after a second."""
    turns = np.degrees([[pin.log3(run.turn[k]) for k in (0, -1)] for run in stance])
    assert turns[..., :2].std() == pytest.approx(0.5, rel=0.1)
    assert turns[:, 0, 2] == pytest.approx(0, abs=1e-9)
    assert turns[:, 1, 2].std() == pytest.approx(0.3, rel=0.15)


def test_in_flight_the_velocitys_error_stays_and_the_height_drifts():
    runs = [Run(seed, flying=True, ticks=160) for seed in SEEDS]
    for run in runs[:5]:
        np.testing.assert_allclose(run.speed, np.tile(run.speed[0], (160, 1)), atol=1e-12)
        np.testing.assert_allclose(run.place[-1], 159 * TICK * run.speed[0], atol=1e-12)
    heights = np.array([run.place[-1, 2] for run in runs])
    assert heights.std() == pytest.approx(0.4 * module.VELOCITY_ERROR, rel=0.15)


def test_an_estimate_comes_late():
    rng, measuring = np.random.default_rng(3), sensors(tick=1 / 1000, estimator="drift")
    late = round(DELAY * 1000)
    states = [state(rng) for _ in range(8)]
    results = [np.full(JOINTS, float(k)) for k in range(8)]
    for k, each in enumerate(states):
        measured = measuring.measure(k / 1000, each, replace(AIR, torque=results[k]), STANDING)
        then = max(0, k - late)
        assert measured.time == k / 1000
        np.testing.assert_array_equal(measured.q[7:], states[then][0][7:])
        np.testing.assert_array_equal(measured.torque, results[then])


def test_an_unknown_estimator_is_refused():
    assert next(iter(ESTIMATORS)) == Scenario.estimator
    with pytest.raises(InputError, match=r'no estimator "nosuch"; .*truth, drift, imu'):
        sensors(estimator="nosuch")


def test_the_robots_own_sensors_have_the_noise_of_their_own_alone():
    noisy = Disturbance(base_velocity_noise=0.5, joint_velocity_noise=0.5)
    still = ROBOT.posture, np.zeros(18)
    one, other = (
        sensors(world, seed=4, estimator="imu").measure(0.0, still, None, STANDING)
        for world in (Disturbance(), noisy)
    )
    np.testing.assert_array_equal(one.v, other.v)
    assert 0.005 < one.v[6:].std() < 0.05
    assert np.linalg.norm(one.v[:3]) < 0.03
    assert one.torque.any()


def test_a_robot_that_moves_at_first_is_estimated_to():
    running = ROBOT.posture, np.zeros(18)
    rate = np.zeros(18)
    rate[0] = 0.4
    # Feet at rest: each leg's joints take back what the base does.
    model, data = ROBOT.model, ROBOT.model.createData()
    pin.computeJointJacobians(model, data, running[0])
    pin.updateFramePlacements(model, data)
    rows = np.vstack(
        [
            pin.getFrameJacobian(model, data, leg.foot_frame_id, pin.LOCAL_WORLD_ALIGNED)[:3]
            for leg in ROBOT.legs
        ]
    )
    rate[6:] = -np.linalg.lstsq(rows[:, 6:], rows[:, :6] @ rate[:6])[0]
    measured = sensors(seed=2, estimator="imu").measure(0.0, (running[0], rate), None, STANDING)
    assert measured.v[0] == pytest.approx(0.4, abs=0.04)  # less or more as the balls roll
    np.testing.assert_allclose(measured.v[1:6], 0, atol=0.04)


def test_a_jump_lands_with_an_estimators_errors():
    plan = solved("llsrbm-plus", "forward").plan
    rollout = simulate(plan, ROBOT, Scenario(seed=3, estimator="imu"))
    assert rollout.landed, rollout.outcome
    assert tilt(rollout.base_quat)[-1] < np.radians(2)
    assert abs(yaw(rollout.base_quat)[-1]) < np.radians(5)
