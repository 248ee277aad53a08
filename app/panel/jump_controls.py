"""The controls of the jump: robot, model, type and arms in menus, numbers by a table of sliders."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import viser

from app.panel import type_picture
from app.panel.acts import HOW_FAR, Act, Buttons, Put, add_buttons
from app.panel.fields import Ends, Field, Fields, switch
from app.panel.foothold_controls import FootholdControls
from app.panel.jump_types import (
    extra_fields,
    landing_fields,
    of_chosen_type,
    surface_fields,
    title_of_type,
    turn_title,
    turns_offered,
    types_offered,
    with_turn,
)
from app.viser_private import uuid_of
from llsrbm import models
from llsrbm.look.titles import title_of_model
from llsrbm.request import jump_types
from llsrbm.request.jump import ARMS, COMPONENTS, Jump
from llsrbm.request.jump_types import JumpType
from llsrbm.request.route import MOST, STEEPEST
from llsrbm.robots import Robot, RobotFile
from llsrbm.robots.payload import HEAVIEST
from llsrbm.robots.schema import Task

_UNKNOWN_HEAVIEST = 1.0  # kg, until the robot is there
_FASTEST = 1.0  # m/s at the start and the end: a quick walk of a small robot
_DEG = 180 / math.pi


def _slider(
    label: str, hint: str, name: str, step: float, ends: Ends | None = None, scale: float = 1.0
) -> Field[Jump]:
    """A slider; without `ends` it has those of the robot's range, in every type of jump.

    `step` and `ends` are in display units, of which `scale` are an SI unit.
    """

    def of_task(about: About) -> Ends:
        """Rounded inwards to whole steps (180.0004 deg is 180)."""
        low, high = (scale * end / step for end in getattr(about.task, name))
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
        there=lambda jump: (
            name in (*landing_fields(jump), *extra_fields(jump), *surface_fields(jump))
        ),
    )


SLIDERS = (
    _slider(
        "Twist [deg]", "Turn about the vertical, positive to the left", "twist", 1.0, scale=_DEG
    ),
    _slider("Forward [m]", "Landing place along the initial heading", "forward", 0.01),
    _slider("Lateral [m]", "Landing place to the side, positive to the left", "lateral", 0.01),
    _slider("Landing height [m]", "Height of the landing surface above the start", "height", 0.01),
    _slider("Speed [m/s]", "Forward speed at the start", "speed", 0.05, (0.0, _FASTEST)),
    _slider(
        "End speed [m/s]",
        "Forward speed at the end, along the landing's heading",
        "end_speed",
        0.05,
        (0.0, _FASTEST),
    ),
    _slider(
        "Hops",
        "Number of jumps in a row, each as far as the sliders say",
        "hops",
        1.0,
        (1.0, MOST),
    ),
    _slider(
        "Gap [m]",
        "Width of the gap that the whole robot passes over",
        "gap",
        0.01,
        (0.0, 0.6),
    ),
    _slider(
        "Bar [m]",
        "Height of the bar that the whole robot passes over",
        "bar",
        0.01,
        (0.0, 0.4),
    ),
)

_STEEP = math.degrees(STEEPEST)
SLOPES = tuple(
    _slider(
        label,
        f"Angle by which the {surface} surface rises {way}",
        name,
        1.0,
        (-_STEEP, _STEEP),
        _DEG,
    )
    for label, surface, way, name in (
        ("Landing slope [deg]", "landing", "ahead, as the robot looks that lands", "slope"),
        ("Landing cross slope [deg]", "landing", "to the left, likewise", "cross_slope"),
        ("Take-off slope [deg]", "take-off", "ahead", "takeoff_slope"),
        ("Take-off cross slope [deg]", "take-off", "to the left", "takeoff_cross_slope"),
    )
)
"""Sliders of the surfaces, of every type of jump."""

TINTED: Mapping[str, Field[Jump]] = dict(zip(COMPONENTS, SLIDERS, strict=False))
"""Sliders whose tracks show what can be planned, by fields of a request.

