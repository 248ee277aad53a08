from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from llsrbm.control.foot_force import FootForces
from llsrbm.control.whole_body import WholeBody
from llsrbm.robots import load_robot
from tests.llsrbm.control.bodies import state

TICK = 0.0025


class Falling:
    """A robot under torques and foot forces, integrated by Pinocchio's forward dynamics."""

    def __init__(self, force, noise=0.0):
        self.robot = load_robot("anymal")
        self.force = np.asarray(force, dtype=float)
        self.rng = np.random.default_rng(3)
        self.noise = noise * np.repeat([0.01, 0.02], [6, 12])
        self.q, self.v = state(1)
        self.v *= 0.2
        self.torque = self.rng.normal(size=12)
        self.body = WholeBody(self.robot)
        self.estimate = FootForces(self.body, self.robot.leg_joint_index, TICK)

    def step(self):
        measured = self.v + self.noise * self.rng.standard_normal(18)
        self.body.update(self.q, measured)
        touching = self.estimate.update(self.torque)
        truth = WholeBody(self.robot)
        truth.update(self.q, self.v)
        pushed = np.einsum("lin,li->n", truth.contact_jacobian, self.force)
        rhs = np.concatenate([np.zeros(6), self.torque]) + pushed - truth.h
        self.v = self.v + np.linalg.solve(truth.M, rhs) * TICK
        self.q = pin.integrate(self.robot.model, self.q, self.v * TICK)
        return touching


@pytest.mark.parametrize("load", [(0, 0, 0, 0), (80, 0, 40, 120)])
def test_estimates_the_forces_that_act(load):
    robot = Falling(np.array(load)[:, None] * [0.1, -0.2, 1.0])
    for _ in range(8):
        robot.step()
    np.testing.assert_allclose(robot.estimate.vertical, load, atol=4.0)


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


def test_reset_forgets():
    robot = Falling(np.full((4, 3), 50.0))
    for _ in range(6):
        robot.step()
    robot.estimate.reset()
    assert not robot.estimate.vertical.any()
    assert not robot.step().any()
