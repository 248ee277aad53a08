"""A robot's links as nodes of a scene: solid, or translucent as a ghost."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import viser

from app.motion.clip import Track
from app.motion.colours import Rgb, linear
from app.motion.frames import Frames
from llsrbm.robots import Robot
from llsrbm.robots.visuals import LinkVisual, forward_kinematics, link_visuals

_GHOST_OPACITY = 0.25


@lru_cache(maxsize=16)
def meshes(
    robot: Robot, *, fine: bool = False, ghost: Rgb | None = None
) -> tuple[tuple[str, int, bytes], ...]:
    """(link, body index, glTF) of each body, made once for all tabs; ghosts in one colour."""
    from trimesh import Trimesh
    from trimesh.visual import TextureVisuals
    from trimesh.visual.material import PBRMaterial

    def glb(visual: LinkVisual) -> bytes:
        if ghost is None:
            solid: bytes = visual.mesh().export(file_type="glb")
            return solid
        material = PBRMaterial(
            baseColorFactor=[*linear(ghost), _GHOST_OPACITY],
            metallicFactor=0.0,
            roughnessFactor=0.9,
            alphaMode="BLEND",
        )
        translucent: bytes = Trimesh(
            vertices=visual.vertices,
            faces=visual.faces,
            vertex_normals=visual.normals,
            visual=TextureVisuals(material=material),
            process=False,
        ).export(file_type="glb")
        return translucent

    visuals = link_visuals(robot, coarse=not fine)
    return tuple((visual.link, visual.joint_id - 1, glb(visual)) for visual in visuals)


class RobotNodes:
    """One drawn robot, in its default posture until it is moved."""

    def __init__(
        self,
        client: viser.ClientHandle,
        robot: Robot,
        name: str,
        *,
        ghost: Rgb | None = None,
        fine: bool = False,
    ) -> None:
        """Visible, unless a ghost.

        Args:
            client: whose scene.
            robot: what to draw.
            name: of the node above the links.
            ghost: translucent, in this colour.
            fine: with all triangles. A browser without a graphics processor draws the coarse ones
                in half the time, and every page opens sooner with them; ghosts never need more.
        """
        self._client = client
        self._robot = robot
        self._name = name
        self._ghost = ghost
        self._frame = client.scene.add_frame(name, show_axes=False, visible=ghost is None)
        self._bodies: dict[str, int] = {}
        self.nodes: dict[str, Any] = {}
        self._add(fine=fine)

    def refine(self) -> None:
        """Draw all triangles from now on."""
        self._add(fine=True)

    def track(self, frames: Frames) -> list[Track]:
        """Every body's way through a motion of this robot."""
        return [
            Track((name,), frames.body_position[:, body], frames.body_wxyz[:, body])
            for name, body in self._bodies.items()
        ]

    def show(self, *, visible: bool) -> None:
        """Show or hide."""
        self._frame.visible = visible

    def remove(self) -> None:
        """Remove for good."""
        self._frame.remove()

    def _add(self, *, fine: bool) -> None:
        robot = self._robot
        position, wxyz = forward_kinematics(
            robot, robot.base_position[None], [[1.0, 0.0, 0.0, 0.0]], robot.posture[None, 7:]
        )
        for link, body, glb in meshes(robot, fine=fine, ghost=self._ghost):
            node = f"{self._name}/{link}"
            before = self.nodes.get(node)
            self._bodies[node] = body
            self.nodes[node] = self._client.scene.add_glb(
                node,
                glb,
                position=position[0, body] if before is None else before.position,
                wxyz=wxyz[0, body] if before is None else before.wxyz,
                cast_shadow=False,
                receive_shadow=False,
            )
