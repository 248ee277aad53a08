"""The estimator against MuJoCo: standing, jumping, twisting; in flight against an integrator."""

from dataclasses import replace
from typing import ClassVar

import numpy as np
import pinocchio as pin
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from llsrbm.control.readings import Readings
from llsrbm.estimation.state_estimator import StateEstimator
from llsrbm.mechanics import rotation_matrices
from llsrbm.request.scenario import Scenario
from llsrbm.robots import load_robot
from llsrbm.simulation import simulate as simulation
from llsrbm.simulation.readings import Instruments
from llsrbm.simulation.sensors import Sensors
from llsrbm.simulation.simulate import simulate
from tests.llsrbm.planning.solved import solved
from tests.llsrbm.simulation.anymal_world import (
    ANYMAL,
    GRAVITY,
    JOINTS,
    TICK,
    in_the_air,
    springs,
    world_of,
)
from tests.llsrbm.simulation.test_readings import perfect  # noqa: F401  a fixture

STANDING, NONE = np.ones(4, dtype=bool), np.zeros(4, dtype=bool)


def resting(q, **changes):
    """Readings of a robot at rest in q (nq,), upright."""
    still = np.zeros(len(q) - 7)
    values = {
        "time": 0.0,
        "quat": np.array([1.0, 0, 0, 0]),
        "gyro": np.zeros(3),
        "acceleration": -GRAVITY,
        "q": q[7:],
        "dq": still,
        "torque": still,
        "foot_force": None,
    }
    return Readings(**values | changes)


def errors(estimated, true):
    """World frame: of velocity (3,) m/s, place (3,) m, attitude (3,) rad."""
    (q, v), (true_q, true_v) = estimated, true
    R, R_true = (rotation_matrices(each[[6, 3, 4, 5]]) for each in (q, true_q))
    return R @ v[:3] - R_true @ true_v[:3], q[:3] - true_q[:3], pin.log3(R @ R_true.T)


def test_it_begins_where_it_is_told_to_stand():
    q0 = ANYMAL.posture.copy()
    q0[:2] = 1.0, -2.0
    q0[3:7] = Rotation.from_euler("z", 0.7).as_quat()
    q, v = StateEstimator(ANYMAL, q0).update(resting(q0), STANDING)
    np.testing.assert_allclose(q, q0, atol=1e-9)
    np.testing.assert_allclose(v, 0, atol=1e-9)


@pytest.mark.parametrize("name", ["anymal", "slider"])
def test_a_robot_at_rest_stays_where_it_is_and_learns_its_gyroscopes_bias(name):
    robot = load_robot(name)
    estimator, stands = StateEstimator(robot, robot.posture), np.ones(len(robot.legs), dtype=bool)
    instruments = Instruments(robot, TICK, 1)
    still = robot.posture, np.zeros(robot.model.nv)
    for k in range(400):
        estimate = estimator.update(instruments.read(k * TICK, still), stands)
    velocity, place, turn = errors(estimate, still)
    assert np.abs(velocity).max() < 0.005
    assert np.abs(place).max() < 0.005
    assert np.degrees(np.abs(turn)).max() < 1.0
    rates = [instruments.read(k * TICK, still).gyro for k in range(400, 1200)]
    np.testing.assert_allclose(estimator.filter.gyro_bias, np.mean(rates, axis=0), atol=3e-3)


def test_four_feet_say_how_the_base_is_tilted_at_first():
    """Better than an inertial unit whose accelerometer has a bias; two points do not say it."""
    q0 = ANYMAL.posture.copy()
    wrong = Rotation.from_euler("y", 0.01).as_quat(scalar_first=True)
    for standing, tilt in ((STANDING, 0.0), (np.array([True, False, False, True]), 0.01)):
        q, _ = StateEstimator(ANYMAL, q0).update(resting(q0, quat=wrong), standing)
        assert Rotation.from_quat(q[3:7]).magnitude() == pytest.approx(tilt, abs=1e-9)


