"""The controls of the jump: robot, model, type and arms in menus, numbers by a table of sliders."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import viser

from app.guard.validation import option, put
from app.panel import type_picture
from app.panel.acts import Act, Put, callback
from app.panel.fields import Ends, Field, Fields
from app.panel.jump_types import (
    extra_fields,
    title_of_type,
    turn_amounts,
    turn_title,
    turns_offered,
    types_offered,
)
from app.viser_private import uuid_of
from llsrbm import models
from llsrbm.planning.solve.guess_table import REQUEST
from llsrbm.request import jump_types
from llsrbm.request.jump import ARMS, MOST_HOPS, Jump
from llsrbm.request.jump_types import JumpType
from llsrbm.robots import Robot, RobotFile

_FASTEST = 1.0  # m/s at the start and the end: a quick walk of a small robot
_DEG = 180 / math.pi
_MODEL_TITLES = {"srbm": "SRBM", "llsrbm": "LL-SRBM", "llsrbm-plus": "LL-SRBM+"}


def _slider(
    label: str, hint: str, name: str, step: float, ends: Ends | None = None, scale: float = 1.0
) -> Field[Jump]:
    """A slider; without `ends` it has those of the robot's task, in every type of jump.

    `step` and `ends` are in display units, of which `scale` are an SI unit.
    """

    def of_task(file: RobotFile) -> Ends:
        """Rounded inwards to whole steps (180.0004 deg is 180)."""
        low, high = (scale * end / step for end in getattr(file.task, name))
        slack = 1e-6  # -0.3 / 0.01 is -29.999999999999996
        low, high = math.ceil(low - slack) * step, math.floor(high + slack) * step
        return round(low, 6), round(high, 6)

    def put_number(jump: Jump, shown: float) -> Jump:
        return replace(jump, **{name: type(getattr(jump, name))(shown / scale)})

    return Field(
        label,
        hint,
        get=lambda jump: scale * getattr(jump, name),
        put=put_number,
        ends=ends or of_task,
        step=step,
        slider=True,
        there=lambda jump: ends is None or name in extra_fields(jump),
    )


SLIDERS = (
    _slider("Twist [deg]", "About the vertical, positive to the left", "twist", 1.0, scale=_DEG),
    _slider("Forward [m]", "Along the heading at the start", "forward", 0.01),
    _slider("Lateral [m]", "Positive to the left", "lateral", 0.01),
    _slider("Landing height [m]", "Of the landing surface above the start", "height", 0.01),
    _slider("Speed [m/s]", "Forward at the start", "speed", 0.05, (0.0, _FASTEST)),
    _slider(
        "End speed [m/s]",
        "Forward at the end, along the landing's heading",
        "end_speed",
        0.05,
        (0.0, _FASTEST),
    ),
    _slider(
        "Hops", "Jumps in a row, each as far as the sliders say", "hops", 1.0, (1.0, MOST_HOPS)
    ),
)

TINTED: Mapping[str, Field[Jump]] = dict(zip(REQUEST, SLIDERS, strict=False))
"""Sliders whose tracks show what can be planned, by fields of a request.

