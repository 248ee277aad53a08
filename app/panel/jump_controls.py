"""The controls that say which jump is wanted."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import viser

from app.guard.validation import number, option, put
from app.panel.turn_choice import turn_amounts, turn_title, turns_offered
from app.panel.types_offered import title_of_type, types_offered
from llsrbm import models
from llsrbm.request import jump_types
from llsrbm.request.jump import MOST_HOPS, Jump
from llsrbm.request.jump_types import JumpType
from llsrbm.robots import Robot, RobotFile
from llsrbm.robots.schema import Task


@dataclass(frozen=True)
class _Axis:
    """A slider of the request.

    Attributes:
        label, hint: for people.
        field: in `Jump`, and in `Task` if it has no `ends`.
        scale: display units per SI unit.
        step: in display units.
        ends: lowest and highest value, in display units; None: the robot's task has them.
    """

    label: str
    field: str
    scale: float
    step: float
    hint: str
    ends: tuple[float, float] | None = None


_AXES = (
    _Axis("Twist [deg]", "twist", 180 / math.pi, 1.0, "About the vertical, positive to the left"),
    _Axis("Forward [m]", "forward", 1.0, 0.01, "Along the heading at the start"),
    _Axis("Lateral [m]", "lateral", 1.0, 0.01, "Positive to the left"),
    _Axis("Landing height [m]", "height", 1.0, 0.01, "Of the landing surface above the start"),
)

_FASTEST = 1.0  # m/s at the start and the end: a quick walk of a small robot

_ASKED = (
    _Axis("Speed [m/s]", "speed", 1.0, 0.05, "Forward at the start", (0.0, _FASTEST)),
    _Axis(
        "End speed [m/s]",
        "end_speed",
        1.0,
        0.05,
        "Forward at the end, along the landing's heading",
        (0.0, _FASTEST),
    ),
    _Axis(
        "Hops", "hops", 1.0, 1.0, "Jumps in a row, each as far as the sliders say", (1, MOST_HOPS)
    ),
)
"""Sliders that are there for types that ask for them."""

_MODEL_TITLES = {"srbm": "SRBM", "llsrbm": "LL-SRBM", "llsrbm-plus": "LL-SRBM+"}


class JumpControls:
    """Robot, model, type and sliders, added to the container that is open."""

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
        self._types: Mapping[str, JumpType] = jump_types.names()  # of any robot, to begin with
        self._types_of: Robot | None = None
        self._type_of = ""
        self._type = gui.add_dropdown(
            "Jump type",
            tuple(kind.title for kind in self._types.values()),
            initial_value=title_of_type(jump.type),
            hint="Which feet push, fly and land when",
        )
        self._turn = gui.add_dropdown(
            "Turn",
            turns_offered(jump_types.ASKABLE, jump_types.ASKABLE),
            visible=False,
            hint="A whole turn in the air",
        )
        self._sliders = {axis.field: self._add_slider(gui, axis, jump) for axis in _AXES + _ASKED}
        self.show_asked(jump)

    @property
    def handles(self) -> list[Any]:
        """The controls whose updates are requests."""
        return [self._robot, self._model, self._type, self._turn, *self._sliders.values()]

    def read(self, current: Jump) -> tuple[Jump, list[str]]:
        """The request as the controls stand, and what had to be corrected in it.

        Args:
            current: what counts where a control holds nothing usable.
        """
        complaints: list[str] = []
        robot = _named("Robot", self._robot.value, self._robot_titles, current.robot, complaints)
        model = _named("Model", self._model.value, self._model_titles, current.model, complaints)
        kinds = {title_of_type(name): name for name in (*self._types, current.type)}
        kind = _named("Jump type", self._type.value, kinds, current.type, complaints)
        amounts: dict[str, Any] = self._read_turn(current, complaints)
        for axis in _AXES + _ASKED:
            if axis in _ASKED and axis.field not in _asks(current):
                continue
            value = self._sliders[axis.field].value
            shown = number(axis.label, value, _range(axis, self._task), complaints)
            now = getattr(current, axis.field)
            # A number that nobody touched stays as it is, however it is rounded for show.
            touched = not math.isclose(shown, _rounded(axis, now), abs_tol=1e-9)
            amounts[axis.field] = type(now)(shown / axis.scale) if touched else now
        return replace(current, robot=robot, model=model, type=kind, **amounts), complaints

    def show_robot(self, robot: Robot, jump_type: str) -> bool:
        """Offer the types that a robot can do; whether robot or type are others than before.

        Another type shows other controls, also where it changes no number.
        """
        if (robot, jump_type) == (self._types_of, self._type_of):
            return False
        if robot is not self._types_of:
            self._types = types_offered(robot)
        self._types_of, self._type_of = robot, jump_type
        return True

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
        for axis in _AXES + _ASKED:
            put(self._sliders[axis.field], _rounded(axis, getattr(jump, axis.field)))
        self.show_asked(jump)

    def _read_turn(self, current: Jump, complaints: list[str]) -> dict[str, float]:
        """Pitch and roll, if the type asks for them and the menu does not show what they are."""
        now, offered = turn_title(current), self._turns(current)
        if not offered or self._turn.value == now:
            return {}
        chosen = option("Turn", self._turn.value, offered, "", complaints)
        return turn_amounts(chosen) if chosen else {}

    def show_asked(self, jump: Jump) -> None:
        """The type, and the controls that it asks for."""
        asks, turns = _asks(jump), self._turns(jump)
        _put_among(
            self._type, (kind.title for kind in self._types.values()), title_of_type(jump.type)
        )
        if turns:
            _put_among(self._turn, turns, turn_title(jump))
        self._turn.visible = bool(turns)
        for axis in _ASKED:
            self._sliders[axis.field].visible = axis.field in asks

    def _turns(self, jump: Jump) -> tuple[str, ...]:
        return turns_offered(_asks(jump), self._robots[jump.robot].turning_axes)

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

    The first robot keeps its name: `llsrbm.look.titles` leaves it out.
    """
    robot = jump.robot
    if robot != Jump().robot and robot in robots:
        robot = robots[robot].title
    return replace(jump, robot=robot, model=_MODEL_TITLES.get(jump.model, jump.model))


def _asks(jump: Jump) -> tuple[str, ...]:
    """What its type asks for beside where to land; nothing is known of a type that is no preset."""
    known = jump_types.names()
    return known[jump.type].asks if jump.type in known else ()


def _put_among(menu: Any, titles: Iterable[str], title: str) -> None:
    """Choose in a menu; what it does not offer is there as long as it is chosen."""
    options = tuple(dict.fromkeys((*titles, title)))
    if tuple(menu.options) != options:
        menu.options = options
    put(menu, title)


def _range(axis: _Axis, task: Task) -> tuple[float, float]:
    """A slider's ends: the task's, rounded inwards to whole steps (180.0004 deg is 180)."""
    if axis.ends is not None:
        return axis.ends
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
