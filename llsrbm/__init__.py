"""Jumps of legged robots: plan with a lump leg single rigid body model, simulate, replay, export.

    import llsrbm
    plan = llsrbm.plan(llsrbm.Jump(robot="anymal", twist=1.57))
    rollout = llsrbm.simulate(plan)
    plan.save("plan.npz")

World frame: x forward, y left, z up; SI units; quaternions w, x, y, z; angles in radians.
"""

from __future__ import annotations

from importlib import import_module

TYPE_CHECKING = False  # `typing` would take longer to import than this module
if TYPE_CHECKING:
    from typing import Any

    from llsrbm.analysis.sensitivity import sensitivity
    from llsrbm.api import largest, plan, simulate
    from llsrbm.certificate import certified, certify
    from llsrbm.errors import (
        Cancelled,
        Error,
        FileFormatError,
        InputError,
        NotConverged,
        RobotFileError,
        Stop,
    )
    from llsrbm.formats import export, load_motion
    from llsrbm.motion.plan import Plan
    from llsrbm.motion.rollout import Rollout
    from llsrbm.motion.trajectory import load
    from llsrbm.planning.whole_body.feedback import with_feedback
    from llsrbm.repairing.clip import repair_clip
    from llsrbm.repairing.repair import repair
    from llsrbm.repairing.result import ClipRepair, Repair
    from llsrbm.request.design import Design, dump_design, load_design
    from llsrbm.request.jump import Jump
    from llsrbm.request.scenario import Push, Scenario
    from llsrbm.request.tuning import Tuning

# Imported when they are used: CasADi and Pinocchio take most of a second, and Ctrl-C on a command
# shall find its way before that.
_LATER = {
    name: module
    for module, names in {
        "llsrbm.analysis.sensitivity": ("sensitivity",),
        "llsrbm.api": ("largest", "plan", "simulate"),
        "llsrbm.certificate": ("certified", "certify"),
        "llsrbm.errors": (
            *("Cancelled", "Error", "FileFormatError", "InputError", "NotConverged"),
            *("RobotFileError", "Stop"),
        ),
        "llsrbm.request.design": ("Design", "dump_design", "load_design"),
        "llsrbm.request.jump": ("Jump",),
        "llsrbm.request.scenario": ("Push", "Scenario"),
        "llsrbm.request.tuning": ("Tuning",),
        "llsrbm.formats": ("export", "load_motion"),
        "llsrbm.motion.trajectory": ("load",),
        "llsrbm.motion.plan": ("Plan",),
        "llsrbm.motion.rollout": ("Rollout",),
        "llsrbm.planning.whole_body.feedback": ("with_feedback",),
        "llsrbm.repairing.clip": ("repair_clip",),
        "llsrbm.repairing.repair": ("repair",),
        "llsrbm.repairing.result": ("ClipRepair", "Repair"),
    }.items()
    for name in names
}

__all__ = [
    "Cancelled",
    "ClipRepair",
    "Design",
    "Error",
    "FileFormatError",
    "InputError",
    "Jump",
    "NotConverged",
    "Plan",
    "Push",
    "Repair",
    "RobotFileError",
    "Rollout",
    "Scenario",
    "Stop",
    "Tuning",
    "certified",
    "certify",
    "dump_design",
    "export",
    "largest",
    "load",
    "load_design",
    "load_motion",
    "plan",
    "repair",
    "repair_clip",
    "sensitivity",
    "simulate",
    "with_feedback",
]


def __dir__() -> list[str]:
    """The public names, those that are imported when they are used among them."""
    return [*__all__, "__all__", "__doc__", "__name__", "__path__"]


def __getattr__(name: str) -> Any:
    if name not in _LATER:
        raise AttributeError(f"module 'llsrbm' has no attribute {name!r}")
    value = getattr(import_module(_LATER[name]), name)
    globals()[name] = value
    return value
