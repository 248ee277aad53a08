"""Options that commands share: how to plan, where results go, and one for each field of a request.

Heavy imports happen where they are needed. Angles are degrees on the command line.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping
from dataclasses import fields, replace
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, get_type_hints

import typer

from llsrbm.errors import InputError
from llsrbm.files.atomic import check_place
from llsrbm.number_text import decimal, degrees
from llsrbm.request.jump import INCLINES, TYPE_PARAMETERS, Jump, Load, parse_payload
from llsrbm.request.messages import FieldSpec, Number, field_specs
from llsrbm.request.route import Route, load_route
from llsrbm.request.scenario import PushList, Scenario, parse_push
from llsrbm.request.stones import StoneList, parse_stone
from llsrbm.request.tuning import Tuning

if TYPE_CHECKING:
    from llsrbm.motion.plan import Plan
    from llsrbm.request.design import Design

Robot = Annotated[str, typer.Option(help="A name (see `llsrbm robots`) or a robot file's path.")]
Planner = Annotated[str, typer.Option(help="fatrop or ipopt.")]


def _writable(path: Path | None) -> Path | None:
    """The path, if a file can be written there: told before minutes of work are lost."""
    if path is not None:
        check_place(path)
    return path


Out = Annotated[
    Path | None,
    typer.Option(metavar="FILE", help="Write the result here (npz).", callback=_writable),
]
AsJson = Annotated[
    bool, typer.Option("--json", help="Print one JSON object on stdout, the rest on stderr.")
]

Interface = Annotated[
    str,
    typer.Option(metavar="IF", help="Network interface; lo: this machine, for `llsrbm robot-sim`."),
]
Domain = Annotated[int | None, typer.Option(help="DDS domain [default: 1 on lo, 0 elsewhere].")]

Mover = Annotated[
    str, typer.Option("--robot", metavar="R", help="Robot that moves in another tool's file.")
]
Exported = Annotated[
    Path, typer.Option(metavar="FILE", help="The file to write; several formats need a .zip.")
]
Formats = Annotated[
    list[str], typer.Option("--format", metavar="F", help="See `llsrbm formats`; may be repeated.")
]
_OF_THE_FORMAT = "the format's"  # default of an option of which each format has its own
FrameRate = Annotated[float, typer.Option(help="Frames per second.", show_default=_OF_THE_FORMAT)]
Size = Annotated[
    str,
    typer.Option(metavar="WxH", help="Size of a video, pixels.", show_default=_OF_THE_FORMAT),
]
Pad = Annotated[
    float,
    typer.Option(metavar="S", help="Time that the robot stands still before and after the motion."),
]
Order = Annotated[
    str, typer.Option(metavar="O", help="Order of bodies and joints: depth-first or breadth-first.")
]
Fps = Annotated[float | None, typer.Option(help="Frames per second of a file that does not say.")]

Weights = Annotated[
    list[str] | None,
    typer.Option("--weight", metavar="NAME=VALUE", help="See `llsrbm tuning`; may be repeated."),
]
Limits = Annotated[
    list[str] | None,
    typer.Option("--limit", metavar="NAME=VALUE", help="See `llsrbm tuning`; may be repeated."),
]

Workers = Annotated[
    int | None,
    typer.Option(metavar="N", help="Processes on this machine."),
]
Scheduler = Annotated[
    str | None,
    typer.Option(metavar="ADDRESS", help="A Dask scheduler that runs: tcp://host:8786."),
]

Draft = Annotated[
    bool, typer.Option("--draft", help="The centroidal plan alone: quick, and not certified.")
]

_TUNING = ("solver", "weight", "limit", "draft")
PLANNING = ("design", *(field.name for field in fields(Jump)), *_TUNING)
"""Parameters of the options of planning."""

DesignOption = Annotated[
    str | None,
    typer.Option(
        "--design",
        metavar="FILE",
        help="A design's file, or a name of `llsrbm designs`; other options override it.",
    ),
]

_PARAMETERS = {"solver": "qp_solver", "drives": "ideal_drives"}  # `--solver` is the planner's
_FLAGS = {
    "half_board": "--half-board/--whole-board",
    "pushes": "--push",
    "stones": "--stone",
    "drives": "--ideal-drives/--true-drives",
}
_SWITCHED = {"drives": ("true", "ideal")}  # names that a flag chooses between: off, on
_OF_THE_TYPE = "the type's"  # default of an option that only some jump types have


def is_given(context: typer.Context, name: str) -> bool:
    """True if a parameter of a command stands on the command line."""
    source = context.get_parameter_source(name)
    return source is not None and source.name != "DEFAULT"


def given(context: typer.Context, **values: Any) -> dict[str, Any]:
    """Those of the values of parameters that stand on the command line."""
    return {name: value for name, value in values.items() if is_given(context, name)}


def option(name: str) -> str:
    """The option of a parameter: "--end-speed", "--stone" of `stones`."""
    return _FLAGS.get(name, f"--{name.replace('_', '-')}").partition("/")[0]


def check_workers(workers: int | None, scheduler: str | None) -> None:
    """Raise `InputError` for fewer workers than one, and for workers beside a cluster's own."""
    if workers is not None and workers < 1:
        raise InputError(f"--workers {workers}: expected 1 or more")
    if workers is not None and scheduler is not None:
        raise InputError(
            "--workers and --scheduler: expected one of them; a cluster that runs has its workers"
        )