See `app.tab.planning.feasible`.
"""


PAYLOAD: Field[Jump] = Field(
    "Payload [kg]",
    "Mass on the trunk, in the origin of its frame; drafts are of the robot without it",
    get=lambda jump: jump.payload[0] if jump.payload else 0.0,
    put=lambda jump, kg: replace(jump, payload=_with_mass(jump.payload, kg)),
    ends=lambda about: (0.0, about.heaviest),
    step=0.1,
    slider=True,
)


def _with_mass(payload: tuple[float, ...], kg: float) -> tuple[float, ...]:
    """A payload of another mass at the place where it is; of no mass it is none."""
    return (kg, *(payload[1:] or (0.0, 0.0, 0.0))) if kg > 0 else ()


class About(NamedTuple):
    """A robot, on which the ranges and menus of a request depend."""

    file: RobotFile  # of its robot, for such a jump
    task: Task  # ends of the sliders
    types: Mapping[str, JumpType]  # that the robot can do
    heaviest: float  # kg that it can carry


class JumpControls:
    """Robot, type, arms and sliders, in the container that is open; the model, where asked for."""

    def __init__(
        self, gui: viser.GuiApi, jump: Jump, robots: Mapping[str, RobotFile], acted: Put
    ) -> None:
        self._robots = robots
        self._types: Mapping[str, JumpType] = jump_types.names()  # of any robot, to begin with
        self._types_of: Robot | None = None
        self._heaviest = _UNKNOWN_HEAVIEST
        self._drawn_of: tuple[Any, ...] = ()  # robot and request, as far as the picture shows them
        self._gui, self._acted = gui, acted
        self._task = robots[jump.robot].for_jump(turns=jump.turns).task
        *self._menus, self._model = _menus(robots)
        self._fields = Fields(gui, jump, self._about(jump), acted, Act.JUMP)
        self._fields.add(*self._menus)
        self._picture = gui.add_html(type_picture.EMPTY)
        self.footholds = FootholdControls(gui, jump, acted)
        self._fields.add(TURN)
        self.buttons: Buttons = {}  # each beside the slider that follows it
        for field in SLIDERS:
            for name in (name for name, own in TINTED.items() if own is field):
                self.buttons |= add_buttons(gui, HOW_FAR[name].value.place, acted)
            self._fields.add(field)

    def add_model(self) -> None:
        """Add the model's menu to the container that is open."""
        self._fields.add(self._model)

    def add_slopes(self) -> None:
        """Add how the ground slopes, in the open container."""
        self._fields.add(*SLOPES)

    def add_payload(self) -> None:
        """Add what the robot carries, in the open container."""
        self._fields.add(PAYLOAD)

    def add_whole_body(self) -> None:
        """Add whether drafts are replaced by the whole body's plans, in the open container."""
        self.whole_body = switch(
            self._gui,
            "Whole body",
            "Plan every link once the sliders rest; without it plans stay drafts",
            self._acted,
            Act.WHOLE_BODY,
        )

    @property
    def menus(self) -> tuple[Any, ...]:
        """Menus of robot, type and arms, which stand in one row."""
        return tuple(map(self._fields.handle, self._menus))

    @property
    def hints(self) -> dict[str, tuple[str, str]]:
        """As `Fields.hints`."""
        return {**self._fields.hints, **self.whole_body.hints, **self.footholds.hints}

    @property
    def model(self) -> Any:
        """Menu of the model."""
        return self._fields.handle(self._model)

    @property
    def tinted(self) -> dict[str, str]:
        """Field of a request -> the uuid of its slider."""
        return {name: uuid_of(self._fields.handle(field)) for name, field in TINTED.items()}

    def read(self, current: Jump) -> tuple[Jump, list[str]]:
        """The request with what was moved, and what had to be corrected."""
        jump, complaints = self._fields.read(current, self._about(current))
        jump, others = self.footholds.read(jump)
        return jump, [*complaints, *others]

    @property
    def how_far(self) -> list[tuple[str, str]]:
        """Uuid of each button that searches along a slider, and what that is called."""
        names = {act: TINTED[name].label.partition(" [")[0] for name, act in HOW_FAR.items()}
        return [(uuid_of(button), names[act]) for act, button in self.buttons.items()]

    def show(self, jump: Jump, robot: Robot | None, ends: Task) -> None:
        """Put the controls where a request has them; the types and the picture, of its robot.

        `robot`: the one of the request; None while it is loaded, which leaves the picture empty.
        `ends`: of the sliders.
        """
        self._task = ends
        if robot is not None and robot is not self._types_of:
            self._types_of, self._types = robot, types_offered(robot)
            self._heaviest = round(HEAVIEST * robot.mass - 0.05, 1)  # never beyond
        self._fields.show(jump, self._about(jump))
        for name, act in HOW_FAR.items():
            self.buttons[act].visible = name in landing_fields(jump)
        self.footholds.show(jump, robot)
        if robot is None:
            # Another robot's feet, or another type, would be a wrong picture of the request.
            self._drawn_of, self._picture.content = (), type_picture.EMPTY
        drawn_of = (robot, jump.type, jump.jumps, jump.pitch, jump.roll)
        if robot is not None and drawn_of != self._drawn_of and jump.type in self._types:
            self._drawn_of = drawn_of
            self._picture.content = type_picture.type_picture(self._types[jump.type], robot, jump)

    def _about(self, jump: Jump) -> About:
        file = self._robots[jump.robot].for_jump(turns=jump.turns)
        return About(file, self._task, self._types, self._heaviest)


TURN: Field[Jump] = Field(
    "Turn",
    "A whole turn in the air",
    get=turn_title,
    put=with_turn,
    options=lambda jump, about: turns_offered(extra_fields(jump), about.file.turning_axes),
    there=lambda jump: bool({"pitch", "roll"} & set(extra_fields(jump))),
)


def _menus(robots: Mapping[str, RobotFile]) -> tuple[Field[Jump], ...]:
    names = {file.title: name for name, file in robots.items()}
    models_by_title = {title_of_model(name): name for name in models.MODELS}
    return (
        Field(
            "Robot",
            "The robot that jumps, with the drives of its file",
            get=lambda jump: robots[jump.robot].title,
            put=lambda jump, title: replace(jump, robot=names.get(title, title)),
            options=tuple(names),
            aliases=tuple(robots),
        ),
        Field(
            "Jump type",
            "Contact schedule: which feet push, fly and land when",
            get=lambda jump: title_of_type(jump.type),
            put=of_chosen_type,
            options=lambda _, about: [kind.title for kind in about.types.values()],
        ),
        Field(
            "Arms",
            "Let the planner move the arms, or hold them as they hang",
            get=lambda jump: jump.arms.capitalize(),
            put=lambda jump, shown: replace(jump, arms=shown.lower()),
            options=tuple(choice.capitalize() for choice in ARMS),
            there=lambda jump: bool(robots[jump.robot].arms),  # of robots with arms alone
        ),
        Field(
            "Model",
            "Inertia model used by the planner",
            get=lambda jump: title_of_model(jump.model),
            put=lambda jump, title: replace(jump, model=models_by_title.get(title, title)),
            options=tuple(models_by_title),
            aliases=tuple(models_by_title.values()),
        ),
    )
