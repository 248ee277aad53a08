"""Delays that are known from torques, and states that are foreseen, against an integrator's own."""

import math
from collections import Counter

import numpy as np
import pinocchio as pin
import pytest

from llsrbm.control.delay import MOST, DelayEstimate, Measurement
from llsrbm.control.inverse_dynamics import Command
from llsrbm.control.whole_body import WholeBody
from llsrbm.robots import load_robot

ROBOT = load_robot("go2")
TICK = 0.0025
KNOWN = (0.001, 0.0025, 0.0045)  # s: parts of a tick, whole ones, both


def command(rng):
    return Command(rng.normal(size=12), rng.normal(size=18), np.zeros((4, 3)), solved=True)


def run(delay, ticks=20, noise=0.0, seed=0, known=0.0):
    """An estimate that has seen torques come so many ticks later than is known, s, and commands."""
    rng = np.random.default_rng(seed)
    estimate, sent = DelayEstimate(TICK, known), []
    for tick in range(ticks):
        if sent:
            came = acted(sent, tick - 1, known + delay * TICK)
            torque = sum(share * command.torque for command, share in came)
            estimate.measured(torque + noise * rng.normal(size=12))
        sent.append(command(rng))
        estimate.sent(sent[-1])
    return estimate, sent


def acting(time, late):
    """Which command acts at a time, ticks since the first; before its time the first."""
    return max(0, math.floor(time - late / TICK + 1e-9))


def acted(sent, tick, late):
    """The commands that act in a tick, with their shares of it."""
    instants = tick + (np.arange(1000) + 0.5) / 1000
    shares = Counter(acting(time, late) for time in instants)
    return [(sent[index], count / 1000) for index, count in shares.items()]


@pytest.mark.parametrize("delay", range(MOST + 1))
@pytest.mark.parametrize(("noise", "known"), [(0.3, 0.0), *((0.0, known) for known in KNOWN)])
def test_the_delay_is_known_from_the_torques(delay, noise, known):
    """By how much more than the drives' own commands come late."""
    estimate, _ = run(delay, noise=noise, known=known)
    assert estimate.ticks == delay


def test_nothing_is_foreseen_without_a_delay():
    estimate, _ = run(0)
    here = Measurement(0.3, ROBOT.posture, np.ones(18), np.zeros(12))
    met = estimate.met(here, WholeBody(ROBOT))
    assert (met.time, met.q.tolist(), met.v.tolist()) == (0.3, here.q.tolist(), here.v.tolist())


@pytest.mark.parametrize("delay", [0, 3])
@pytest.mark.parametrize("known", KNOWN)
def test_the_state_is_foreseen_under_the_commands_under_way(delay, known):
    """A thousand steps a tick, each with the acceleration of the command that acts in it."""
    estimate, sent = run(delay, known=known)
    rng = np.random.default_rng(7)
    q, v = ROBOT.posture.copy(), 0.5 * rng.normal(size=18)
    met = estimate.met(Measurement(0.3, q, v, np.zeros(12)), WholeBody(ROBOT))
    late, steps = known + delay * TICK, 1000
    step = TICK / steps
    for k in range(round(late / step)):
        a = sent[acting(len(sent) + (k + 0.5) / steps, late)].acceleration
        q = pin.integrate(ROBOT.model, q, (v + a * step / 2) * step)
        v = v + a * step
    assert met.time == pytest.approx(0.3 + late)
    np.testing.assert_allclose(met.v, v, atol=1e-12)
    np.testing.assert_allclose(met.q, q, atol=1e-5)


@pytest.mark.parametrize("delay", [0, 2])
@pytest.mark.parametrize("known", KNOWN)
def test_what_was_expected_of_a_tick_is_what_its_commands_were_made_for(delay, known):
    estimate, sent = run(delay, known=known)
    tick = len(sent) - 1  # the one that ends
    came = acted(sent, tick, known + delay * TICK)
    expected = sum(share * command.acceleration for command, share in came)
    np.testing.assert_allclose(estimate.acted(), expected, atol=1e-9)


def test_nothing_is_expected_before_commands_have_come():
    estimate = DelayEstimate(TICK, 0.003)
    assert estimate.acted() is None
