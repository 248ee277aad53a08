"""The biped on soles: the same chain, another robot file."""

import numpy as np
import pytest

from llsrbm.request.scenario import Scenario
from llsrbm.robots import load_robot
from llsrbm.simulation.simulate import simulate
from tests.llsrbm.planning.solved import solved


def test_the_papers_twist_lands_strictly():
    plan = solved("llsrbm-plus", "twist", "slider").plan
    rollout = simulate(plan, load_robot("slider"), Scenario(seed=5))
    outcome = rollout.outcome
    assert outcome.strict, outcome
    assert abs(np.degrees(outcome.yaw_error_at_touchdown)) < 5
    assert outcome.false_touchdowns == 0
    assert outcome.landing_strategy == "tracking"  # its file has no force phase
    assert outcome.control_rate_hz == pytest.approx(1000)
    np.testing.assert_allclose(rollout.foot_position[-1, :, 2], plan.jump.height, atol=5e-3)


def test_a_board_nobody_planned_for():
    scenario = Scenario(board=0.02, seed=1)
    plan = solved("llsrbm-plus", "twist", "slider").plan
    rollout = simulate(plan, load_robot("slider"), scenario)
    assert rollout.landed, rollout.outcome
