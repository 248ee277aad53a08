"""New plans of a robot under way: at each instant the one that is followed."""

from collections.abc import Sequence

import numpy as np

from app.motion import colours
from app.motion.clip import AnimationChannel, Track
from app.motion.colours import Rgb
from app.picture import gltf
from app.picture.drawing import Group, Overlay
from app.picture.picture import Picture
from llsrbm.arrays import Array, IntArray
from llsrbm.mechanics import interpolated, turned_to
from llsrbm.motion.replan import Replan

_PIECES = 14  # of the CoM's path
_THICK = 0.006  # m, radius of the path
_FOOTHOLD = 0.032  # m, radius of a foothold
_FLAT = 0.03  # of a foothold, thickness over radius
_ABOVE = 0.006  # m, over the marks of the first plan's landing
_SWITCH = 1e-4  # s that it takes to go on to the next plan


class NewPlans(Overlay):
    """The path of the CoM and the footholds; of a simulation that is complete."""

    name = "new-plans"
    group = Group.FOOTHOLDS
    title = "New plans"
    hint = "The plan that is followed after replanning: its centre of mass and footholds."
    place = 80
    at_first = True
    parts = frozenset({"robot", "planned", "rollout"})
    root = "/anew"

    @classmethod
    def swatch(cls, picture: Picture) -> Sequence[Rgb]:
        rollout = picture.rollout
        return [] if rollout is None or not rollout.replans else [colours.REPLANNED]

    def draw(self, picture: Picture) -> Sequence[AnimationChannel]:
        rollout = picture.rollout
        taken = () if rollout is None else [r for r in rollout.replans if np.isfinite(r.applied)]
        if not taken:
            return self.nothing()
        paths = np.stack([_path(replan) for replan in taken])
        start, along = paths[:, :-1], np.diff(paths, axis=1)
        length = np.linalg.norm(along, axis=2)
        size = np.stack([np.full_like(length, _THICK)] * 2 + [length], axis=2)
        time, which = _times(taken)
        there = np.append(0.0, np.ones(len(which) - 1))[:, None]  # none before the first one
        tracks = [
            Track((name,), start[which, k], turned_to(along[which, k], 2), there * size[which, k])
            for k, name in enumerate(self.nodes(gltf.rod(colours.REPLANNED), _PIECES, "path"))
        ]
        feet = np.stack([replan.foot_position[-1] for replan in taken])
        feet[..., 2] += _ABOVE
        flat = np.array([_FOOTHOLD, _FOOTHOLD, _FOOTHOLD * _FLAT])
        footholds = self.nodes(gltf.disc(colours.REPLANNED), feet.shape[1], "foothold")
        tracks += [
            Track((name,), feet[which, foot], None, there * flat)
            for foot, name in enumerate(footholds)
        ]
        return [AnimationChannel(time, tuple(tracks))]


def _path(replan: Replan) -> Array:
    """Points of a plan's CoM, (_PIECES + 1, 3) m, evenly spaced in time."""
    times = np.linspace(replan.time[0], replan.time[-1], _PIECES + 1)
    return interpolated(times, replan.time, replan.com)


def _times(taken: Sequence[Replan]) -> tuple[Array, IntArray]:
    """Instants at which a plan begins and ends to be followed, and its number."""
    times, which = [max(0.0, taken[0].applied - _SWITCH)], [0]
    for number, replan in enumerate(taken):
        if number:
            times.append(max(replan.applied - _SWITCH, times[-1] + _SWITCH / 2))
            which.append(number - 1)
        times.append(max(replan.applied, times[-1] + _SWITCH / 2))
        which.append(number)
    return np.array(times), np.array(which)
