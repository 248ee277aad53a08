"""From where a motion stands, instant by instant, to where its plan is to stand.

Feet that slide while all of them stand lead the motion with them; they are held.
"""

from __future__ import annotations

import numpy as np

from llsrbm.arrays import Array
from llsrbm.mechanics import interpolated
from llsrbm.repairing.feet import feet_of
from llsrbm.repairing.led import Led, Way
from llsrbm.repairing.request import Request, stood


def led_at(request: Request, time: Array) -> Led:
    """The way of a motion's base at instants (K,) s of its own time, and that of the plan's.

    In a flight both are between two places.
    """
    part, edges = request.part, request.part.edges
    places = np.interp(time, edges, request.places_at_edges)
    own, to = (way.at(places) for way in (request.led.own, request.led.to))
    if not any(part.slides):
        return Led(own, to)
    feet, _ = feet_of(part.motion.robot, part.motion.qpos)
    middles, headings = stood(feet, part.motion.robot)
    slid = np.column_stack([middles, np.unwrap(headings)])
    moved = np.column_stack([own.middles, own.headings])
    # They slide until they leave, and from where they have landed.
    for slides, edge, there in zip(
        part.slides, edges[[1, -2]], (time <= edges[1], time >= edges[-2]), strict=True
    ):
        if slides:
            held = interpolated(np.append(time[there], edge), part.motion.time, slid)
            moved[there] += held[:-1] - held[-1]
    return Led(Way(moved[:, :2], moved[:, 2]), to)
