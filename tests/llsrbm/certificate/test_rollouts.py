"""Certificates of simulations, against what the simulation itself recorded."""

import numpy as np
import pytest

import llsrbm
from llsrbm.robots import load_robot
from tests.llsrbm.formats.jumps import planned, simulated


@pytest.fixture(scope="module", params=["go2", "slider"])
def rollout(request):
    return simulated(request.param)


@pytest.fixture(scope="module")
def certificate(rollout):
    return llsrbm.certify(rollout)


def test_torques_and_speeds_are_the_recorded_ones(rollout, certificate):
    recorded = (np.abs(rollout.torque) / load_robot(rollout.jump.robot).torque_limit).max()
    assert certificate["joint_torque"].worst == pytest.approx(recorded, rel=1e-3)
    speed = certificate["joint_speed"].worst
    assert speed == pytest.approx(rollout.outcome.peak_speed_ratio, rel=0.02)


def test_the_simulators_motion_obeys_newton_and_keeps_its_feet_down(rollout, certificate):
    for name in ("dynamics", "slip", "contact_force", "clearance", "friction", "self_distance"):
        assert certificate[name].holds, certificate[name]
    assert certificate["friction"].limit == rollout.disturbance.friction


def test_a_push_is_no_contact():
    pushed = llsrbm.simulate(planned("go2"), pushes=[llsrbm.Push(0.1, (3.0, 0.0, 0.0))])
    found = llsrbm.certify(pushed)["dynamics"]
    assert found.holds is None
    assert "pushes" in found.why
