import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st

from llsrbm.control.foot_force import FootForces, MeasuredImpulse
from llsrbm.control.whole_body import WholeBody
from llsrbm.robots import load_robot
from tests.llsrbm.control.bodies import state

TICK = 0.0025


class Falling:
    """A robot under torques, its drives' friction and foot forces, by Pinocchio's dynamics."""

    def __init__(self, force, noise=0.0, foreseen=0.0):
        self.robot = load_robot("anymal")
        self.force = np.asarray(force, dtype=float)
        self.rng = np.random.default_rng(3)
        self.foreseen = foreseen  # s
        self.noise = noise * np.repeat([0.01, 0.02], [6, 12])
        self.q, self.v = state(1)
        self.v *= 0.2
        self.torque = self.rng.normal(size=12)
        self.body = WholeBody(self.robot)
        self.estimate = FootForces(self.robot, self.body, TICK)

    def step(self):
        measured = self.v + self.noise * self.rng.standard_normal(18)
        guess = self.rng.normal(scale=50, size=18) * self.foreseen  # the ground is not foreseen
        q = pin.integrate(self.robot.model, self.q, (measured + guess / 2) * self.foreseen)
        self.body.update(q, measured + guess)
        touching = self.estimate.update(self.torque, measured, self.body.com_velocity)
        truth = WholeBody(self.robot)
        truth.update(self.q, self.v)
        pushed = np.einsum("lin,li->n", truth.contact_jacobian, self.force)
        dq, robot = self.v[6:], self.robot
        coulomb = robot.friction * np.tanh(100 * dq / robot.speed_limit)
        moving = self.torque - coulomb - robot.damping * dq
        rhs = np.concatenate([np.zeros(6), moving]) + pushed - truth.h
        self.v = self.v + np.linalg.solve(truth.M, rhs) * TICK
        self.q = pin.integrate(self.robot.model, self.q, self.v * TICK)
        return touching


@pytest.mark.parametrize("load", [(0, 0, 0, 0), (80, 0, 40, 120)])
def test_estimates_the_forces_that_act(load):
    robot = Falling(np.array(load)[:, None] * [0.1, -0.2, 1.0])
    for _ in range(8):
        robot.step()
    np.testing.assert_allclose(robot.estimate.vertical, load, atol=4.0)


def test_forces_are_those_measured_however_the_state_is_foreseen():
    robot = Falling(np.array([80, 0, 40, 120])[:, None] * [0.1, -0.2, 1.0], foreseen=0.003)
    for _ in range(8):
        robot.step()
    np.testing.assert_allclose(robot.estimate.vertical, [80, 0, 40, 120], atol=6.0)


def test_loaded_feet_are_found_within_three_ticks():
    robot = Falling(np.zeros((4, 3)))
    for _ in range(4):
        assert not robot.step().any()
    robot.force[1, 2] = 100.0
    found = [robot.step() for _ in range(4)]
    assert found[-1].tolist() == [False, True, False, False]


def test_measured_noise_is_no_contact():
    robot = Falling(np.zeros((4, 3)), noise=1.0)
    assert not any(robot.step().any() for _ in range(40))


MASS, G = 30.0, np.array([0.0, 0.0, -9.81])


def flown(impulse, force, by_feet, ticks, velocity):
    """Fall for some ticks under a force, a share of which passes through the feet."""
    for _ in range(ticks):
        velocity = velocity + (G + force / MASS) * TICK
        impulse.update(velocity, by_feet * force)
    return velocity


vectors = st.tuples(*[st.floats(-1, 1)] * 3).map(np.array).filter(lambda v: np.linalg.norm(v) > 0.1)


@given(vectors, st.integers(1, 8), st.floats(0.5, 1.2) | st.floats(-0.1, 0.1))
def test_what_passes_through_the_feet_is_the_ground_and_all_else_a_push(direction, ticks, by_feet):
    impulse = MeasuredImpulse(MASS, TICK)
    v = flown(impulse, np.zeros(3), 0.0, 10, np.zeros(3))
    flown(impulse, 400 * direction, by_feet, ticks, v)
    assert impulse.is_ground() == (by_feet >= 0.5)
    assert impulse.pushed == (by_feet < 0.5)


def test_noise_after_a_push_is_not_the_ground_and_the_ground_still_is():
    impulse = MeasuredImpulse(MASS, TICK)
    v = flown(impulse, np.array([800.0, 0.0, 0.0]), 0.0, 8, np.zeros(3))
    assert not impulse.is_ground()
    v = flown(impulse, np.array([0.1, 0.0, 2.0]), 1.0, 10, v)
    assert not impulse.is_ground()
    flown(impulse, np.array([0.0, 0.0, 500.0]), 1.0, 2, v)
    assert impulse.is_ground()
    impulse.reset()
    assert not impulse.pushed
