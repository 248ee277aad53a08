"""A robot that carries something on its trunk, which moves with it: a point mass."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pinocchio as pin

from llsrbm.errors import InputError
from llsrbm.robots.robot import Robot
from llsrbm.robots.urdf import BASE_JOINT

HEAVIEST = 0.5  # share of the robot's own mass


@lru_cache(maxsize=16)
def with_payload(robot: Robot, payload: Sequence[float]) -> Robot:
    """The robot with a payload: () none, else kg and place (m) in the trunk's frame.

    It is the same object each time. Its default posture is that of the robot alone. Raises
    `InputError`: it weighs more than half of the robot.
    """
    if not payload:
        return robot
    mass, *place = payload
    if mass > HEAVIEST * robot.mass:
        raise InputError(
            f"payload: {mass:g} kg; {robot.name} takes up to {HEAVIEST * robot.mass:.4g} kg, half "
            "of its own mass"
        )
    model = robot.model.copy()
    model.inertias[BASE_JOINT] += pin.Inertia(mass, np.array(place), np.zeros((3, 3)))
    data = model.createData()
    pin.ccrba(model, data, robot.posture, np.zeros(model.nv))
    other = replace(
        robot,
        model=model,
        chains=replace(robot.chains, model=model),
        mass=float(data.Ig.mass),
        com=np.array(data.com[0]),
        inertia=np.array(data.Ig.inertia),
    )
    trunk = other.trunk
    vars(other)["fit"] = replace(
        robot.fit,
        total_mass=other.mass,
        trunk_mass=float(trunk.mass),
        trunk_com=np.array(trunk.lever),
        trunk_inertia=np.array(trunk.inertia),
    )
    return other
