"""The regions in which the feet of a robot in flight can still land."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from app.motion import colours
from app.motion.clip import AnimationChannel, Track
from app.picture import gltf
from app.picture.drawing import Key, Overlay
from app.picture.picture import Picture
from app.picture.turns import x_to
from llsrbm.analysis.landing_region import SIDES, expected_touchdown, landing_regions
from llsrbm.planning.problem.placement import place_task

Array = NDArray[np.float64]

_RATE = 30.0  # regions/s
_WIDE, _THICK = 0.012, 0.003  # m, of an outline
_ABOVE = 0.004  # m, of the ground
_SWITCH = 1e-4  # s in which a region appears and goes


class LandingRegion(Overlay):
    """An outline a foot on the ground; of a complete simulation that is pushed or plans anew."""

    name = "landing-region"
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
    def keys(cls, picture: Picture) -> Sequence[Key]:
        if not _is_drawn(picture):
            return []
        return [Key(colours.REPLANNED, "outlines: where the feet can still land")]

    def draw(self, picture: Picture) -> Sequence[AnimationChannel]:
        found = _outlines(picture)
        if found is None:
            self.show(visible=False)
            return ()
        time, outline, there = found
        feet = outline.shape[1]
        names = self.nodes(gltf.bar(colours.REPLANNED), feet * SIDES, "side")
        tracks = []
        for foot in range(feet):
            points = outline[:, foot]
            sides = np.roll(points, -1, axis=1) - points
            length = np.linalg.norm(sides, axis=2)
            sides = np.where(length[..., None] > 0, sides, [1.0, 0.0, 0.0])
            middle = points + sides / 2 + [0.0, 0.0, _ABOVE]
            size = np.stack(
                [length, np.full_like(length, _WIDE), np.full_like(length, _THICK)], axis=2
            )
            size *= there[:, foot, None, None]
            tracks += [
                Track((names[foot * SIDES + k],), middle[:, k], x_to(sides[:, k]), size[:, k])
                for k in range(SIDES)
            ]
        self.show(visible=True)
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
