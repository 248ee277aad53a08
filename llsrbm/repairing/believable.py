"""Jumps near which there is no motion that can be done, told before one is sought for a minute.

They are far beyond a robot's stops or its usual jumps: mostly numbers in another order or unit.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from llsrbm.mechanics import tilt
from llsrbm.number_text import degrees
from llsrbm.repairing.part import UPSIDE_DOWN, NoJump, Part
from llsrbm.repairing.request import Request
from llsrbm.robots.robot import Robot

FAR_BEYOND = 0.3  # rad or m beyond a stop, in half of the frames; repairs move joints by 0.15 rad
# Times as much as the usual jumps of a robot's file: a flight turns by no more than a full turn.
MOST_TURNED, MOST_LED = 2.0, 3.0


def check_states(part: Part, robot: Robot) -> None:
    """Raise `NoJump` of a part whose states are far from any that can be."""
    _check_upright(part)
    _check_joints(part, robot)


def _check_upright(part: Part) -> None:
    motion = part.motion
    for when, at in zip(("begins", "ends"), part.edges[[0, -1]], strict=True):
        frame = int(np.argmin(np.abs(motion.time - at)))
        if tilt(motion.base_quat[frame]) > UPSIDE_DOWN:
            raise NoJump(f"the body is upside down as the jump {when}")


def _check_joints(part: Part, robot: Robot) -> None:
    motion = part.motion
    there = (motion.time >= part.edges[0]) & (motion.time <= part.edges[-1])
    lower, upper = robot.joint_stops
    usual = np.median(motion.joint_position[there], axis=0)
    beyond = np.maximum(lower - usual, usual - upper)
    joint = int(beyond.argmax())
    if beyond[joint] > FAR_BEYOND:
        raise NoJump(
            f"{robot.joint_names[joint]} is at {usual[joint]:.3g} in most of the jump, far beyond "
            f"its stops ({lower[joint]:.3g} to {upper[joint]:.3g}), and no motion near it keeps "
            "these"
        )


def check_amounts(request: Request, robot: Robot) -> None:
    """Raise `NoJump` of a request that is far beyond the robot's usual ones."""
    usual, places = robot.file.task, request.task.places
    turn = max(map(abs, usual.twist))
    way = math.hypot(*(max(map(abs, each)) for each in (usual.forward, usual.lateral)))
    for before, after in pairwise(places):
        turned = after.heading - before.heading
        led = float(np.linalg.norm((after.feet - before.feet).mean(axis=0)[:2]))
        if abs(turned) > MOST_TURNED * turn:
            raise NoJump(
                f"a flight turns the robot by {degrees(turned, 0)}, and flights of {robot.name} "
                f"by {degrees(MOST_TURNED * turn, 0)} at most are sought"
            )
        if led > MOST_LED * way:
            raise NoJump(
                f"a flight leads {led:.2f} m, and flights of {robot.name} of "
                f"{MOST_LED * way:.2f} m at most are sought"
            )
