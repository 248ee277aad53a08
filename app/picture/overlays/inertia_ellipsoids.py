"""Inertia as a body that has it: planned, constant (SRBM's) and simulated."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import viser
from numpy.typing import NDArray

from app.motion import colours
from app.motion.clip import Strand, Track
from app.motion.colours import Rgb
from app.motion.frames import Frames
from app.picture.drawing import Overlay
from app.picture.picture import Picture

Array = NDArray[np.float64]

_OUTSIDE = 1.004  # a wireframe must lie just outside of a surface to be seen
_SUBDIVISIONS = 2  # of an icosahedron: 320 triangles


class InertiaEllipsoids(Overlay):
    """Of the plan, with a surface; of SRBM beside a plan, of the whole body beside a simulation.

    Surfaces so close to each other would hide one another in turn, so only one has one.
    """

    name = "ellipsoids"
    title = "Inertia ellipsoids"
    hint = "The uniform solid ellipsoid of the robot's mass that has its inertia about the CoM."
    at_first = True

    def __init__(self, scene: viser.SceneApi) -> None:
        """See `Drawing`."""
        super().__init__(scene)
        self._planned: _Ellipsoid | None = None
        self._rigid: _Ellipsoid | None = None
        self._whole: _Ellipsoid | None = None
        self._simulated = False

    def draw(self, picture: Picture) -> Sequence[Strand]:
        """See `Drawing.draw`."""
        planned, simulated = picture.planned, picture.simulated
        assert planned is not None
        if self._planned is None:
            add = self.scene
            self._planned = _Ellipsoid(add, "/ellipsoid/planned", colours.PLANNED, surface=True)
            self._rigid = _Ellipsoid(add, "/ellipsoid/srbm", colours.RIGID, surface=False)
            self._whole = _Ellipsoid(add, "/ellipsoid/whole", colours.SIMULATED, surface=False)
        assert self._rigid is not None
        assert self._whole is not None
        self._simulated = simulated is not None
        frames = planned.frames
        strands = [Strand(frames.time, (self._planned.of(frames),))]
        if simulated is not None:
            strands.append(Strand(simulated.time, (self._whole.of(simulated),)))
        else:
            axes = np.broadcast_to(planned.rigid_axes, frames.com.shape)
            track = self._rigid.track(frames.com, planned.rigid_wxyz, axes)
            strands.append(Strand(frames.time, (track,)))
        self.show(visible=True)
        return strands

    def show(self, *, visible: bool) -> None:
        """See `Drawing.show`."""
        for ellipsoid, shown in (
            (self._planned, True),
            (self._rigid, not self._simulated),
            (self._whole, self._simulated),
        ):
            if ellipsoid is not None:
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
