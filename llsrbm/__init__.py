"""Jumps of legged robots: plan with a lump leg single rigid body model, replay, export.

    import llsrbm
    plan = llsrbm.plan(llsrbm.Jump(robot="anymal", twist=1.57))
    plan.save("plan.npz")

World frame: x forward, y left, z up; SI units; quaternions w, x, y, z; angles in radians.
"""

from llsrbm.api import plan
from llsrbm.errors import (
    Cancelled,
    Error,
    FileFormatError,
    InputError,
    NotConverged,
    RobotFileError,
)
from llsrbm.export import export
from llsrbm.jump import Jump
from llsrbm.trajectory.files import load
from llsrbm.trajectory.plan import Plan

__all__ = [
    "Cancelled",
    "Error",
    "FileFormatError",
    "InputError",
    "Jump",
    "NotConverged",
    "Plan",
    "RobotFileError",
    "export",
    "load",
    "plan",
]
