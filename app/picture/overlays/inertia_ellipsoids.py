"""Inertia as a body that has it: planned, constant (SRBM's) and simulated."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import viser
from numpy.typing import NDArray

from app.motion import colours
from app.motion.clip import AnimationChannel, Track
from app.motion.colours import Rgb
from app.motion.frames import Frames
from app.picture.drawing import Group, Overlay
from app.picture.picture import Picture
from llsrbm.mechanics import Array

_SUBDIVISIONS = 2  # of an icosahedron: 320 triangles
_OUTSIDE = 1.004  # rings must lie just outside of a surface to be seen
_SIDES = 48  # of a ring
_THIN = 1.2  # pixels


class InertiaEllipsoids(Overlay):
    """Of the plan, with a surface; of SRBM beside a plan, of the whole body beside a simulation.

    Surfaces so close to each other would hide one another in turn, so only one has one.
    """

    name = "ellipsoids"
    group = Group.INERTIA
    title = "Inertia ellipsoids"
    hint = (
        "The uniform solid ellipsoid of the robot's mass that has its inertia about the CoM: the "
        "plan's, and beside it SRBM's or, once simulated, the whole body's."
    )
    place = 10
    at_first = True

    _drawn: tuple[_Ellipsoid, _Ellipsoid, _Ellipsoid] | None = None
    _simulated = False

    @classmethod
    def swatch(cls, picture: Picture) -> Sequence[Rgb]:
        second = colours.REFERENCE if picture.rollout is None else colours.SIMULATED
        return colours.PLANNED, second

    def draw(self, picture: Picture) -> Sequence[AnimationChannel]:
        _, planned, _ = picture.motion
        simulated = picture.simulated
        if self._drawn is None:
            self._drawn = (
                _Ellipsoid(self.scene, "/ellipsoid/planned", colours.PLANNED, surface=True),
                _Ellipsoid(self.scene, "/ellipsoid/srbm", colours.REFERENCE, surface=False),
                _Ellipsoid(self.scene, "/ellipsoid/whole", colours.SIMULATED, surface=False),
            )
        solid, rigid, whole = self._drawn
        self._simulated = simulated is not None
        frames = planned.frames
        channels = [AnimationChannel(frames.time, (solid.of(frames),))]
        if simulated is not None:
            channels.append(AnimationChannel(simulated.time, (whole.of(simulated),)))
        else:
            axes = np.broadcast_to(planned.rigid_axes, frames.com.shape)
            track = rigid.track(frames.com, planned.rigid_wxyz, axes)
            channels.append(AnimationChannel(frames.time, (track,)))
        return channels

    def show(self, *, visible: bool) -> None:
        there = True, not self._simulated, self._simulated
        for ellipsoid, shown in zip(self._drawn or (), there, strict=False):
            ellipsoid.show(visible=visible and shown)


class _Ellipsoid:
    """Rings about the principal axes, with or without a translucent surface."""

    def __init__(self, scene: viser.SceneApi, name: str, colour: Rgb, *, surface: bool) -> None:
        self._frame = scene.add_frame(name, show_axes=False)
        wires = scene.add_line_segments(
            f"{name}/wires", _rings(), colour, thickness=_THIN, thickness_units="screen"
        )
        self._nodes: tuple[str, ...] = (wires.name,)
        if surface:
            inside = scene.add_icosphere(
                f"{name}/surface",
                1.0,
                colour,
                subdivisions=_SUBDIVISIONS,
                opacity=0.17,
                # Far cheaper than the usual one, and as good on what is all but clear.
                material="toon3",
                cast_shadow=False,
                receive_shadow=False,
            )
            self._nodes = (wires.name, inside.name)

    def of(self, frames: Frames) -> Track:
        """Over a motion."""
        return self.track(frames.com, frames.inertia_wxyz, frames.inertia_axes)

    def track(self, position: Array, wxyz: Array, axes: Array) -> Track:
        """Its centre at `position` (F, 3) m, its semi-axes `axes` (F, 3) m along `wxyz` (F, 4)."""
        return Track(self._nodes, position, wxyz, axes)

    def show(self, *, visible: bool) -> None:
        self._frame.visible = visible


def _rings() -> NDArray[np.float32]:
    """The sides (3 n, 2, 3) of circles in the planes of the axes, of radius 1."""
    angle = np.linspace(0.0, 2 * np.pi, _SIDES + 1)
    circle = _OUTSIDE * np.stack([np.cos(angle), np.sin(angle), np.zeros(_SIDES + 1)], axis=1)
    sides = np.stack([circle[:-1], circle[1:]], axis=1)
    return np.concatenate([np.roll(sides, axis, axis=2) for axis in range(3)]).astype(np.float32)
