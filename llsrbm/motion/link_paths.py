"""The links of a URDF as a tree, each seen from its parent: what viewers of robots are moved by."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from llsrbm.mechanics import quaternions, rotation_matrices, sign_continuous
from llsrbm.robots.robot import Robot

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class LinkPath:
    """Where one link is over K instants, seen from its parent.

    Attributes:
        link, parent: names in the URDF; the root link's parent is `world`.
        moves: whether it does: a link behind a fixed joint does not.
        position: (K, 3) m and quat: (K, 4) w, x, y, z without jumps of sign, in the parent's frame;
            K = 1 for what does not move.
    """

    link: str
    parent: str
    moves: bool
    position: Array
    quat: Array


def link_paths(
    robot: Robot, body_position: Array, body_quat: Array, world: str = "world"
) -> Iterator[LinkPath]:
    """Every link of the URDF, parents first.

    Args:
        robot: whose.
        body_position: (K, B, 3) m and body_quat: (K, B, 4) w, x, y, z, as
            `llsrbm.look.visuals.forward_kinematics` gives them.
        world: what the root link's parent is called.
    """
    model = robot.model
    rotation = rotation_matrices(body_quat)
    for frame in model.frames:
        if frame.type != pin.FrameType.BODY:
            continue
        parent = model.frames[model.frames[frame.parentFrame].parentFrame]
        R, p = _placed(frame, body_position, rotation)
        if parent.type != pin.FrameType.BODY:
            yield LinkPath(frame.name, world, True, p, sign_continuous(quaternions(R)))
        elif parent.parentJoint == frame.parentJoint:
            seen = parent.placement.actInv(frame.placement)
            yield LinkPath(
                frame.name,
                parent.name,
                False,
                seen.translation[None],
                quaternions(seen.rotation[None]),
            )
        else:
            R_parent, p_parent = _placed(parent, body_position, rotation)
            back = np.swapaxes(R_parent, -1, -2)
            yield LinkPath(
                frame.name,
                parent.name,
                True,
                np.einsum("kij,kj->ki", back, p - p_parent),
                sign_continuous(quaternions(back @ R)),
            )


def _placed(frame: pin.Frame, position: Array, rotation: Array) -> tuple[Array, Array]:
    """Attitudes (K, 3, 3) and origins (K, 3) of a frame in the world."""
    body = frame.parentJoint - 1
    R = rotation[:, body]
    return R @ frame.placement.rotation, position[:, body] + R @ frame.placement.translation
