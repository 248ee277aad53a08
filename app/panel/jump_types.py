"""Jump types and whole turns on the page: those that a robot can do, and their titles."""

import math
from collections.abc import Collection
from dataclasses import replace
from typing import Any

from llsrbm.errors import InputError
from llsrbm.request import jump_types
from llsrbm.request.jump import COMPONENTS, INCLINES, PLAIN, Jump
from llsrbm.request.jump_types import JumpType, with_defaults
from llsrbm.request.route import SLOPES
from llsrbm.robots import Robot

_TURNS: dict[str, tuple[str, float]] = {
    "back flip": ("pitch", -math.tau),
    "front flip": ("pitch", math.tau),
    "roll left": ("roll", -math.tau),
    "roll right": ("roll", math.tau),
}
"""Title -> field of `Jump` and rad, by the right-hand rule about x forward and y left."""


def types_offered(robot: Robot) -> dict[str, JumpType]:
    """Name -> type of those for which a robot has the feet and the turns, the default first."""
    return {
        name: kind
        for name, kind in jump_types.names().items()
        if _turns(kind) <= set(robot.file.turning_axes) and _has_feet_of(robot, kind)
    }


def title_of_type(name: str) -> str:
    """As in menus and messages; the name itself of a type that is no preset."""
    known = jump_types.names()
    return known[name].title if name in known else name


def type_of_title(title: str, otherwise: str) -> str:
    """The name of the type with this title."""
    return next((n for n, kind in jump_types.names().items() if kind.title == title), otherwise)


def not_supported(robot: Robot, name: str) -> str:
    """The sentence that says that a robot's jump is of the default type instead."""
    what, default = title_of_type(name), title_of_type(PLAIN)
    known = name in jump_types.names()
    why = f'{robot.file.title} does not support "{what}"' if known else f'"{what}" is no preset'
    return f'{why}. Planning "{default}" instead.'


def with_type(jump: Jump, name: str) -> Jump:
    """The request as one of another type, with that type's defaults; the landing place stays.

    A flip begins on the spot and without a twist, as plans of flips with one are not known; jumps
    over a gap or a bar begin without one, as each of them would turn by it.
    """
    jump = with_defaults(replace(jump, type=name))
    if jump.turns:
        jump = replace(jump, twist=0.0, forward=0.0, lateral=0.0, height=0.0)
    if jump_types.load_type(name).passes:
        jump = replace(jump, twist=0.0)
    shown = {*landing_fields(jump), *surface_fields(jump)}
    others: dict[str, Any] = dict.fromkeys({*COMPONENTS, *INCLINES} - shown, 0.0)
    return replace(jump, **others)


def of_chosen_type(jump: Jump, title: str) -> Jump:
    """The request as one of the type with this title; a route that it cannot have ends early."""
    name = type_of_title(title, jump.type)
    kind = jump_types.names().get(name)
    alone = kind is not None and not any(row.each_hop for row in kind.phase)
    if name != jump.type and jump.route and alone:
        jump = jump.along(jump.landings[:1])
    return replace(jump, type=name)


def landing_fields(jump: Jump) -> tuple[str, ...]:
    """Its fields that say where to land; none of a route, which says it itself."""
    if jump.route:
        return ()
    kind = jump_types.names().get(jump.type)
    passes = kind is not None and kind.passes
    return tuple(name for name in COMPONENTS if not (passes and name == "forward"))


def surface_fields(jump: Jump) -> tuple[str, ...]:
    """Fields that say how surfaces slope; of a route the take-off's alone: landings say theirs.

    None of a type that passes over something, beside which surfaces are level.
    """
    kind = jump_types.names().get(jump.type)
    if kind is not None and kind.obstacle is not None:
        return ()
    return tuple(name for name in INCLINES if not (jump.route and name in SLOPES))


def extra_fields(jump: Jump) -> tuple[str, ...]:
    """Fields that its type has besides where to land; none of a type that is no preset."""
    known = jump_types.names()
    own = known[jump.type].parameters if jump.type in known else ()
    return tuple(name for name in own if not (jump.route and name == "hops"))


def turns_offered(fields: Collection[str], axes: Collection[str]) -> tuple[str, ...]:
    """Titles of the turns that a jump type needs, about axes about which a robot makes them."""
    return tuple(title for title, (field, _) in _TURNS.items() if field in fields and field in axes)


def turn_title(jump: Jump) -> str:
    """The turn of a request; one that is not in the menu in degrees."""
    shown = {field: round(math.degrees(getattr(jump, field))) for field in ("pitch", "roll")}
    for title, (field, angle) in _TURNS.items():
        if shown == {"pitch": 0, "roll": 0, field: round(math.degrees(angle))}:
            return title
    return ", ".join(f"{field} {angle}°" for field, angle in shown.items() if angle) or "none"


def with_turn(jump: Jump, title: str) -> Jump:
    """The request with a turn of the menu; with its own by another title."""
    if title not in _TURNS:
        return jump
    field, angle = _TURNS[title]
    amounts: dict[str, Any] = {"pitch": 0.0, "roll": 0.0, field: angle}
    return replace(jump, **amounts)


def _turns(kind: JumpType) -> set[str]:
    return {name for name in ("pitch", "roll") if kind.defaults.get(name)}


def _has_feet_of(robot: Robot, kind: JumpType) -> bool:
    try:
        kind.schedule(robot)
    except InputError:
        return False
    return True
