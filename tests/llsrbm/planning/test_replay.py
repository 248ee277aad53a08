"""Plans are what their forces and feet do: replayed with another integrator, from the start."""

import numpy as np
import pytest

from llsrbm import models
from llsrbm.motion.plan import Phase
from tests.llsrbm.planning.replay import angle_between, replay
from tests.llsrbm.planning.solved import REQUESTS, solved


@pytest.mark.parametrize("request_name", REQUESTS)
@pytest.mark.parametrize("model", models.names())
def test_replayed(model, request_name):
    s = solved(model, request_name)
    plan = s.plan
    states = replay(plan, s.planner.model, step=2e-3)

    def drift(name, planned):
        return np.abs(np.array([getattr(s, name) for s in states]) - planned).max()

    # Forces are constant over an interval: these are exact whatever the interval's length.
    assert drift("position", plan.com) < 1e-8
    assert drift("velocity", plan.com_velocity) * s.task.mass < 1e-6
    assert drift("momentum", plan.angular_momentum) < 1e-6
    # The attitude turns about the midpoint's axis: measured 0.0000 to 0.03 degrees.
    turned = [angle_between(a.quat, q) for a, q in zip(states, plan.base_quat, strict=True)]
    assert turned[int(np.argmax(plan.phase == Phase.LANDING))] < 0.05
    assert max(turned) < 0.05


@pytest.mark.parametrize("request_name", ["twist", "box"])
def test_soles_replayed(request_name):
    s = solved("llsrbm-plus", request_name, "slider")
    states = replay(s.plan, s.planner.model, step=2e-3)
    momentum = np.array([state.momentum for state in states])
    assert np.abs(momentum - s.plan.angular_momentum).max() < 1e-6
    turned = [angle_between(a.quat, q) for a, q in zip(states, s.plan.base_quat, strict=True)]
    # The light pelvis turns faster within an interval than a quadruped's trunk.
    assert max(turned) < 0.2


def test_the_integrators_own_error_is_beyond_notice():
    s = solved("llsrbm-plus", "twist")
    coarse, fine = (replay(s.plan, s.planner.model, step)[-1] for step in (4e-3, 2e-3))
    assert angle_between(coarse.quat, fine.quat) < 1e-5
    np.testing.assert_allclose(coarse.momentum, fine.momentum, atol=1e-10)
