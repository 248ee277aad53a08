"""Delays that are known from torques, and states that are foreseen, against an integrator's own."""

import numpy as np
import pinocchio as pin
import pytest

from llsrbm.control.delay import MOST, DelayEstimate, Measurement
from llsrbm.control.inverse_dynamics import Command
from llsrbm.control.whole_body import WholeBody
from llsrbm.robots import load_robot

ROBOT = load_robot("go2")
TICK = 0.0025


def command(rng):
    return Command(rng.normal(size=12), rng.normal(size=18), np.zeros((4, 3)), solved=True)


def run(delay, ticks=20, noise=0.0, seed=0):
    """An estimate that has seen torques come so many ticks late, and the commands it was told."""
    rng = np.random.default_rng(seed)
    estimate, sent = DelayEstimate(TICK), []
    for _ in range(ticks):
        if len(sent) > delay:
            late = sent[-1 - delay].torque
            estimate.measured(late + noise * rng.normal(size=12))
        sent.append(command(rng))
        estimate.sent(sent[-1])
    return estimate, sent


@pytest.mark.parametrize("delay", range(MOST + 1))
@pytest.mark.parametrize("noise", [0.0, 0.3])
def test_the_delay_is_known_from_the_torques(delay, noise):
    estimate, _ = run(delay, noise=noise)
    assert estimate.ticks == delay


def test_nothing_is_foreseen_without_a_delay():
    estimate, _ = run(0)
    here = Measurement(0.3, ROBOT.posture, np.ones(18), np.zeros(12))
    met = estimate.met(here, WholeBody(ROBOT))
    assert (met.time, met.q.tolist(), met.v.tolist()) == (0.3, here.q.tolist(), here.v.tolist())


@pytest.mark.parametrize("delay", [1, 2, 3])
def test_the_state_is_foreseen_under_the_commands_under_way(delay):
    """A thousand steps a tick, each with the acceleration of the command that acts in it."""
    estimate, sent = run(delay)
    rng = np.random.default_rng(7)
    q, v = ROBOT.posture.copy(), 0.5 * rng.normal(size=18)
    met = estimate.met(Measurement(0.3, q, v, np.zeros(12)), WholeBody(ROBOT))
    steps = 1000
    for acting in sent[-delay:]:
        for _ in range(steps):
            step = TICK / steps
            q = pin.integrate(ROBOT.model, q, (v + acting.acceleration * step / 2) * step)
            v = v + acting.acceleration * step
    assert met.time == pytest.approx(0.3 + delay * TICK)
    np.testing.assert_allclose(met.v, v, atol=1e-12)
    np.testing.assert_allclose(met.q, q, atol=1e-5)
