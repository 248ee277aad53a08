"""Several jumps in a row, begun from whole-body plans of each by itself.

Each jump of a row takes off where the one before landed, so the plans of its jumps, one after the
other and each moved to where the one before it ended, are nearly a plan of it: the robot comes to
rest in between, which no row of the problem asks for.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from llsrbm.arrays import Array
from llsrbm.mechanics import quaternion_product, quaternions_about_z, turns_about_z
from llsrbm.motion.plan import Plan
from llsrbm.planning.problem.task import Task

_PLACES = ("com", "base_position", "foot_position", "contact_point", "leg_com")
_DIRECTIONS = (
    *("com_velocity", "angular_velocity", "linear_momentum", "angular_momentum"),
    "contact_force",
)
_ATTITUDES = ("base_quat", "foot_quat")
_OWN = (
    *("joint_position", "joint_velocity", "joint_torque", "joint_torque_limit"),
    "foot_in_hip",
)
_PHASES = 3  # of a single jump: take-off, flight, landing; two of them go on into the next one


def joined(task: Task, empty: Plan, parts: Sequence[Plan]) -> Plan:
    """A motion through the jumps of a task.

    Args:
        task: of jumps in a row.
        empty: its plan without knots (`unplanned`).
        parts: a refined plan of each jump by itself, from the world's origin.
    """
    columns: dict[str, list[Array]] = {}
    begins = 0.0
    for number, part in enumerate(parts):
        last = number == len(parts) - 1
        keeps = slice(None) if last else slice(-1)  # the next one begins there
        place = task.places[number]
        R, turn = turns_about_z(place.heading), quaternions_about_z(place.heading)
        own = {name: getattr(part, name) @ R.T + place.origin for name in _PLACES}
        own |= {name: getattr(part, name) @ R.T for name in _DIRECTIONS}
        own |= {
            name: quaternion_product(
                np.broadcast_to(turn, getattr(part, name).shape), getattr(part, name)
            )
            for name in _ATTITUDES
        }
        if task.foot.is_point:
            own["foot_quat"] = part.foot_quat
        own |= {name: _in_order(part, name, empty) for name in _OWN}
        own["inertia"] = R @ part.inertia @ R.T
        own["time"] = begins + part.time
        own["phase"] = (_PHASES - 1) * number + part.phase
        for name, values in own.items():
            columns.setdefault(name, []).append(values[keeps])
        begins += part.duration
    found: dict[str, Any] = {name: np.concatenate(values) for name, values in columns.items()}
    return replace(empty, refinement=parts[0].refinement, **found)


def _in_order(part: Plan, name: str, empty: Plan) -> Array:
    values: Array = getattr(part, name)
    if name == "foot_in_hip":
        return values
    return values[:, [part.joint_names.index(joint) for joint in empty.joint_names]]
