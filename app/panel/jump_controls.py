"""The controls that say which jump is wanted."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import viser

from app.viser_link.validation import number, option, put
from llsrbm import models
from llsrbm.jump import Jump
from llsrbm.robots import RobotFile
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


_MODEL_TITLES = {"srbm": "SRBM", "llsrbm": "LL-SRBM", "llsrbm-plus": "LL-SRBM+"}


class JumpControls:
    """Robot, model and sliders, added to the container that is open."""

    def __init__(self, gui: viser.GuiApi, jump: Jump, robots: Mapping[str, RobotFile]) -> None:
        """Show a request and the ranges of its robot.

        Args:
            gui: of the tab.
            jump: to begin with.
            robots: name -> file of each robot to choose from.
        """
        self._robots = robots
        self._task = robots[jump.robot].task
        self._robot_titles = {file.title: name for name, file in robots.items()}
        self._model_titles = {_MODEL_TITLES.get(name, name): name for name in models.names()}
        self._robot = gui.add_dropdown(
            "Robot", tuple(self._robot_titles), initial_value=robots[jump.robot].title
        )
        self._model = gui.add_dropdown(
            "Model",
            tuple(self._model_titles),
            initial_value=_MODEL_TITLES.get(jump.model, jump.model),
            hint="Of the robot's inertia, with which the jump is planned",
        )
        self._sliders = {axis.field: self._add_slider(gui, axis, jump) for axis in _AXES}

    @property
    def handles(self) -> list[Any]:
        """The controls whose updates are requests."""
        return [self._robot, self._model, *self._sliders.values()]

    def read(self, current: Jump) -> tuple[Jump, list[str]]:
        """The request as the controls stand, and what had to be corrected in it.

        Args:
            current: what counts where a control holds nothing usable.
        """
        complaints: list[str] = []
        robot = _named("Robot", self._robot.value, self._robot_titles, current.robot, complaints)
        model = _named("Model", self._model.value, self._model_titles, current.model, complaints)
        amounts: dict[str, float] = {}
        for axis in _AXES:
            value = self._sliders[axis.field].value
            shown = number(axis.label, value, _range(axis, self._task), complaints)
            now = getattr(current, axis.field)
            # A number that nobody touched stays as it is, however it is rounded for show.
            touched = not math.isclose(shown, _rounded(axis, now), abs_tol=1e-9)
            amounts[axis.field] = shown / axis.scale if touched else now
        return Jump(robot=robot, model=model, **amounts), complaints

    def show(self, jump: Jump) -> None:
        """Put the controls where a request has them, with the ranges of its robot."""
        task = self._robots[jump.robot].task
        if task is not self._task:
            self._task = task
            for axis in _AXES:
                handle = self._sliders[axis.field]
                handle.min, handle.max = _range(axis, task)
        put(self._robot, self._robots[jump.robot].title)
        put(self._model, _MODEL_TITLES.get(jump.model, jump.model))
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


def titled(jump: Jump, robots: Mapping[str, RobotFile]) -> Jump:
    """The jump with the titles of its robot and model for their names, to be named by titles.

    The first robot keeps its name: `llsrbm.titles` leaves it out.
    """
    robot = jump.robot
    if robot != Jump().robot and robot in robots:
        robot = robots[robot].title
    return replace(jump, robot=robot, model=_MODEL_TITLES.get(jump.model, jump.model))


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


def _named(
    label: str, value: Any, titles: Mapping[str, str], otherwise: str, complaints: list[str]
) -> str:
    """The name that belongs to a title; scripts may choose by the name itself."""
    by_name = {name: name for name in titles.values()}
    known = {**by_name, **titles}
    chosen = value if isinstance(value, str) and value in known else None
    if chosen is None:
        option(label, value, tuple(titles), otherwise, complaints)
        return otherwise
    return known[chosen]
