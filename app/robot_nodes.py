"""A robot's links as nodes of a scene: solid, or translucent as a ghost."""

from __future__ import annotations

from functools import lru_cache

import viser

from app import colours
from app.colours import Rgb
from app.frames import Frames
from llsrbm.robots import Robot
from llsrbm.robots.visuals import forward_kinematics, link_visuals

_GHOST_OPACITY = 0.22


@lru_cache(maxsize=8)
def _meshes(robot: Robot) -> tuple[tuple[str, int, bytes], ...]:
    """(link, body index, glTF) of each body, made once for all tabs."""
    return tuple(
        (visual.link, visual.joint_id - 1, visual.mesh().export(file_type="glb"))
        for visual in link_visuals(robot)
    )


@lru_cache(maxsize=8)
def _ghost_meshes(robot: Robot) -> tuple[tuple[str, int, bytes], ...]:
    """The same bodies in one translucent colour."""
    from trimesh import Trimesh
    from trimesh.visual import TextureVisuals
    from trimesh.visual.material import PBRMaterial

    material = PBRMaterial(
        baseColorFactor=[*_linear(colours.PLANNED), _GHOST_OPACITY],
        metallicFactor=0.0,
        roughnessFactor=0.9,
        alphaMode="BLEND",
    )
    return tuple(
        (
            visual.link,
            visual.joint_id - 1,
            Trimesh(
                vertices=visual.vertices,
                faces=visual.faces,
                vertex_normals=visual.normals,
                visual=TextureVisuals(material=material),
                process=False,
            ).export(file_type="glb"),
        )
        for visual in link_visuals(robot)
    )


def _linear(colour: Rgb) -> list[float]:
    """A colour of a style sheet as glTF has it: proportional to light, not to what an eye sees."""
    return [(c / 255) ** 2.2 for c in colour]


class RobotNodes:
    """One drawn robot, in its default posture until it is moved."""

    def __init__(
        self, client: viser.ClientHandle, robot: Robot, name: str, *, ghost: bool = False
    ) -> None:
        """Visible, unless a ghost.

        Args:
            client: whose scene.
            robot: what to draw.
            name: of the node above the links.
            ghost: translucent, in the colour of what is planned.
        """
        position, wxyz = forward_kinematics(
            robot, robot.base_position[None], [[1.0, 0.0, 0.0, 0.0]], robot.posture[None, 7:]
        )
        scene = client.scene
        self._frame = scene.add_frame(name, show_axes=False, visible=not ghost)
        self._visible = not ghost
        self._bodies = [
            (
                body,
                scene.add_glb(
                    f"{name}/{link}", glb, position=position[0, body], wxyz=wxyz[0, body]
                ),
            )
            for link, body, glb in (_ghost_meshes if ghost else _meshes)(robot)
        ]

    def move(self, frames: Frames, frame: int) -> None:
        """Put every body where it is in a frame."""
        if not self._visible:
            return
        for body, handle in self._bodies:
            handle.position = frames.body_position[frame, body]
            handle.wxyz = frames.body_wxyz[frame, body]

    def show(self, *, visible: bool) -> None:
        """Show or hide; follow with `move`."""
        self._visible = visible
        self._frame.visible = visible

    def remove(self) -> None:
        """Remove for good."""
        self._frame.remove()
