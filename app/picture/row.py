"""Robots beside each other, each with its name, its inertia ellipsoid and what stands around it.

They stand across the direction from which a row is looked at first, so far from each other that
nothing of one is ever where another has been; the one that is shown is where its motion has it. A
motion of a file that begins far away is brought beside it.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import count
from typing import Any

import numpy as np
import viser

from app.motion.clip import AnimationChannel, CameraTarget, Track
from app.motion.colours import Rgb
from app.picture import gltf
from app.picture.blocks import Blocks, standing_track
from app.picture.blocks import place as place_box
from app.picture.bounds import around, corners, outermost
from app.picture.drawing import Drawing
from app.picture.overlays.inertia_ellipsoids import Ellipsoid, InertiaEllipsoids
from app.picture.picture import Picture, Standing
from app.picture.robot_nodes import RobotNodes, RobotShelf, shadow_track
from llsrbm.arrays import Array
from llsrbm.motion.block import Block

_FREE = 0.25  # m between what two neighbours sweep
_ABOVE = 0.12  # m from the highest that one of them gets to their names
_FAR = 0.5  # m between where two motions begin, from which on one is brought beside the other
_EVERY = 4  # frames between those whose room is measured
_LETTERS = 0.17  # height of names, in heights of a standing robot's CoM
_WIDEST = 1.6  # of a name, in its letters' height and its share of the room to the next

# Seen from ahead, the right and above; turning over, from the right.
_AHEAD, _ASIDE = (1.0, -0.35, 0.42), (0.15, -1.0, 0.22)


class Row(Drawing):
    """All of it but the robot that is shown, which has its name and its ellipsoid from here."""

    parts = frozenset({"row", "simulated", "planned", "layers", "fine", "prepared"})

    def __init__(self, scene: viser.SceneApi) -> None:
        super().__init__(scene)
        self._shelves: list[RobotShelf] = []  # by place
        self._robots: list[tuple[RobotShelf, RobotNodes]] = []  # those that are drawn
        self._ellipsoids: dict[Rgb, Ellipsoid] = {}
        self._labels: list[viser.LabelHandle] = []
        self._shadows: list[viser.GlbHandle] = []
        self._boxes: list[viser.BoxHandle] = []
        self._visible: list[Any] = []  # handles of what is drawn but for robots
        self._points: Array = np.zeros((0, 3))
        self._turns = False

    def draw(self, picture: Picture) -> Sequence[AnimationChannel]:
        row = picture.row
        self._hide()
        self._robots, self._visible = [], []
        if not row or picture.planned is None:
            self._points = np.zeros((0, 3))
            return ()
        self._turns = bool(picture.planned.plan.jump.pitch)
        rooms = [_room(each) for each in row]
        shown = next(k for k, each in enumerate(row) if each.frames is picture.solid)
        begins = np.array([each.frames.com[0] for each in row])
        shifts = _shifts(rooms, begins, shown, 0 if self._turns else 1)
        self._points = np.concatenate(
            [outermost(room) + by for room, by in zip(rooms, shifts, strict=True)]
        )
        top = float(self._points[:, 2].max()) + _ABOVE
        gaps = np.linalg.norm(np.diff(shifts, axis=0), axis=1)
        room = float(gaps.min(initial=np.ptp(self._points[:, :2], axis=0).max()))
        above = np.array([0.0, 0.0, 2 * _ABOVE])
        self._points = np.vstack([self._points, self._points + above])  # and the names
        channels: list[AnimationChannel] = []
        for place, (standing, by) in enumerate(zip(row, shifts, strict=True)):
            x, y = (standing.frames.com[0] + by)[:2]
            letters = min(_LETTERS * standing.robot.com[2], _WIDEST * room / len(standing.title))
            self._label(place, standing.title, (float(x), float(y), top), float(letters))
            if InertiaEllipsoids.name in picture.layers:
                channels.append(self._ellipsoid(standing, by))
            if any(by):
                channels.append(self._robot(place, standing, by, picture))
        channels += self._blocks([(each, by) for each, by in zip(row, shifts, strict=True)])
        return channels

    def _robot(
        self, place: int, standing: Standing, by: Array, picture: Picture
    ) -> AnimationChannel:
        while len(self._shelves) <= place:
            names = map(f"/row/{len(self._shelves)}-{{}}".format, count(1))
            self._shelves.append(RobotShelf(self.scene, names))
        shelf, frames = self._shelves[place], standing.frames
        nodes = shelf.take(standing.robot, fine=picture.fine)
        self._robots.append((shelf, nodes))
        shadow = self._made(self._shadows, place, self._add_shadow)
        ground = picture.ground
        tracks = [
            *nodes.track(frames),
            shadow_track(shadow.name, standing.robot, frames, standing.blocks, ground),
        ]
        return AnimationChannel(frames.time, tuple(_shifted(track, by) for track in tracks))

    def _ellipsoid(self, standing: Standing, by: Array) -> AnimationChannel:
        colour, frames = standing.colour, standing.inertia
        if colour not in self._ellipsoids:
            name = f"/row-inertia/{len(self._ellipsoids)}"
            self._ellipsoids[colour] = Ellipsoid(self.scene, name, colour)
        drawn = self._ellipsoids[colour]
        self._visible.append(drawn.frame)
        track = drawn.track(frames.com, frames.inertia_wxyz, frames.inertia_axes)
        return AnimationChannel(frames.time, (_shifted(track, by),))

    def _label(
        self, place: int, title: str, at: tuple[float, float, float], letters: float
    ) -> None:
        label = self._made(self._labels, place, self._add_label)
        label.text, label.position, label.font_scene_height = title, at, letters

    def _blocks(self, standing: Sequence[tuple[Standing, Array]]) -> list[AnimationChannel]:
        channels = []
        placed = [(each, by, block) for each, by in standing if any(by) for block in each.blocks]
        for number, (each, by, block) in enumerate(placed):
            box = self._made(self._boxes, number, self._add_box)
            moved: Block = replace(block, centre=block.centre + by)
            place_box(box, moved)
            track = standing_track(box.name, moved, each.frames.time)
            channels.append(AnimationChannel(each.frames.time, (track,)))
        return channels

    # ---- nodes

    def _made(self, handles: list[Any], number: int, make: Callable[[int], Any]) -> Any:
        while len(handles) <= number:
            handles.append(make(len(handles)))
        self._visible.append(handles[number])
        return handles[number]

    def _add_label(self, number: int) -> viser.LabelHandle:
        return self.scene.add_label(
            f"/row-name/{number}", "", anchor="bottom-center", font_size_mode="scene"
        )

    def _add_shadow(self, number: int) -> viser.GlbHandle:
        name = f"/row-below/{number}"
        return self.scene.add_glb(name, gltf.soft_disc(), cast_shadow=False, receive_shadow=False)

    def _add_box(self, number: int) -> viser.BoxHandle:
        return Blocks.add(self.scene, f"/row-box/{number}")

    def _hide(self) -> None:
        for handle in self._visible:
            handle.visible = False
        for shelf in self._shelves:
            shelf.show_only(())

    def show(self, *, visible: bool) -> None:
        if not visible:
            self._hide()
            return
        for handle in self._visible:
            handle.visible = True
        for shelf, nodes in self._robots:
            shelf.show_only((nodes,))

    def seen_by(self, target: CameraTarget | None) -> CameraTarget | None:
        """A camera's target, with all of the row if there is one."""
        if target is None or not len(self._points):
            return target
        points = np.concatenate([target.points, self._points])
        return replace(target, points=points, direction=_ASIDE if self._turns else _AHEAD)