def read_plan(file: Path) -> Plan:
    """The plan in a native file; `InputError`: it holds a rollout."""
    import llsrbm

    found = llsrbm.load(file)
    if not isinstance(found, llsrbm.Plan):
        raise InputError(f"{file}: holds a {type(found).__name__.lower()}; expected a plan")
    return found


def requested_tuning(tuning: Tuning, weight: list[str] | None, limit: list[str] | None) -> Tuning:
    """A design's weights and limits as the options change them; `InputError`: not NAME=VALUE.

    Names and ranges are checked when something is planned.
    """
    from llsrbm.planning.problem.limits import limit_unit

    weights = _assignments("--weight", weight or [])
    limits = _assignments("--limit", limit or [])
    for name in limits:
        if limit_unit(name) == "rad":  # degrees on the command line
            limits[name] = math.radians(limits[name])
    return Tuning({**tuning.weights, **weights}, {**tuning.limits, **limits})


def _assignments(option: str, given: list[str]) -> dict[str, float]:
    found: dict[str, float] = {}
    for text in given:
        name, value = _assignment(option, text)
        if name in found:
            raise InputError(f"{option} {text}: {name} is given twice; expected every name once")
        found[name] = value
    return found


def _assignment(option: str, given: str) -> tuple[str, float]:
    name, _, value = given.partition("=")
    try:
        return name.strip(), float(value)
    except ValueError:
        raise InputError(
            f"{option} {given}: expected NAME=VALUE with a number; `llsrbm tuning` lists the names"
        ) from None


def with_jump_options(command: Callable[..., int]) -> Callable[..., int]:
    """The command with the options of a jump in place of its parameter `requested`.

    Its first parameter is `context`; `requested` becomes those fields of a `Jump` whose options
    stand on the command line, name -> value, in the library's units.
    """
    return _with_options(command, Jump, "requested")


def with_scenario_options(command: Callable[..., int]) -> Callable[..., int]:
    """Likewise with the options of a scenario in place of its parameter `conditions`."""
    return _with_options(command, Scenario, "conditions")


def requested_jump(requested: Mapping[str, Any], jump: Jump | None = None) -> Jump:
    """The jump, or the default one, with other values in the requested fields.

    With another type, the fields that only some types have become that type's defaults. Raises
    `InputError` for an impossible value.
    """
    changed = replace(jump or Jump(), **requested)
    if "type" not in requested:
        return changed
    from llsrbm.request.jump_types import with_defaults  # slow to import

    return with_defaults(changed, requested)


def requested_design(name_or_path: str | None, requested: Mapping[str, Any]) -> Design:
    """The design of that name or path (None: only the jump), its jump as the options change it."""
    from llsrbm.request.design import Design, find_design

    if name_or_path is None:
        return Design(requested_jump(requested))
    design = find_design(name_or_path)
    return replace(design, jump=requested_jump(requested, design.jump))


def is_angle(name: str) -> bool:
    """True if a field of a jump is an angle, which the command line has in degrees."""
    spec = field_specs(Jump)[name]
    return isinstance(spec, Number) and spec.unit == "rad"


