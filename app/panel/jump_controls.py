"""The controls that say which jump is wanted."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import viser

from app.panel.validation import number, option, put
from llsrbm import models
from llsrbm.jump import Jump
from llsrbm.robots import RobotFile, names
from llsrbm.robots.schema import Task


@dataclass(frozen=True)
class _Axis:
    """A slider of the request: its label, its field in `Jump` and `Task`, display units per SI."""

    label: str
    field: str
    scale: float
    step: float
    hint: str


_AXES = (
    _Axis("Twist [deg]", "twist", 180 / math.pi, 1.0, "About the vertical, positive to the left"),
    _Axis("Forward [m]", "forward", 1.0, 0.01, "Along the heading at the start"),
    _Axis("Lateral [m]", "lateral", 1.0, 0.01, "Positive to the left"),
    _Axis("Landing height [m]", "height", 1.0, 0.01, "Of the landing surface above the start"),
)


class JumpControls:
    """Robot, model and sliders, added to the folder that is open."""

    def __init__(self, gui: viser.GuiApi, jump: Jump, robot_file: RobotFile) -> None:
        """Show a request and the ranges of its robot."""
        self._task = robot_file.task
        self._robot = gui.add_dropdown("Robot", names(), initial_value=jump.robot)
        self._model = gui.add_dropdown("Model", models.names(), initial_value=jump.model)
        self._sliders = {axis.field: self._add_slider(gui, axis, jump) for axis in _AXES}

    @property
    def handles(self) -> list[Any]:
        """Whose updates are requests."""
        return [self._robot, self._model, *self._sliders.values()]

    def read(self, current: Jump) -> tuple[Jump, list[str]]:
        """The request as the controls stand, and what had to be corrected in it.

        Args:
            current: what counts where a control holds nothing usable.
        """
        complaints: list[str] = []
        robot = option("Robot", self._robot.value, names(), current.robot, complaints)
        model = option("Model", self._model.value, models.names(), current.model, complaints)
        amounts: dict[str, float] = {}
        for axis in _AXES:
            value = self._sliders[axis.field].value
            shown = number(axis.label, value, _range(axis, self._task), complaints)
            amounts[axis.field] = shown / axis.scale
        return Jump(robot=robot, model=model, **amounts), complaints

    def show_robot(self, robot_file: RobotFile) -> None:
        """The ranges of another robot, and its own example."""
        self._task = robot_file.task
        for axis in _AXES:
            handle = self._sliders[axis.field]
            handle.min, handle.max = _range(axis, robot_file.task)
            shown = _rounded(axis, getattr(robot_file.example, axis.field))
            put(handle, min(max(shown, handle.min), handle.max))

    def show(self, jump: Jump) -> None:
        """Put the controls where a corrected request has them."""
        put(self._robot, jump.robot)
        put(self._model, jump.model)
        for axis in _AXES:
            put(self._sliders[axis.field], _rounded(axis, getattr(jump, axis.field)))

    def _add_slider(
        self, gui: viser.GuiApi, axis: _Axis, jump: Jump
    ) -> viser.GuiSliderHandle[float]:
        lowest, highest = _range(axis, self._task)
        return gui.add_slider(
            axis.label,
            lowest,
            highest,
            axis.step,
            _rounded(axis, getattr(jump, axis.field)),
            hint=axis.hint,
        )


def _range(axis: _Axis, task: Task) -> tuple[float, float]:
    """A slider's ends: the task's, rounded inwards to whole steps (180.0004 deg is 180)."""
    lowest, highest = (axis.scale * end / axis.step for end in getattr(task, axis.field))
    slack = 1e-6  # -0.3 / 0.01 is -29.999999999999996
    return (
        round(math.ceil(lowest - slack) * axis.step, 6),
        round(math.floor(highest + slack) * axis.step, 6),
    )


def _rounded(axis: _Axis, value: float) -> float:
    return round(round(axis.scale * value / axis.step) * axis.step, 6)
