"""The biped on soles: the same chain, another robot file."""

import math
from functools import cache

import numpy as np
import pytest

import llsrbm
from llsrbm.motion.plan import Plan
from llsrbm.request.scenario import Scenario
from llsrbm.robots import load_robot
from llsrbm.simulation.simulate import simulate

JUMPS = {
    "twist": {"twist": math.pi / 2},
    "forward": {"forward": 0.2},
    "box": {"forward": 0.2, "height": 0.35},
}


@cache
def plan(jump: str) -> Plan:
    return llsrbm.plan(llsrbm.Jump(robot="slider", **JUMPS[jump]), draft=True)


@pytest.mark.parametrize("jump", JUMPS)
def test_the_papers_jumps_land_strictly(jump):
    rollout = simulate(plan(jump), load_robot("slider"), Scenario(seed=5))
    outcome = rollout.outcome
    assert outcome.strict, outcome
    assert abs(np.degrees(outcome.yaw_error_at_touchdown)) < 5
    assert outcome.false_touchdowns == 0
    assert outcome.landing_strategy == "tracking"  # its file has no force phase
    assert outcome.control_rate_hz == pytest.approx(1000)
    height = JUMPS[jump].get("height", 0.0)
    np.testing.assert_allclose(rollout.foot_position[-1, :, 2], height, atol=5e-3)


def test_a_board_nobody_planned_for():
    scenario = Scenario(board=0.02, seed=1)
    rollout = simulate(plan("twist"), load_robot("slider"), scenario)
    assert rollout.landed, rollout.outcome