See `app.tab.planning.feasible`.
"""


class JumpControls:
    """Robot, model, type, arms and sliders, added to the container that is open."""

    def __init__(
        self, gui: viser.GuiApi, jump: Jump, robots: Mapping[str, RobotFile], acted: Put
    ) -> None:
        self._robots = robots
        self._robot_titles = {file.title: name for name, file in robots.items()}
        self._model_titles = {_MODEL_TITLES.get(name, name): name for name in models.names()}
        self._types: Mapping[str, JumpType] = jump_types.names()  # of any robot, to begin with
        self._types_of: tuple[Robot, str] | None = None
        self._drawn_of: tuple[Any, ...] = ()  # robot and request, as far as the picture shows them
        self._robot = gui.add_dropdown(
            "Robot", tuple(self._robot_titles), initial_value=robots[jump.robot].title
        )
        self._model = gui.add_dropdown(
            "Model",
            tuple(self._model_titles),
            initial_value=_MODEL_TITLES.get(jump.model, jump.model),
            hint="Of the robot's inertia, with which the jump is planned",
        )
        self._type = gui.add_dropdown(
            "Jump type",
            tuple(kind.title for kind in self._types.values()),
            initial_value=title_of_type(jump.type),
            hint="Which feet push, fly and land when",
        )
        self._fields = Fields(gui, jump, robots[jump.robot], acted, Act.JUMP)
        self._arms = _arms_menu(robots)
        self._fields.add([self._arms])
        self._picture = gui.add_html(type_picture.EMPTY)
        self._turn = gui.add_dropdown(
            "Turn",
            turns_offered(jump_types.TYPE_PARAMETERS, jump_types.TYPE_PARAMETERS),
            visible=False,
            hint="A whole turn in the air",
        )
        for menu in (self._robot, self._model, self._type, self._turn):
            menu.on_update(callback(acted, Act.JUMP))
        self._whole_body = gui.add_checkbox(
            "Whole body",
            False,
            hint="Refine plans on the equations of motion of every link",
        )
        self._whole_body.on_update(callback(acted, Act.WHOLE_BODY))
        self._fields.add(SLIDERS)

    @property
    def robot_and_model(self) -> tuple[Any, Any]:
        """Their menus, which stand in one row."""
        return self._robot, self._model

    @property
    def type_and_arms(self) -> tuple[Any, Any]:
        """Likewise, of robots with arms."""
        return self._type, self._fields.handle(self._arms)

    @property
    def whole_body(self) -> bool:
        """Whether plans are refined, as the box stands."""
        return self._whole_body.value is True

    def show_whole_body(self, ticked: bool) -> None:
        """Whether plans are refined."""
        put(self._whole_body, ticked)

    @property
    def tinted(self) -> dict[str, str]:
        """Field of a request -> the uuid of its slider."""
        return {name: uuid_of(self._fields.handle(field)) for name, field in TINTED.items()}

    def read(self, current: Jump) -> tuple[Jump, list[str]]:
        """The request as the controls stand, else `current`, and what had to be corrected."""
        jump, complaints = self._fields.read(current, self._file_of(current))
        robot = _named("Robot", self._robot.value, self._robot_titles, current.robot, complaints)
        model = _named("Model", self._model.value, self._model_titles, current.model, complaints)
        kinds = {title_of_type(name): name for name in (*self._types, current.type)}
        kind = _named("Jump type", self._type.value, kinds, current.type, complaints)
        turn = self._read_turn(current, complaints)
        return replace(jump, robot=robot, model=model, type=kind, **turn), complaints

    def show_robot(self, robot: Robot, jump_type: str) -> bool:
        """Offer the types that a robot can do; whether robot or type are others than before.

        Another type shows other controls, also where it changes no number.
        """
        if self._types_of == (robot, jump_type):
            return False
        if self._types_of is None or robot is not self._types_of[0]:
            self._types = types_offered(robot)
        self._types_of = robot, jump_type
        return True

    def show(self, jump: Jump) -> None:
        """Put the controls where a request has them, with the ranges of its robot."""
        put(self._robot, self._robots[jump.robot].title)
        put(self._model, _MODEL_TITLES.get(jump.model, jump.model))
        self._fields.show(jump, self._file_of(jump))
        self.show_type(jump)

    def show_type(self, jump: Jump) -> None:
        """The type, and the controls that it asks for; numbers stay where a hand put them."""
        titles = (kind.title for kind in self._types.values())
        _put_among(self._type, titles, title_of_type(jump.type))
        turns = self._turns(jump)
        if turns:
            _put_among(self._turn, turns, turn_title(jump))
        self._turn.visible = bool(turns)
        self._fields.show_there(jump)

    def _file_of(self, jump: Jump) -> RobotFile:
        return self._robots[jump.robot].for_jump(turns=jump.turns)

    def show_picture(self, robot: Robot, jump: Jump) -> None:
        """The feet that stand, phase by phase, and the turn."""
        drawn_of = (robot, jump.type, jump.hops, jump.pitch, jump.roll)
        if drawn_of != self._drawn_of and jump.type in self._types:
            self._drawn_of = drawn_of
            self._picture.content = type_picture.type_picture(self._types[jump.type], robot, jump)

    def _read_turn(self, current: Jump, complaints: list[str]) -> dict[str, Any]:
        """Pitch and roll, if the type asks for them and the menu does not show what they are."""
        now, offered = turn_title(current), self._turns(current)
        if not offered or self._turn.value == now:
            return {}
        chosen = option("Turn", self._turn.value, offered, "", complaints)
        return turn_amounts(chosen) if chosen else {}

    def _turns(self, jump: Jump) -> tuple[str, ...]:
        return turns_offered(extra_fields(jump), self._robots[jump.robot].turning_axes)


def _arms_menu(robots: Mapping[str, RobotFile]) -> Field[Jump]:
    """Of robots with arms alone."""
    return Field(
        "Arms",
        "Free to move and shape the inertia, or held as they hang",
        get=lambda jump: jump.arms.capitalize(),
        put=lambda jump, shown: replace(jump, arms=shown.lower()),
        options=tuple(choice.capitalize() for choice in ARMS),
        there=lambda jump: bool(robots[jump.robot].arms),
    )


def titled(jump: Jump, robots: Mapping[str, RobotFile]) -> Jump:
    """The jump with titles of robot and model, but for the first robot, which titles leave out."""
    robot = jump.robot
    if robot != Jump().robot and robot in robots:
        robot = robots[robot].title
    return replace(jump, robot=robot, model=_MODEL_TITLES.get(jump.model, jump.model))


def _put_among(menu: Any, titles: Iterable[str], title: str) -> None:
    """Choose in a menu; what it does not offer is there as long as it is chosen."""
    options = tuple(dict.fromkeys((*titles, title)))
    if tuple(menu.options) != options:
        menu.options = options
    put(menu, title)


def _named(
    label: str, value: Any, titles: Mapping[str, str], otherwise: str, complaints: list[str]
) -> str:
    """The name that belongs to a title; scripts may choose by the name itself."""
    if isinstance(value, str):
        if value in titles:
            return titles[value]
        if value in titles.values():
            return value
    option(label, value, tuple(titles), otherwise, complaints)
    return otherwise