def _room(standing: Standing) -> Array:
    """(P, 3) m: points between which a robot moves, and what stands around it is."""
    frames = standing.frames
    poses = frames.body_position[::_EVERY], frames.body_wxyz[::_EVERY]
    swept = around(standing.robot, *poses).reshape(-1, 3)
    return np.concatenate([swept, *(corners(block, np.inf) for block in standing.blocks)])


def _shifts(rooms: Sequence[Array], begins: Array, fixed: int, axis: int) -> list[Array]:
    """(3,) m for each robot, from the room (P, 3) m that each sweeps, but for one that stays.

    `begins`: (n, 3) m, where their CoMs are at first.
    """
    low, high = (np.array([end(room[:, axis]) for room in rooms]) for end in (np.min, np.max))
    # From one to the next, as much as the right side of one and the left side of the next need.
    gaps = high[:-1] - low[1:] + _FREE
    places = np.concatenate([[0.0], np.cumsum(gaps)])
    along = np.zeros((len(rooms), 3))
    along[:, axis] = places - places[fixed]
    across = begins[fixed, 1 - axis] - begins[:, 1 - axis]
    along[:, 1 - axis] = np.where(np.abs(across) > _FAR, across, 0.0)
    return list(along)


def _shifted(track: Track, by: Array) -> Track:
    return replace(track, position=track.position + by)
