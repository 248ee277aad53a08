"""The cost of a whole-body motion: roughness, torque, duration, distance from the first stage.

Widths say by what something may be off for a cost of 1 a knot, which `WEIGHTS` weigh.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import casadi as ca
import numpy as np

from llsrbm.planning.whole_body.interval import turned
from llsrbm.planning.whole_body.sizes import NODES, Sizes

SCALE = 1e-3  # of the whole cost
WIDTHS = {
    "position": 0.05,
    "attitude": 0.1,
    "joint_position": 0.3,
    "velocity": 0.5,
    "omega": 1.0,
    "joint_velocity": 3.0,
    "acceleration": 10.0,
    "omega_rate": 30.0,
    "joint_acceleration": 200.0,
    "steep": 100.0,  # rad/s2, of joints between the nodes
}
SLIDE = 0.2  # m of a joint that slides for a rad of one that turns
LEVEL = 0.05  # half the sine, about, of the angle by which a base leans
TIME = 0.1  # s
ROUNDED = 0.01  # cost below which that of an offset is rounded


def of_knot(
    state: Mapping[str, Any], near: Mapping[str, Any], weight: Mapping[str, Any], sizes: Sizes
) -> Any:
    """Cost of a knot's state: nearness to what is `near`, level, slow, near to standing; `near`
    has the default `posture`, too.
    """
    width = _widths(sizes)
    off = {name: state[name] - near[name] for name in width if name in state}
    off["attitude"] = turned(state["quat"], near["quat"])
    # A knot stands for two of the plan's, as its interval does.
    cost = weight["near"] * len(NODES) * sum(ca.sumsqr(v / width[n]) for n, v in off.items())
    cost += weight["level"] * ca.sumsqr((state["quat"][1:3] - near["level"]) / LEVEL)
    cost += weight["turning"] * ca.sumsqr(state["omega"] / width["omega"])
    cost += weight["joint_speed"] * ca.sumsqr(state["joint_velocity"] / width["joint_velocity"])
    standing = state["joint_position"] - near["posture"]
    return cost + weight["posture"] * ca.sumsqr(standing / width["joint_position"])


def of_offset(offset: Any, wanted: Any, price: Any) -> Any:
    """Cost of what is wanted and not done: it grows evenly with the distance between both.

    What it is where it does not count is zero.
    """
    distance = ca.sqrt(ca.sumsqr(price * (wanted - offset)) + ROUNDED**2)
    return distance - ROUNDED + ca.sumsqr(offset)


def of_durations(durations: Any, weight: Mapping[str, Any]) -> Any:
    """Cost of the phases' durations, s."""
    return weight["time"] * ca.sumsqr(durations / TIME)


def of_interval(
    nodes: Sequence[Mapping[str, Any]],
    loads: Sequence[Any],
    standing: int,
    weight: Mapping[str, Any],
    sizes: Sizes,
) -> Any:
    """Cost of the controls at both nodes, forces in units of `Sizes.unit_force`; `loads`: their
    torques, as shares of the drives'.
    """
    width = _widths(sizes)
    cost = weight["torque"] * sum(map(ca.sumsqr, loads))
    rates = {
        "acceleration": "acceleration",
        "omega_rate": "acceleration",
        "joint_acceleration": "joint_acceleration",
    }
    for node in nodes:
        for name, cause in rates.items():
            cost += weight[cause] * ca.sumsqr(node[name] / width[name])
        if standing:
            even = ca.repmat(ca.DM([0, 0, sizes.legs / standing]), standing * sizes.corners)
            cost += weight["force"] * ca.sumsqr(node["force"] - even)
    steep = {name: nodes[1][name] - nodes[0][name] for name in nodes[0]}
    cost += weight["steep_joints"] * ca.sumsqr(steep["joint_acceleration"] / width["steep"])
    for name in ("acceleration", "omega_rate"):
        cost += weight["steep_base"] * ca.sumsqr(steep[name] / width[name])
    return cost + weight["steep_force"] * ca.sumsqr(steep["force"])


def _widths(sizes: Sizes) -> dict[str, Any]:
    """Name -> width, a scalar or (J,)."""
    slides = sizes.slides
    if not slides.any():
        return dict(WIDTHS)
    unit = ca.DM(np.where(slides, SLIDE, 1.0))
    of_joints = {name for name in WIDTHS if name.startswith("joint") or name == "steep"}
    return {name: width * unit if name in of_joints else width for name, width in WIDTHS.items()}
