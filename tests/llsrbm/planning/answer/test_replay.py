"""Plans are what their forces and feet do: replayed with another integrator, from the start."""

import numpy as np
import pytest

from llsrbm import models
from tests.llsrbm.planning.replay import angle_between, replay
from tests.llsrbm.planning.solved import FLIPS, TYPES, solved

STEP = 5e-3  # s


def drift(states, name, planned):
    return np.abs(np.array([getattr(s, name) for s in states]) - planned).max()


def turned(states, plan):
    """(N+1,) degrees between the replayed attitudes and the plan's."""
    pairs = zip(states, plan.base_quat, strict=True)
    return np.array([angle_between(state.quat, quat) for state, quat in pairs])


@pytest.mark.parametrize("model", models.MODELS)
def test_replayed(model):
    s = solved(model, "all")
    plan = s.plan
    states = replay(plan, s.planner.model, step=STEP)
    # Forces are constant over an interval: these are exact whatever the interval's length.
    assert drift(states, "position", plan.com) < 1e-8
    assert drift(states, "velocity", plan.com_velocity) * s.task.mass < 1e-6
    assert drift(states, "momentum", plan.angular_momentum) < 1e-6
    # The attitude turns about the midpoint's axis: measured 0.0000 to 0.03 degrees.
    assert turned(states, plan).max() < 0.05


@pytest.mark.nightly
@pytest.mark.parametrize("name", [*TYPES, *FLIPS])
def test_any_schedule_replayed(name):
    s = solved("llsrbm-plus", name, "go2" if name in FLIPS else "anymal")
    plan = s.plan
    states = replay(plan, s.planner.model, step=STEP, correction=s.task.correction)
    assert drift(states, "position", plan.com) < 1e-8
    assert drift(states, "velocity", plan.com_velocity) * s.task.mass < 1e-6
    assert drift(states, "momentum", plan.angular_momentum) < 1e-6
    assert turned(states, plan)[-1] < 0.5


def test_soles_replayed():
    s = solved("llsrbm-plus", "twist", "slider")
    states = replay(s.plan, s.planner.model, step=STEP)
    assert drift(states, "momentum", s.plan.angular_momentum) < 1e-6
    # The light pelvis turns faster within an interval than a quadruped's trunk.
    assert turned(states, s.plan).max() < 0.2
