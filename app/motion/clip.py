"""A motion ready to be played: where every node of the scene is over time."""

import base64
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from llsrbm.arrays import Array


@dataclass(frozen=True, eq=False)
class Track:
    """How some nodes of the scene move together, at the F instants of a channel."""

    nodes: tuple[str, ...]  # their names
    position: Array  # (F, 3) m
    wxyz: Array | None = None  # (F, 4) unit quaternions; None: they do not turn
    # (F, 3) factors of their size, zeros where they are not there; None: ones
    scale: Array | None = None


@dataclass(frozen=True, eq=False)
class AnimationChannel:
    """Tracks with the same instants: those of a plan, or of a simulation."""

    time: Array  # (F,) s, increasing; before and after, the first and the last instant hold
    tracks: tuple[Track, ...]  # what moves


@dataclass(frozen=True, eq=False)
class CameraTarget:
    """For a page's camera."""

    # name of the node that a camera follows: the base of the robot that is drawn solid. Another
    # node is another robot, and is looked at anew
    follow: str
    points: Array  # (P, 3) m, world frame: the robot is between them in all of its motion
    # azimuth (0 ahead, 90 to the left), elevation (deg) and distance (m) of the camera at first;
    # None: from where it sees all of them
    camera: tuple[float, float, float] | None = None
    # (3,) towards the camera at first, world frame; None: as of any robot
    direction: tuple[float, float, float] | None = None

    @property
    def plain(self) -> dict[str, Any]:
        """For JSON."""
        points = self.points.round(4).tolist()
        return {
            "follow": self.follow,
            "points": points,
            "camera": self.camera,
            "direction": self.direction,
        }


@dataclass(frozen=True, eq=False)
class Clip:
    """Everything that moves in a tab."""

    channels: tuple[AnimationChannel, ...]  # that are shown together
    end: float  # s, when the last of them ends
    # of the motion, so that a page knows which one it draws
    request: Mapping[str, Any] = field(default_factory=dict)
    camera_target: CameraTarget | None = None  # what a camera looks at; None: nothing
    parts: tuple[Mapping[str, Any], ...] = ()  # of the robot, to be pointed at, for JSON

    @cached_property
    def encoded(self) -> tuple[dict[str, Any], str]:
        """The form in which a browser reads it: a list of its parts for JSON, and the numbers.

        The numbers are little-endian 32 bit floats in base64: of each channel the instants, then of
        each of its tracks positions, quaternions (each on the same side as the one before, so that
        they can be mixed) and scales, as far as the list says that there are any.
        """
        arrays: list[Array] = []
        channels = []
        for channel in self.channels:
            arrays.append(channel.time)
            tracks = []
            for track in channel.tracks:
                arrays.append(track.position)
                if track.wxyz is not None:
                    arrays.append(_continuous(track.wxyz))
                if track.scale is not None:
                    arrays.append(track.scale)
                tracks.append(
                    {
                        "nodes": track.nodes,
                        "turns": track.wxyz is not None,
                        "scales": track.scale is not None,
                    }
                )
            channels.append({"frames": len(channel.time), "tracks": tracks})
        numbers = np.concatenate([np.ravel(a) for a in arrays]) if arrays else np.zeros(0)
        blob = base64.b64encode(numbers.astype("<f4").tobytes()).decode("ascii")
        target = self.camera_target
        header = {
            "end": self.end,
            "request": dict(self.request),
            "camera_target": None if target is None else target.plain,
            "parts": self.parts,
            "channels": channels,
        }
        return header, blob


def _continuous(wxyz: Array) -> Array:
    """The same attitudes (F, 4), each quaternion on the side of the one before it."""
    flips = np.sign(np.sum(wxyz[1:] * wxyz[:-1], axis=1))
    signs = np.cumprod(np.concatenate([[1.0], np.where(flips == 0, 1.0, flips)]))
    return wxyz * signs[:, None]
