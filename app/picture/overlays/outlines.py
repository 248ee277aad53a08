"""Outlines on the ground: the hull of what stands, and where feet can still land."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from app.motion import colours
from app.motion.clip import AnimationChannel, Track
from app.motion.colours import Rgb
from app.picture import gltf
from app.picture.drawing import Group, Overlay
from app.picture.picture import Picture
from llsrbm.analysis.landing_region import SIDES, expected_touchdown, landing_regions
from llsrbm.arrays import Array, BoolArray, IntArray
from llsrbm.look.shown_motion import ShownMotion
from llsrbm.planning.problem.placement import place_task

_WIDE, _THICK = 0.012, 0.003  # m, of an edge
_ABOVE = 0.004  # m; edges would flicker in the ground's own plane


class SupportPolygon(Overlay):
    """Its edges as bars: one a contact point, which leads to the next corner of the hull.

    A contact point that is no corner has a bar without a length; so the polygon may change its
    shape although nodes of a clip can only be moved, turned and stretched.
    """

    name = "support"
    group = Group.FOOTHOLDS
    title = "Support polygon"
    hint = "Convex hull of the contact points that stand: a robot at rest has its CoM above it."
    place = 110
    tints = (colours.SUPPORT,)
    root = "/hull"

    def tracks(self, picture: Picture, frames: ShownMotion) -> Sequence[Track]:
        count, legs, corners, _ = frames.contact_point.shape
        points = frames.contact_point.reshape(count, -1, 3) + np.array([0.0, 0.0, _ABOVE])
        standing = np.repeat(frames.contact, corners, axis=1)
        after = edges(points[..., :2], standing)
        there = after >= 0
        ends = np.take_along_axis(points, np.where(there, after, 0)[..., None], axis=1)
        along = np.where(there[..., None], ends - points, [1.0, 0.0, 0.0])
        length = np.linalg.norm(along, axis=2)
        names = self.nodes(gltf.bar(colours.SUPPORT), legs * corners)
        return _bars(names, points, along, length + _WIDE, there)


_DIGITS = 9  # of m: points on one spot are one, whatever rounding makes of them


def edges(points: Array, standing: BoolArray) -> IntArray:
    """The hull's edges, (F, C): of each of the points that stand the next corner, or -1.

    Against the clock, seen from above: `points` (F, C, 2) m, `standing` (F, C).
    """
    after = np.full(standing.shape, -1, dtype=np.int64)
    for frame, (places, counted) in enumerate(zip(points, standing, strict=True)):
        corners = _hull(places, np.flatnonzero(counted))
        if len(corners) > 1:
            after[frame, corners] = np.roll(corners, -1)
    return after


def _hull(points: Array, among: IntArray) -> list[int]:
    """Corners of the convex hull against the clock; the two ends of points on one line."""
    places = points[among].round(_DIGITS)
    if len(among) > 2:
        try:
            return [int(i) for i in among[ConvexHull(places).vertices]]
        except QhullError:  # on one line
            along = np.lexsort(places.T[::-1])
            among = among[along[[0, -1]]]
    return [int(i) for i in among]


_RATE = 30.0  # regions/s
_SWITCH = 1e-4  # s in which a region appears and goes


class LandingRegion(Overlay):
    """An outline a foot on the ground; of a complete simulation that is pushed or plans anew."""

    name = "landing-region"
    group = Group.FOOTHOLDS
    title = "Landing region"
    hint = (
        "After a push, or with replanning: where each foot can still land, by its leg's reach and "
        "the time that is left."
    )
    place = 90
    at_first = True
    parts = frozenset({"robot", "planned", "rollout"})
    root = "/within"

    @classmethod
    def swatch(cls, picture: Picture) -> Sequence[Rgb]:
        return [colours.REPLANNED] if _is_drawn(picture) else []

    def draw(self, picture: Picture) -> Sequence[AnimationChannel]:
        found = _outlines(picture)
        if found is None:
            return self.nothing()
        time, outline, there = found
        feet = outline.shape[1]
        names = self.nodes(gltf.bar(colours.REPLANNED), feet * SIDES, "side")
        tracks = []
        for foot in range(feet):
            points = outline[:, foot]
            sides = np.roll(points, -1, axis=1) - points
            length = np.linalg.norm(sides, axis=2)
            sides = np.where(length[..., None] > 0, sides, [1.0, 0.0, 0.0])
            mine = names[foot * SIDES : (foot + 1) * SIDES]
            tracks += _bars(
                mine, points + np.array([0.0, 0.0, _ABOVE]), sides, length, there[:, foot, None]
            )
        return [AnimationChannel(time, tuple(tracks))]


def _is_drawn(picture: Picture) -> bool:
    rollout = picture.rollout
    return rollout is not None and bool(picture.pushes or rollout.scenario.replan)


def _outlines(picture: Picture) -> tuple[Array, Array, Array] | None:
    """Instants (F,) s, outlines (F, L, SIDES, 3) m and whether they are there (F, L), or None."""
    rollout, planned, robot = picture.rollout, picture.planned, picture.robot
    if rollout is None or planned is None or robot is None or not _is_drawn(picture):
        return None
    plan = planned.plan
    task = place_task(plan.jump, robot, plan.tuning)
    times, outlines = [], []
    for time in np.arange(rollout.time[0], rollout.time[-1], 1 / _RATE):
        touchdown = expected_touchdown(rollout, plan, robot, float(time))
        if touchdown is None:
            continue
        feet = rollout.foot_position[int(np.searchsorted(rollout.time, time))]
        speed = task.limits.foot_speed
        times.append(float(time))
        outlines.append(landing_regions(robot, task.reach, speed, touchdown, feet, float(time)))
    if not times:
        return None
    there = np.array([[each is not None for each in outline] for outline in outlines], dtype=float)
    nowhere = np.zeros((SIDES, 3))
    points = np.array([[nowhere if e is None else e for e in outline] for outline in outlines])
    # Before the first and after the last, and between two flights, there are none.
    gaps = [k for k in range(len(times) - 1) if times[k + 1] - times[k] > 1.5 / _RATE]
    instants, rows, seen = [times[0] - _SWITCH], [0], [0.0]
    for k, time in enumerate(times):
        instants.append(time)
        rows.append(k)
        seen.append(1.0)
        if k in gaps or k == len(times) - 1:
            instants.append(time + _SWITCH)
            rows.append(k)
            seen.append(0.0)
            if k in gaps:
                instants.append(times[k + 1] - _SWITCH)
                rows.append(k + 1)
                seen.append(0.0)
    return np.array(instants), points[rows], there[rows] * np.array(seen)[:, None]


def _bars(
    names: Sequence[str], start: Array, along: Array, length: Array, there: NDArray[Any]
) -> list[Track]:
    """Flat bars, from `start` (F, n, 3) m to `start` + `along`, where they are (F, n)."""
    flat = [np.full_like(length, _WIDE), np.full_like(length, _THICK)]
    size = there[..., None] * np.stack([length, *flat], axis=2)
    middle = start + along / 2
    return [
        Track((name,), middle[:, k], gltf.x_to(along[:, k]), size[:, k])
        for k, name in enumerate(names)
    ]
