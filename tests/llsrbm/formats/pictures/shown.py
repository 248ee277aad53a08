"""Motions to be shown: a plan of each robot, and what it became in the simulator."""

from dataclasses import dataclass, replace
from functools import cache

import llsrbm
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout

JUMPS = {
    "anymal": {"twist": 0.8, "forward": 0.5, "height": 0.1},
    "slider": {"twist": 1.57},
    "go2": {"twist": 3.1, "forward": 0.2},
}


@dataclass(frozen=True)
class Motion:
    plan: Plan
    rollout: Rollout


@cache
def motion_of(robot):
    plan = llsrbm.plan(llsrbm.Jump(robot=robot, **JUMPS[robot]))
    assert plan.solved
    rollout = llsrbm.simulate(plan)
    assert rollout.landed
    return Motion(plan, replace(rollout, plan=plan))
