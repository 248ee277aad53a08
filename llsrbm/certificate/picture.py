"""Profiles of a certificate's checks over a motion as a picture: what breaks, where and when."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from llsrbm.certificate.certificate import Certificate
from llsrbm.certificate.finding import DISTANCES, Finding, Profile
from llsrbm.files.picture import check_picture, write_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_WIDTH, _HEIGHT = 9.0, 0.85  # inches of a check
_DPI = 100
_FOUND, _BROKEN, _ALLOWED = "#2b6cb0", "#c53030", "0.35"
_ROOM = 1.6  # times what is allowed: the least that an axis shows
_MOST = 20  # times that room: more is cut off
_MARGIN = 0.08  # of the axis, above and below


def write_picture(certificate: Certificate, path: Path, title: str = "") -> None:
    """Draw what each check finds along the motion, against what is allowed.

    A strip a check that is known: shares of its limit, or mm; red where it does not hold. `path`:
    its suffix is the picture's kind.

    Raises:
        InputError: no picture has such a name, it cannot be written there, or matplotlib is not
            installed.
    """
    check_picture(path)
    from matplotlib.figure import Figure

    shown = [found for found in certificate if found.name in certificate.profiles]
    size = (_WIDTH, _HEIGHT * max(len(shown), 1) + 0.9)
    figure = Figure(figsize=size, dpi=_DPI, layout="constrained")
    strips = figure.subplots(max(len(shown), 1), 1, squeeze=False, sharex=True).ravel()
    for axes, found in zip(strips, shown, strict=False):
        _draw(axes, found, certificate.profiles[found.name])
    strips[-1].set_xlabel("time, s", fontsize=8)
    figure.suptitle(title, fontsize=9)
    write_figure(figure, path)


def _draw(axes: Axes, found: Finding, profile: Profile) -> None:
    """One check's strip."""
    scale = 1e3 if found.is_length else 1e2
    allowed, worst = scale * profile.allowed, scale * profile.worst
    ends = _ends(allowed, worst, is_least=found.name in DISTANCES)
    level = np.clip(worst, *ends)
    edges = np.append(profile.begin, profile.end[-1])
    axes.stairs(level, edges, baseline=None, color=_FOUND, lw=0.9)
    axes.axhline(allowed, color=_ALLOWED, lw=0.8, ls="--")
    for begin, end in zip(profile.begin[~profile.holds], profile.end[~profile.holds], strict=True):
        axes.axvspan(begin, end, color=_BROKEN, alpha=0.3, lw=0)
    axes.set_ylim(*ends)
    axes.set_ylabel("mm" if found.is_length else "%", fontsize=7)
    axes.tick_params(labelsize=7)
    axes.margins(x=0.0)
    words = found.name.replace("_", " ")
    if found.worst is not None and found.allowed is not None:
        words += f": {found.shown(found.worst)} at {found.where or 'an instant'}, {found.when}"
        words += f"; {found.shown(found.allowed)} allowed"
    axes.set_title(words, fontsize=7.5, loc="left", pad=2, color="k" if found.holds else _BROKEN)


def _ends(allowed: float, worst: np.ndarray, *, is_least: bool) -> tuple[float, float]:
    """The axis' ends: what is allowed with room around it, and all that is found, within reason."""
    finite = worst[np.isfinite(worst)]
    low, high = (finite.min(), finite.max()) if len(finite) else (allowed, allowed)
    room = max(abs(allowed) * _ROOM, 1.0)
    bottom = min(low, allowed - room) if is_least else min(0.0, low)
    top = max(min(high, allowed + _MOST * room), allowed + room if is_least else room)
    margin = _MARGIN * (top - bottom)
    return bottom - margin, top + margin
