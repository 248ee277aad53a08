"""Motions to be shown: a plan of each robot, and what it became in the simulator."""

import re
import shutil
from dataclasses import dataclass, replace
from functools import cache

from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.robots import load_robot
from tests.llsrbm.formats.jumps import planned, simulated


@dataclass(frozen=True)
class Motion:
    plan: Plan
    rollout: Rollout


@cache
def motion_of(robot):
    return Motion(planned(robot), replace(simulated(robot), plan=planned(robot)))


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