def test_in_flight_it_is_an_integrator():
    """SciPy's, of a body that turns and is pushed by its legs, from the same readings."""
    q0 = ANYMAL.posture
    estimator = StateEstimator(ANYMAL, q0)
    estimator.update(resting(q0), STANDING)

    def gyro(t):
        return np.array([2 * np.sin(5 * t), -3.0, 4 * np.cos(3 * t)])

    def force(t):
        return np.array([np.sin(20 * t), 2.0, -3 * np.cos(10 * t)])

    def rates(t, y):
        turn = Rotation.from_quat(y[:4])
        spin, vector = gyro(t), y[:3]
        along = 0.5 * (y[3] * spin + np.cross(vector, spin))
        return [*along, -0.5 * vector @ spin, *(turn.apply(force(t)) + GRAVITY), *y[4:7]]

    tick, flight = 1e-3, 0.4
    for k in range(round(flight / tick)):
        middle = (k + 0.5) * tick
        reading = resting(q0, time=(k + 1) * tick, gyro=gyro(middle), acceleration=force(middle))
        q, v = estimator.update(reading, NONE)
    y = solve_ivp(rates, (0, flight), [0, 0, 0, 1.0, *np.zeros(3), *q0[:3]], rtol=1e-10).y[:, -1]
    expected = np.concatenate([y[7:], y[:4] / np.linalg.norm(y[:4]), q0[7:]])
    _, place, turn = errors((q, v), (expected, v))
    R = rotation_matrices(q[[6, 3, 4, 5]])
    np.testing.assert_allclose(R @ v[:3], y[4:7], atol=1e-4)
    np.testing.assert_allclose(place, 0, atol=1e-4)
    np.testing.assert_allclose(turn, 0, atol=1e-4)
    # A mean over the tick is half a tick old.
    np.testing.assert_allclose(v[3:6], gyro(flight), atol=1e-3)


def run_in_world(q, v, standing, ticks, seed=0):
    """The estimate and the truth of each tick of a robot that holds a posture with springs."""
    world, instruments = world_of(), Instruments(ANYMAL, TICK, seed)
    world.reset(q, v)
    estimator, last, pairs = StateEstimator(ANYMAL, q), None, []
    for k in range(ticks):
        reading = instruments.read(k * TICK, world.state(), last)
        pairs.append((estimator.update(reading, standing), world.state()))
        last = world.advance(springs(world, ANYMAL.posture, stiffness=800.0, damping=20.0))
    return pairs


@pytest.mark.usefixtures("perfect")
def test_perfect_sensors_make_a_perfect_flight():
    q, v = in_the_air()
    q[7:] += 0.3  # the legs swing back, and the base with them
    pairs = run_in_world(q, v, NONE, 160)
    assert np.abs(pairs[20][1][1][3:6]).max() > 0.1
    velocity, place, turn = errors(*pairs[-1])
    np.testing.assert_allclose(velocity, 0, atol=1e-3)
    np.testing.assert_allclose(place, 0, atol=1e-3)
    np.testing.assert_allclose(turn, 0, atol=1e-3)


def test_a_foot_that_is_said_to_stand_and_does_not_is_planted_anew():
    """Standing is claimed all through a bounce of 3 cm and the rest after it."""
    q, v = in_the_air(0.03)
    pairs = run_in_world(q, v, STANDING, 400, seed=2)
    worst = max(np.abs(errors(*pair)[0]).max() for pair in pairs)
    assert worst > 0.05  # it is believed for some ticks
    velocity, _, turn = errors(*pairs[-1])
    assert np.abs(velocity).max() < 0.04
    assert np.degrees(np.abs(turn)).max() < 2.0


def test_only_what_a_robot_has_counts():
    """Not the torques, nor feet that feel, nor the unit's attitude but the first."""
    readings = Instruments(ANYMAL, TICK, 3)
    still = ANYMAL.posture, np.zeros(6 + JOINTS)
    one, other = (StateEstimator(ANYMAL, ANYMAL.posture) for _ in range(2))
    for k in range(20):
        reading = readings.read(k * TICK, still)
        q, v = one.update(reading, STANDING)
        changed = replace(reading, torque=reading.torque + 5, foot_force=np.ones(4))
        if k > 0:
            changed = replace(changed, quat=np.array([0.0, 1.0, 0.0, 0.0]))
        changed_q, changed_v = other.update(changed, STANDING)
        np.testing.assert_array_equal(q, changed_q)
        np.testing.assert_array_equal(v, changed_v)


class Watched(Sensors):
    kept: ClassVar[list] = []

    def measure(self, time, state, last, standing):
        measured = super().measure(time, state, last, standing)
        Watched.kept.append((time, (measured.q, measured.v), state))
        return measured


def test_a_jump_is_followed_with_it(monkeypatch):
    monkeypatch.setattr(simulation, "Sensors", Watched)
    Watched.kept.clear()
    plan = solved("llsrbm-plus", "twist").plan
    outcome = simulate(plan, ANYMAL, Scenario(seed=8990, estimator="imu")).outcome
    assert outcome.strict, outcome
    times = np.array([time for time, *_ in Watched.kept])
    for instant in (plan.lift_off, outcome.touchdown_true_s, times[-1]):
        _, estimated, true = Watched.kept[int(np.searchsorted(times, instant - 1e-9))]
        velocity, place, turn = errors(estimated, true)
        assert np.linalg.norm(velocity) < 0.05
        assert abs(place[2]) < 0.012
        assert np.degrees(np.linalg.norm(turn[:2])) < 1.5
        assert np.degrees(abs(turn[2])) < 1.0
