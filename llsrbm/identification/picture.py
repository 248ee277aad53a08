"""Measured against modelled torques as a picture, by matplotlib (`llsrbm[pictures]`)."""

from pathlib import Path

import numpy as np

from llsrbm.files.picture import check_picture, write_figure
from llsrbm.identification.fit import Identified

_SHOWN = 4.0  # s, from the log's middle
_COLUMNS, _WIDTH, _HEIGHT = 3, 3.6, 1.9  # inches of a joint
_DPI = 100


def write_picture(found: Identified, path: Path) -> None:
    """Draw some seconds of each joint that was identified. Raises as `check_picture`."""
    check_picture(path)
    from matplotlib.figure import Figure

    names = list(found.joints)
    known = np.flatnonzero(np.isfinite(found.measured[0]))
    rows = -(-len(names) // _COLUMNS)
    size = (_COLUMNS * _WIDTH, rows * _HEIGHT + 0.6)
    figure = Figure(figsize=size, dpi=_DPI, layout="constrained")
    plots = figure.subplots(rows, _COLUMNS, squeeze=False, sharex=True).ravel()
    middle = found.time[-1] / 2
    shown = np.abs(found.time - middle) <= _SHOWN / 2
    for axes, name, joint in zip(plots, names, known, strict=False):
        axes.plot(found.time[shown], found.measured[shown, joint], lw=1.6, label="measured")
        axes.plot(found.time[shown], found.modelled[shown, joint], lw=0.9, label="modelled")
        axes.set_title(name, fontsize=8)
        axes.tick_params(labelsize=7)
    for axes in plots[len(names) :]:
        axes.set_axis_off()
    figure.supxlabel("time, s", fontsize=8)
    figure.supylabel("torque, Nm", fontsize=8)
    plots[0].legend(fontsize=7)
    write_figure(figure, path)