def in_words(jump: Jump) -> str:
    """The request in one line, in the command line's units."""
    plain = Jump()
    words = [] if jump.type == plain.type else [jump.type]
    landings = jump.route or (jump,)
    words += [
        f"twist {degrees(place.twist, 0)}, forward {decimal(place.forward, 2)} m, lateral "
        f"{decimal(place.lateral, 2)} m, height {decimal(place.height, 2)} m"
        for place in landings
    ]
    if jump.route:
        words = [f"landing {k}: {place}" for k, place in enumerate(words[-len(landings) :], 1)]
    words += [
        f"{name} {degrees(turn, 0)}"
        for name, turn in (("roll", jump.roll), ("pitch", jump.pitch))
        if turn
    ]
    words += [
        f"{name} {decimal(speed, 2)} m/s"
        for name, speed in (("speed", jump.speed), ("end speed", jump.end_speed))
        if speed
    ]
    words += [
        f"{name} {decimal(size, 2)} m"
        for name, size in (("gap", jump.gap), ("bar", jump.bar))
        if size
    ]
    if jump.hops != plain.hops:
        words.append(f"{jump.hops} hops")
    if jump.arms != plain.arms:
        words.append(f"arms {jump.arms}")
    if jump.payload:
        words.append(f"payload {decimal(jump.payload[0], 2)} kg")
    words += [
        f"{name.replace('_', ' ')} {degrees(getattr(jump, name), 0)}"
        for name in INCLINES
        if getattr(jump, name)
    ]
    words += [
        f"{leg} {', '.join(decimal(each, 3) for each in place)} m aside"
        for leg, *place in jump.stones
    ]
    return f"{jump.robot}, {jump.model}: {', '.join(words)}"


def _with_options(command: Callable[..., int], kind: type, parameter: str) -> Callable[..., int]:
    """The command with an option for each field of `kind` in place of one parameter."""
    specs = field_specs(kind)
    field_of = {_parameter(kind, name): name for name in specs}

    @wraps(command)
    def called(context: typer.Context, **arguments: Any) -> int:
        given = {name: arguments.pop(name) for name in field_of}
        values = {
            field_of[name]: _in_library_units(field_of[name], specs[field_of[name]], value)
            for name, value in given.items()
            if is_given(context, name)
        }
        return command(context, **arguments, **{parameter: values})

    parameters: list[inspect.Parameter] = []
    for each in inspect.signature(command, eval_str=True).parameters.values():
        parameters += _parameters(kind) if each.name == parameter else [each]
    called.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    return called


def _accepted(spec: FieldSpec) -> str:
    """The range of an option's value, angles in degrees as it has them."""
    if isinstance(spec, Number) and spec.unit == "rad" and math.isfinite(spec.high):
        return f"{math.degrees(spec.low):g} to {math.degrees(spec.high):g} deg"
    return spec.accepted


def _parameter(kind: type, field: str) -> str:
    return _PARAMETERS.get(field, field) if kind is Scenario else field


def _in_library_units(field: str, spec: FieldSpec, value: Any) -> Any:
    if field in _SWITCHED:
        return _SWITCHED[field][value]
    if isinstance(spec, PushList):
        return tuple(map(parse_push, value))
    if isinstance(spec, StoneList):
        return tuple(map(parse_stone, value))
    if isinstance(spec, Load):
        return parse_payload(value)
    if isinstance(spec, Route):
        return load_route(value)
    return math.radians(value) if isinstance(spec, Number) and spec.unit == "rad" else value


def _parameters(kind: Any) -> list[inspect.Parameter]:
    """An option for each field, as typer reads them from a function's signature."""
    types, specs, parameters = get_type_hints(kind), field_specs(kind), []
    for field in fields(kind):
        spec, default, annotation = specs[field.name], field.default, types[field.name]
        accepted = _accepted(spec)
        accepted = f" ({accepted})" if accepted else ""
        shown: bool | str = True
        if isinstance(spec, PushList | StoneList):
            accepted, default, annotation = f"{accepted}; may be repeated", [], list[str]
        elif isinstance(spec, Load | Route):
            default, annotation = None, str | None
        elif kind is Jump and field.name in TYPE_PARAMETERS:
            default, annotation, shown = None, annotation | None, _OF_THE_TYPE
        elif field.name in _SWITCHED:
            default, annotation = default == _SWITCHED[field.name][1], bool
        option = typer.Option(
            default,
            *([_FLAGS[field.name]] if field.name in _FLAGS else []),
            metavar=spec.symbol or None,
            help=f"{spec.help}{accepted}.",
            show_default=shown,
        )
        parameters.append(
            inspect.Parameter(
                _parameter(kind, field.name),
                inspect.Parameter.POSITIONAL_OR_KEYWORD,
                default=option,
                annotation=annotation,
            )
        )
    return parameters
