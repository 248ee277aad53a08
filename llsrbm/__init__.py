"""Jumps of legged robots: plan with a lump leg single rigid body model, simulate, replay, export.

    import llsrbm
    plan = llsrbm.plan(llsrbm.Jump(robot="anymal", twist=1.57))
    rollout = llsrbm.simulate(plan)
    plan.save("plan.npz")

World frame: x forward, y left, z up; SI units; quaternions w, x, y, z; angles in radians.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from llsrbm.errors import (
    Cancelled,
    Error,
    FileFormatError,
    InputError,
    NotConverged,
    RobotFileError,
    Stop,
)
from llsrbm.jump import Jump
from llsrbm.push import Push
from llsrbm.scenario import Scenario
from llsrbm.tuning import Tuning

if TYPE_CHECKING:
    from llsrbm.api import nearest, plan, simulate
    from llsrbm.design import Design, dump_design, load_design
    from llsrbm.formats import export, load_motion
    from llsrbm.motion.files import load
    from llsrbm.motion.plan import Plan
    from llsrbm.motion.rollout import Rollout
    from llsrbm.planning.nearest import Nearest

# CasADi and Pinocchio take most of a second to import: only when they are used.
_LATER = {
    "plan": "llsrbm.api",
    "nearest": "llsrbm.api",
    "simulate": "llsrbm.api",
    "Design": "llsrbm.design",
    "dump_design": "llsrbm.design",
    "load_design": "llsrbm.design",
    "export": "llsrbm.formats",
    "load": "llsrbm.motion.files",
    "load_motion": "llsrbm.formats",
    "Nearest": "llsrbm.planning.nearest",
    "Plan": "llsrbm.motion.plan",
    "Rollout": "llsrbm.motion.rollout",
}

__all__ = [
    "Cancelled",
    "Design",
    "Error",
    "FileFormatError",
    "InputError",
    "Jump",
    "Nearest",
    "NotConverged",
    "Plan",
    "Push",
    "RobotFileError",
    "Rollout",
    "Scenario",
    "Stop",
    "Tuning",
    "dump_design",
    "export",
    "load",
    "load_design",
    "load_motion",
    "nearest",
    "plan",
    "simulate",
]


def __getattr__(name: str) -> Any:
    if name not in _LATER:
        raise AttributeError(f"module 'llsrbm' has no attribute {name!r}")
    value = getattr(import_module(_LATER[name]), name)
    globals()[name] = value
    return value
