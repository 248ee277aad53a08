"""Feet that leave the ground, by what is asked of them and by what they take in simulations."""

from types import SimpleNamespace

import numpy as np
import pytest

import llsrbm
from app.tab.start.initial_plan import shipped_file
from llsrbm.control import controller
from llsrbm.control.leaving import SWEEPING, SWINGING, leaving
from llsrbm.control.reference import Reference
from llsrbm.mechanics import GRAVITY
from llsrbm.robots import load_robot

LOW, HIGH = [0, 2], [1, 3]
NAMES = ("foot_from_com", "foot_velocity_from_com", "foot_acceleration_from_com")


@pytest.fixture(scope="module")
def plan():
    return llsrbm.load(shipped_file("anymal"))


@pytest.fixture(scope="module")
def target(plan):
    reference = Reference(plan, load_robot("anymal").mass * GRAVITY)
    return reference.at(plan.lift_off + 0.01)


@pytest.fixture
def body(target):
    """Two of its feet are 1 mm above the ground, which is 0.1 m high, two of them 5 cm."""
    com = target.com + 0.01
    foot = com + target.foot_from_com + 0.005
    foot[:, 2] = 0.1 + np.array([0.001, 0.05, 0.001, 0.05])
    return SimpleNamespace(foot=foot, com=com, com_velocity=np.array([0.3, 0.1, 2.0]))


@pytest.mark.parametrize(("way", "until"), [(SWINGING, 0.05), (SWEEPING, 0.0045)])
def test_low_feet_do_not_sweep_over_the_ground(target, body, way, until):
    """In the world their target has neither an error nor a speed along the ground, for a while."""
    ground, along = np.full(4, 0.1), slice(2)
    found = leaving(way, target, body, until - 0.001, ground)
    place, speed = body.com + found.foot_from_com, body.com_velocity + found.foot_velocity_from_com
    np.testing.assert_allclose(place[LOW, along], body.foot[LOW, along])
    np.testing.assert_allclose(speed[LOW, along], 0, atol=1e-12)
    assert not found.foot_acceleration_from_com[LOW, along].any()
    for name in NAMES:
        np.testing.assert_array_equal(getattr(found, name)[HIGH], getattr(target, name)[HIGH])
    assert leaving(way, target, body, until + 0.001, ground) is target


def test_low_feet_rise_and_those_that_rise_faster_are_not_held_back(target, body):
    fast = target.foot_velocity_from_com.copy()
    fast[0, 2] = 3.0 - body.com_velocity[2]
    fast[2, 2] = 0.2 - body.com_velocity[2]
    target = target._replace(foot_velocity_from_com=fast)
    found = leaving(SWINGING, target, body, 0.002, np.full(4, 0.1))
    speed = body.com_velocity + found.foot_velocity_from_com
    np.testing.assert_allclose(speed[LOW, 2], [3.0, SWINGING.rising])
    swept = leaving(SWEEPING, target, body, 0.002, np.full(4, 0.1))
    for name in NAMES:  # legs that sweep rise by themselves
        np.testing.assert_array_equal(getattr(swept, name)[:, 2], getattr(target, name)[:, 2])


def test_feet_that_leave_take_no_momentum(plan, monkeypatch):
    """They gave 24 to 62 g m²/s as the swing dragged them over a ground that gives way.

    What the momentum changes without a force, a thousandth of it, is the simulator's integrator's.
    """

    def taken(seed):
        """Whether a foot pushes, and by how much the momentum changes, kg m²/s."""
        rollout = llsrbm.simulate(plan, seed=seed)
        before, after = np.searchsorted(rollout.time, plan.lift_off + np.array([0.002, 0.05]))
        change = rollout.angular_momentum[after] - rollout.angular_momentum[before]
        return rollout.contact_force[before:after].any(), np.linalg.norm(change)

    for pushes, change in map(taken, (3, 4)):
        assert not pushes
        assert change < 6e-3
    monkeypatch.setattr(controller, "leaving", lambda way, target, *state: target)
    for pushes, change in map(taken, (3, 4)):
        assert pushes
        assert change > 2e-2
