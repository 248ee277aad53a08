"""Motions to be shown: a plan of each robot, and what it became in the simulator."""

import re
import shutil
from dataclasses import dataclass, replace
from functools import cache

import llsrbm
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.robots import load_robot

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
    plan = llsrbm.plan(llsrbm.Jump(robot=robot, **JUMPS[robot]), draft=True)
    assert plan.solved
    rollout = llsrbm.simulate(plan)
    assert rollout.landed
    return Motion(plan, replace(rollout, plan=plan))


def without_meshes(folder):
    """SLIDER's plan, of a robot whose URDF has nothing but shapes to collide with."""
    robot = load_robot("slider")
    shutil.copytree(robot.urdf_path.parent, folder / "slider")
    for path in (folder / "slider").rglob("*.urdf"):
        path.write_text(re.sub(r"<visual.*?</visual>", "", path.read_text(), flags=re.DOTALL))
    text = robot.path.read_text(encoding="utf-8").replace('"../slider/', '"slider/')
    (folder / "bare.toml").write_text(text, encoding="utf-8")
    plan = motion_of("slider").plan
    return replace(plan, jump=replace(plan.jump, robot=str(folder / "bare.toml")))
