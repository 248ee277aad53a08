"""How far a plan is from the motion that it was made of."""

from __future__ import annotations

import numpy as np

from llsrbm.mechanics import interpolated
from llsrbm.motion.plan import Plan
from llsrbm.motion.sampling import foothold_knots
from llsrbm.repairing.begun import file_times
from llsrbm.repairing.request import Request
from llsrbm.repairing.result import Moved


def moved(request: Request, plan: Plan) -> Moved:
    """How far a plan's knots are from the motion at the same shares of its phases."""
    motion, robot = request.part.motion, request.part.motion.robot
    at = file_times(request, plan.phase_start, plan.time)
    turns = [k for k, name in enumerate(robot.joint_names) if name not in robot.sliding_joints]
    order = [plan.joint_names.index(name) for name in robot.joint_names]
    joints = plan.joint_position[:, order] - interpolated(at, motion.time, motion.joint_position)
    base = request.frame.back(plan.base_position)
    base = base - interpolated(at, motion.time, motion.base_position)
    # Even in time: knots are closer beside the phases' edges.
    share = np.gradient(plan.time) / plan.duration
    stood = request.part.footholds()
    knots = foothold_knots(plan)
    landed = [
        np.linalg.norm(
            request.frame.back(plan.foot_position[knots[place, leg], leg])[:2] - at_rest[:2]
        )
        for place, feet in enumerate(stood)
        for leg, at_rest in enumerate(feet)
        if place
    ]
    return Moved(
        joint_rms_rad=float(np.sqrt(share @ np.mean(joints[:, turns] ** 2, axis=1) / share.sum())),
        base_rms_m=float(np.sqrt(share @ np.sum(base**2, axis=1) / share.sum())),
        landing_m=float(max(landed)),
        durations_s=tuple(
            float(longer) for longer in np.diff(plan.phase_start) - np.diff(request.part.edges)
        ),
    )
