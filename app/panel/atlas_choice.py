"""Which map of which sweep a tab shows: a pure value that is part of the tab's state."""

from __future__ import annotations

from dataclasses import dataclass

from llsrbm.atlas.jumps import Axis
from llsrbm.atlas.map import NEAREST


@dataclass(frozen=True)
class AtlasChoice:
    """A map.

    Attributes:
        seen: whether the page has shown the atlas: before that nothing is read or drawn.
        sweep: its name; "": the first that there is.
        x, y: names of axes; where a sweep does not vary one, another stands in for it.
        colour: name of one of `llsrbm.atlas.colours.COLOURS`.
        projection: one of `llsrbm.atlas.map.PROJECTIONS`.
    """

    seen: bool = False
    sweep: str = ""
    x: str = "twist"
    y: str = "forward"
    colour: str = "plannable"
    projection: str = NEAREST

    def axes(self, varied: tuple[Axis, ...]) -> tuple[Axis, Axis] | None:
        """The chosen ones of what a sweep varies, two different ones; None: it varies only one."""
        if len(varied) < 2:
            return None
        named = {axis.name: axis for axis in varied}
        x = named.get(self.x) or next(axis for axis in varied if axis.name != self.y)
        y = named.get(self.y) if self.y != x.name else None
        return x, y or next(axis for axis in varied if axis is not x)
