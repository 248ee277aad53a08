"""Maps as a picture, side by side, drawn by matplotlib (`pip install "llsrbm[pictures]"`)."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from llsrbm.atlas.colours import SCALE, of_stop
from llsrbm.atlas.jumps import words_of
from llsrbm.atlas.map import Map
from llsrbm.files.picture import check_picture, write_figure
from llsrbm.look.palette import Rgb

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_WIDTH, _HEIGHT = 3.4, 3.3  # inches of a map
_DPI = 120  # three maps beside each other are as wide as a page of the README
_TURN = 90.0  # degrees between ticks
# Cells without a value.
_NONE: dict[str, Any] = {"facecolor": "0.93", "hatch": "////", "edgecolor": "0.75"}


def write_picture(maps: Sequence[Map], titles: Sequence[str], target: Path) -> None:
    """Draw maps of one colour side by side, under their titles; the target's suffix is its kind.

    Raises `InputError`: matplotlib is not installed, no picture has such a suffix, or the file
    cannot be written.
    """
    check_picture(target)
    from matplotlib.figure import Figure

    figure = Figure(figsize=(_WIDTH * len(maps) + 0.6, _HEIGHT), dpi=_DPI, layout="constrained")
    row = figure.subplots(1, len(maps), squeeze=False)[0]
    for axes, drawn, title in zip(row, maps, titles, strict=True):
        _draw(axes, drawn, title, ends=_ends(maps))
    row[0].set_ylabel(maps[0].y.axis.heading)
    _explain(figure, row, maps)
    write_figure(figure, target)


def _ends(maps: Sequence[Map]) -> tuple[float, float]:
    return min(drawn.ends[0] for drawn in maps), max(drawn.ends[1] for drawn in maps)


def _draw(axes: Axes, drawn: Map, title: str, ends: tuple[float, float]) -> None:
    from matplotlib.colors import ListedColormap
    from matplotlib.ticker import MultipleLocator

    x, y, colour = drawn.x, drawn.y, drawn.colour
    cells = x.edges * x.axis.scale, y.edges * y.axis.scale
    values = np.ma.masked_invalid(drawn.value)
    if colour.categorical:
        stops = drawn.jumps.stops
        colours = ListedColormap([_unit(of_stop(k, stops)) for k in range(len(stops))])
        axes.pcolormesh(*cells, values, cmap=colours, vmin=-0.5, vmax=len(stops) - 0.5)
    else:
        low, high = (end * colour.scale for end in ends)
        axes.pcolormesh(*cells, values * colour.scale, cmap=_scale(), vmin=low, vmax=high)
    axes.axhspan(cells[1][0], cells[1][-1], zorder=0, linewidth=0, **_NONE)
    empty = np.ma.masked_where(drawn.count > 0, np.zeros(drawn.count.shape))
    axes.pcolormesh(*cells, empty, cmap=ListedColormap(["white"]))
    for line in drawn.border:
        across, up = line[:, 0] * x.axis.scale, line[:, 1] * y.axis.scale
        axes.plot(across, up, color="white", linewidth=3.5)
        axes.plot(across, up, color="black", linewidth=1.6)
    for side, axis in ((axes.xaxis, x.axis), (axes.yaxis, y.axis)):
        if axis.unit == "deg":
            side.set_major_locator(MultipleLocator(_TURN))
    axes.set_title(title, fontsize=10)
    axes.set_xlabel(x.axis.heading)
    axes.set_xlim(cells[0][0], cells[0][-1])
    axes.set_ylim(cells[1][0], cells[1][-1])


def _explain(figure: Figure, row: Sequence[Axes], maps: Sequence[Map]) -> None:
    """A bar of the colours, or a list of them, to the right."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    colour = maps[0].colour
    keys: list[Any] = []
    if any(drawn.border for drawn in maps):
        keys.append(
            Line2D([], [], color="black", linewidth=1.6, label="half of the jumps can be planned")
        )
    if any((np.isnan(drawn.value) & (drawn.count > 0)).any() for drawn in maps):
        keys.append(Patch(linewidth=0, label="no plan", **_NONE))
    if colour.categorical:
        stops = maps[0].jumps.stops  # of the whole sweep
        shown = sorted({place for drawn in maps for place in drawn.stops})
        keys += [Patch(color=_unit(of_stop(k, stops)), label=words_of(stops[k])) for k in shown]
    else:
        low, high = (end * colour.scale for end in _ends(maps))
        mapped = ScalarMappable(Normalize(low, high), _scale())
        figure.colorbar(mapped, ax=list(row), label=colour.heading, pad=0.02)
    if keys:
        figure.legend(handles=keys, loc="outside lower center", ncols=4, fontsize=8, frameon=False)


def _scale() -> Any:
    from matplotlib.colors import LinearSegmentedColormap

    return LinearSegmentedColormap.from_list("atlas", [_unit(each) for each in SCALE])


def _unit(colour: Rgb) -> tuple[float, float, float]:
    red, green, blue = (part / 255 for part in colour)
    return red, green, blue
