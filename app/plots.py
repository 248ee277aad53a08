"""Curves over time, of the plan and of the simulation, with the part that has been played shaded.

What is shaded is one more curve, high before the instant that is shown and low after it: uPlot's
lines are all that can be changed without making the chart anew. A change sends the whole chart, so
there are few points and changes come seldom.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import viser
from numpy.typing import NDArray
from viser import uplot

from app import colours
from app.replay import Replay
from app.simulated_replay import means_from
from llsrbm.trajectory.rollout import Rollout
from llsrbm.trajectory.rotation import rotation_matrices, yaw

Array = NDArray[np.float64]

NORM = "Average spatial velocity ‖v_G‖"
YAW = "Base yaw [°]"
YAW_RATE = "Base yaw rate [rad/s]"
COM_HEIGHT = "CoM height [m]"
FORCE = "Vertical force [N]"
DETECTION = "Detection signal, dashed: threshold"
TITLES = (NORM, YAW, YAW_RATE, COM_HEIGHT, FORCE, DETECTION)

_POINTS = 240  # of a curve: one a pixel
_PIXELS = 100  # height of a chart below its title
_ABOVE, _BELOW = 2.0, -1.0  # of the shading's range 0 to 1: its own line stays out of sight
_SETTLED = 1.0
"""s. uPlot forgets its time axis if data come while a new chart is still being measured."""


@dataclass(frozen=True, eq=False)
class Curve:
    """One quantity at K instants.

    Attributes:
        time: (K,) s, increasing; values: (K,).
    """

    time: Array
    values: Array


Pair = tuple[Curve | None, Curve | None]
"""Of the plan, or a threshold; of the simulation."""


def curves(planned: Replay, rollout: Rollout | None) -> dict[str, Pair]:
    """What there is to plot of a plan and of the rollout that followed it, by title."""
    plan = _planned(planned)
    simulated = {} if rollout is None else _simulated(rollout)
    pairs: dict[str, Pair] = {title: (plan[title], simulated.get(title)) for title in plan}
    if rollout is not None:
        pairs[DETECTION] = _detection(rollout)
    return pairs


class Plots:
    """The charts of one tab, made once and then changed; for the folder that is open."""

    def __init__(self, client: viser.ClientHandle) -> None:
        """Empty."""
        self._charts = {title: _Chart(client, title) for title in TITLES}
        self._charts[DETECTION].show(visible=False)

    def draw(self, pairs: Mapping[str, Pair], end: float) -> None:
        """Draw these from 0 to `end`, s; follow with `show_time`."""
        for title, chart in self._charts.items():
            if title in pairs:
                chart.take(pairs[title], end)
        self._charts[DETECTION].show(visible=DETECTION in pairs)

    def show_time(self, instant: float) -> None:
        """Shade what lies before an instant, s."""
        for chart in self._charts.values():
            chart.shade(instant)

    def clear(self) -> None:
        """No curves."""
        self.draw(dict.fromkeys(TITLES[:-1], (None, None)), 1.0)


class _Chart:
    """One chart: time, shading, two curves, all at the same instants."""

    def __init__(self, client: viser.ClientHandle, title: str) -> None:
        self._time = np.linspace(0.0, 1.0, _POINTS)
        blank = np.zeros(_POINTS)
        self._curves: tuple[Array, ...] = (blank, blank)
        self._played = -1
        self._visible = True
        self._ready_at = 0.0
        no_points = uplot.Series_Points(show=False)
        first = uplot.Series(stroke=colours.css(colours.PLANNED), width=1.5, points=no_points)
        if title == DETECTION:
            first = uplot.Series(
                stroke=colours.css(colours.FOOT), width=1, dash=(4.0, 4.0), points=no_points
            )
        small = "10px sans-serif"
        self._handle = client.gui.add_uplot(
            (self._time, blank, *self._curves),
            (
                uplot.Series(label="s"),
                uplot.Series(
                    scale="shade",
                    stroke=colours.css(colours.CURSOR, 0.7),
                    fill=colours.css(colours.CURSOR, 0.07),
                    width=1,
                    points=no_points,
                ),
                first,
                uplot.Series(stroke=colours.css(colours.SIMULATED), width=1.5, points=no_points),
            ),
            title=title,
            axes=(
                uplot.Axis(size=22, gap=2, font=small),
                uplot.Axis(size=38, gap=2, font=small, space=20),
            ),
            # A range of the shading's own, and no other fixed one, so that new curves never make
            # the browser build the chart anew.
            scales={"x": uplot.Scale(time=False), "shade": uplot.Scale(range=(0.0, 1.0))},
            legend=uplot.Legend(show=False),
            cursor=uplot.Cursor(
                sync=uplot.Cursor_Sync(key="time"), points=uplot.Cursor_Points(show=False)
            ),
            height=_PIXELS,
            padding=(4, 10, 0, 0),
        )

    def take(self, pair: Pair, end: float) -> None:
        self._time = np.linspace(0.0, end, _POINTS)
        self._curves = tuple(self._resampled(curve) for curve in pair)
        self._played = -1

    def shade(self, instant: float) -> None:
        if not self._visible or (self._played >= 0 and time.monotonic() < self._ready_at):
            return
        played = int(np.searchsorted(self._time, instant, side="right"))
        if played != self._played:
            self._played = played
            shading = np.where(np.arange(_POINTS) < played, _ABOVE, _BELOW)
            self._handle.data = (self._time, shading, *self._curves)

    def show(self, *, visible: bool) -> None:
        if visible != self._visible:
            self._visible = self._handle.visible = visible
            self._ready_at = time.monotonic() + _SETTLED

    def _resampled(self, curve: Curve | None) -> Array:
        if curve is None:
            return np.full(_POINTS, np.nan)
        # uPlot passes over what is no number, so a curve that has ended draws nothing.
        values: Array = np.interp(self._time, curve.time, curve.values)
        values[self._time > curve.time[-1] + self._time[1]] = np.nan
        return values


def _planned(planned: Replay) -> dict[str, Curve]:
    motion = planned.motion
    turning = np.linalg.solve(motion.inertia, motion.angular_momentum[..., None])[..., 0]
    values = {
        NORM: np.linalg.norm(np.hstack([motion.com_velocity, turning]), axis=1),
        YAW: np.degrees(yaw(motion.base_quat)),
        YAW_RATE: motion.angular_velocity[:, 2],
        COM_HEIGHT: motion.com[:, 2],
        FORCE: motion.contact_force[..., 2].sum(axis=1),
    }
    return {title: Curve(motion.time, v) for title, v in values.items()}


def _simulated(rollout: Rollout) -> dict[str, Curve]:
    kept = _stretches(rollout)
    # qvel's angular velocity is in the base's axes.
    vertical = rotation_matrices(rollout.base_quat)[:, 2]
    values = {
        NORM: rollout.average_spatial_velocity_norm[kept],
        YAW: np.degrees(yaw(rollout.base_quat))[kept],
        YAW_RATE: np.sum(vertical * rollout.qvel[:, 3:6], axis=1)[kept],
        COM_HEIGHT: rollout.com[kept, 2],
        # An impact is short: its mean is seen, a sample may miss it.
        FORCE: means_from(rollout.contact_force[..., 2].sum(axis=1), kept),
    }
    return {title: Curve(rollout.time[kept], v) for title, v in values.items()}


def _detection(rollout: Rollout) -> Pair:
    kept = _stretches(rollout)
    # Two ticks above the threshold are enough for a detection, so no tick may be left out; how far
    # an impact goes above it does not matter.
    largest = np.maximum.reduceat(rollout.detection_signal, kept)
    largest = np.minimum(largest, 3 * abs(rollout.detection_threshold))
    threshold = np.full(2, rollout.detection_threshold)
    return Curve(rollout.time[[0, -1]], threshold), Curve(rollout.time[kept], largest)


def _stretches(rollout: Rollout) -> NDArray[np.int64]:
    """First ticks of stretches as long as a chart resolves."""
    count = len(rollout.time)
    return np.arange(0, count, max(1, count // _POINTS))
