"""Figures of one part of the robot over time, as the picture shows them beside it."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from app.motion import colours
from app.picture.parts import TRUNK, foot_name
from app.plots.charts import Layer, charts
from app.plots.choice import ChartChoice, PlotChoice
from llsrbm.robots import Robot

_STEP = 1 / 60  # s between the values that are sent
_DIGITS = 4  # behind the decimal point
_UNITS = {"rad": ("°", 180 / np.pi)}  # as the page has them


def rows_of(part: str, robot: Robot) -> dict[str, ChartChoice]:
    """Charts of what a part has, by the titles of their rows; none of a part that is not known."""
    if part == TRUNK:
        angles = {axis.title(): ChartChoice("base_angle", (axis,)) for axis in _ANGLES}
        return angles | {"Yaw rate": ChartChoice("angular_velocity", ("z",))}
    if part in robot.joint_names:
        sliding = part in robot.sliding_joints
        return {
            "Position" if sliding else "Angle": ChartChoice("joint_position", (part,)),
            "Speed": ChartChoice("joint_velocity", (part,)),
            "Force" if sliding else "Torque": ChartChoice("joint_torque", (part,)),
            "Torque used": ChartChoice("saturation", (part,)),
        }
    leg = next((leg.name for leg in robot.legs if foot_name(leg.name) == part), None)
    if leg is None:
        return {}
    forces = {f"Force {axis}": ChartChoice("foot_force", (f"{leg} {axis}",)) for axis in "xyz"}
    return forces | {"Height": ChartChoice("foot_position", (f"{leg} z",))}


_ANGLES = ("yaw", "pitch", "roll")


def reading(part: str, robot: Robot, layers: Sequence[Layer]) -> dict[str, Any]:
    """The values of a part in motions, evenly spaced over time, for JSON; no rows where unknown."""
    rows = []
    colour_of = {layer.title: layer.colour for layer in layers}
    for number, (title, choice) in enumerate(rows_of(part, robot).items()):
        for chart in charts(PlotChoice((choice,)), layers):
            lines = [line for line in chart.lines if line.title in colour_of]
            unit, factor = _UNITS.get(chart.unit, (chart.unit, 1.0))
            if choice.signal == "saturation":
                unit, factor = "%", 100.0
            rows.append(
                {
                    "title": title,
                    "number": number,
                    "unit": unit,
                    "lines": [
                        {
                            "title": line.title,
                            "colour": colours.css(colour_of[line.title]),
                            "values": _spaced(line.time, factor * line.values),
                        }
                        for line in lines
                    ],
                }
            )
    return {"part": part, "step": _STEP, "rows": rows}


def _spaced(time: Any, values: Any) -> list[float | None]:
    even = np.interp(np.arange(time[0], time[-1] + _STEP, _STEP), time, values)
    return [round(value, _DIGITS) if np.isfinite(value) else None for value in even.tolist()]
