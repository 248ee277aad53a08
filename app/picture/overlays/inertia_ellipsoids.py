"""Inertia as a body that has it: planned, simulated, and one to compare with."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np
import viser
from numpy.typing import NDArray

from app.motion import colours
from app.motion.clip import AnimationChannel, Track
from app.motion.colours import Rgb
from app.picture.drawing import Group, Meaning, Overlay
from app.picture.picture import Picture
from llsrbm.arrays import Array

_SIDES = 48  # of a ring
_THICK = 2.0  # pixels

_PLANNED, _SRBM, _WHOLE, _HELD_ARMS = "planned", "srbm", "whole", "held_arms"  # names of nodes
_COLOURS = {
    _PLANNED: colours.PLANNED,
    _SRBM: colours.REFERENCE,
    _WHOLE: colours.SIMULATED,
    _HELD_ARMS: colours.REFERENCE,
}


class InertiaEllipsoids(Overlay):
    """Ellipsoids of the plan; beside a plan SRBM's, beside a simulation its body's.

    For robots with arms the one to compare with is that of the same postures with the arms held.
    """

    name = "ellipsoids"
    root = "/ellipsoid"
    group = Group.INERTIA
    title = "Inertia ellipsoids"
    hint = (
        "The uniform solid ellipsoid of the robot's mass that has its inertia about the CoM: the "
        "plan's, and beside it SRBM's or, once simulated, the whole body's; of a robot with arms "
        "also as if they were held."
    )
    place = 10
    at_first = True
    common = True
    parts = frozenset({"robot", "planned", "simulated", "row"})

    _drawn: dict[str, Ellipsoid] | None = None
    _there: Collection[str] = ()

    @classmethod
    def swatch(cls, picture: Picture) -> Sequence[Rgb]:
        if picture.rollout is None:
            return colours.PLANNED, colours.REFERENCE
        armed = picture.robot is not None and picture.robot.arms
        third = (colours.REFERENCE,) if armed else ()
        return colours.PLANNED, colours.SIMULATED, *third

    @classmethod
    def legend(cls, picture: Picture) -> Sequence[Meaning]:
        found = [(colours.PLANNED, "inertia as planned")]
        if picture.rollout is None:
            return [*found, (colours.REFERENCE, "inertia of SRBM")]
        found.append((colours.SIMULATED, "inertia of the whole body"))
        armed = picture.robot is not None and picture.robot.arms
        return [*found, (colours.REFERENCE, "with the arms held")] if armed else found

    def draw(self, picture: Picture) -> Sequence[AnimationChannel]:
        self._there = ()
        if picture.row:  # each of them has one (`app.picture.row`)
            return ()
        _, planned, solid = picture.motion
        simulated = picture.simulated
        if self._drawn is None:
            self._drawn = {
                name: Ellipsoid(self.scene, f"/ellipsoid/{name}", colour)
                for name, colour in _COLOURS.items()
            }
        frames = planned.frames
        tracks = [(frames, _PLANNED, frames.inertia_axes, frames.inertia_wxyz)]
        if simulated is not None:
            tracks.append((simulated, _WHOLE, simulated.inertia_axes, simulated.inertia_wxyz))
        if solid.held_arms is not None:
            tracks.append((solid, _HELD_ARMS, *solid.held_arms))
        elif simulated is None:
            axes = np.broadcast_to(planned.rigid_axes, frames.com.shape)
            tracks.append((frames, _SRBM, axes, planned.rigid_wxyz))
        self._there = {name for _, name, _, _ in tracks}
        return [
            AnimationChannel(of.time, (self._drawn[name].track(of.com, wxyz, axes),))
            for of, name, axes, wxyz in tracks
        ]

    def show(self, *, visible: bool) -> None:
        for name, ellipsoid in (self._drawn or {}).items():
            ellipsoid.show(visible=visible and name in self._there)


class Ellipsoid:
    """Rings about the principal axes; a surface would lie over the robot and hide what is white."""

    def __init__(self, scene: viser.SceneApi, name: str, colour: Rgb) -> None:
        self.frame = scene.add_frame(name, show_axes=False)
        wires = scene.add_line_segments(
            f"{name}/wires", _rings(), colour, thickness=_THICK, thickness_units="screen"
        )
        self._nodes: tuple[str, ...] = (wires.name,)

    def track(self, position: Array, wxyz: Array, axes: Array) -> Track:
        """Its centre at `position` (F, 3) m, its semi-axes `axes` (F, 3) m along `wxyz` (F, 4)."""
        return Track(self._nodes, position, wxyz, axes)

    def show(self, *, visible: bool) -> None:
        self.frame.visible = visible


def _rings() -> NDArray[np.float32]:
    """The sides (3 n, 2, 3) of circles in the planes of the axes, of radius 1."""
    angle = np.linspace(0.0, 2 * np.pi, _SIDES + 1)
    circle = np.stack([np.cos(angle), np.sin(angle), np.zeros(_SIDES + 1)], axis=1)
    sides = np.stack([circle[:-1], circle[1:]], axis=1)
    return np.concatenate([np.roll(sides, axis, axis=2) for axis in range(3)]).astype(np.float32)
