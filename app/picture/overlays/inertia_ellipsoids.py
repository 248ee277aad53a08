"""Inertia as a body that has it: planned, constant (SRBM's) and simulated."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import viser

from app.motion import colours
from app.motion.clip import AnimationChannel, Track
from app.motion.colours import Rgb
from app.motion.frames import Frames
from app.picture.drawing import Key, Overlay
from app.picture.picture import Picture
from llsrbm.mechanics import Array

_OUTSIDE = 1.004  # a wireframe must lie just outside of a surface to be seen
_SUBDIVISIONS = 2  # of an icosahedron: 320 triangles


class InertiaEllipsoids(Overlay):
    """Of the plan, with a surface; of SRBM beside a plan, of the whole body beside a simulation.

    Surfaces so close to each other would hide one another in turn, so only one has one.
    """

    name = "ellipsoids"
    title = "Inertia ellipsoids"
    hint = "The uniform solid ellipsoid of the robot's mass that has its inertia about the CoM."
    place = 10
    at_first = True

    _drawn: tuple[_Ellipsoid, _Ellipsoid, _Ellipsoid] | None = None
    _simulated = False

    @classmethod
    def keys(cls, picture: Picture) -> Sequence[Key]:
        second = (
            Key(colours.RIGID, "the same of SRBM's inertia, which is constant")
            if picture.rollout is None
            else Key(colours.SIMULATED, "the same of the simulated whole body's inertia")
        )
        first = "ellipsoid: uniform solid of the robot's mass and planned inertia"
        return [Key(colours.PLANNED, first), second]

    def draw(self, picture: Picture) -> Sequence[AnimationChannel]:
        _, planned, _ = picture.motion
        simulated = picture.simulated
        if self._drawn is None:
            self._drawn = (
                _Ellipsoid(self.scene, "/ellipsoid/planned", colours.PLANNED, surface=True),
                _Ellipsoid(self.scene, "/ellipsoid/srbm", colours.RIGID, surface=False),
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
    """A unit sphere, a wireframe with or without a translucent surface, turned and stretched."""

    def __init__(self, scene: viser.SceneApi, name: str, colour: Rgb, *, surface: bool) -> None:
        self._frame = scene.add_frame(name, show_axes=False)
        wires = scene.add_icosphere(
            f"{name}/wires",
            _OUTSIDE,
            colour,
            subdivisions=_SUBDIVISIONS,
            wireframe=True,
            opacity=0.35,
            cast_shadow=False,
            receive_shadow=False,
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
