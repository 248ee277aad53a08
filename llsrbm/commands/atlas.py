"""`llsrbm atlas`."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from llsrbm.commands import console, options
from llsrbm.errors import InputError
from llsrbm.request.jump import Jump

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from llsrbm.atlas.colours import Colour
    from llsrbm.atlas.jumps import Atlas, Axis, Jumps
    from llsrbm.atlas.map import Map


_Intervals = Annotated[
    bool,
    typer.Option(
        "--intervals",
        help="In place of maps: what can be planned along each number of a request, the others "
        "being those of --at [default: 0]; guessed from solved and refused jumps, in rad and m.",
    ),
]


def atlas_command(
    sweep: Annotated[
        Path | None,
        typer.Argument(
            metavar="[DIR]",
            help="Folder of a sweep, or its table [default: the tables of solved jumps].",
        ),
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="FILE", help="Picture: .png, .svg or .pdf.")
    ] = None,
    robot: Annotated[
        list[str] | None,
        typer.Option(metavar="R", help="Robots to show; repeatable [default: all]."),
    ] = None,
    x: Annotated[str, typer.Option(help="Quantity along the axis to the right.")] = "twist",
    y: Annotated[str, typer.Option(help="Quantity along the axis upwards.")] = "forward",
    colour: Annotated[
        str, typer.Option(help="plannable, strict, torque, flight or stopped-by.")
    ] = "plannable",
    at: Annotated[
        list[str] | None,
        typer.Option(
            metavar="AXIS=VALUE",
            help="Nearest slice, as height=0.1 or twist=90 (deg); repeatable [default: all].",
        ),
    ] = None,
    intervals: _Intervals = False,
    as_json: options.AsJson = False,
) -> int:
    """Map what a robot can do: jumps over two of their axes, as a picture.

    Jumps are those of a sweep, or those that robots' tables of solved jumps were made from.
    """
    with console.result_stream(as_json=as_json) as stdout:
        from llsrbm.atlas.learned import learned_atlas
        from llsrbm.atlas.table import read_atlas

        if intervals:
            found = {name: _intervals(name, at or ()) for name in robot or [Jump().robot]}
            console.print_result({"robots": found}, _in_words(found), stdout, as_json=as_json)
            return console.DONE
        shown = _colour(colour)
        atlas = learned_atlas() if sweep is None else read_atlas(sweep)
        maps = [_map(jumps, x, y, shown, at or ()) for jumps in _groups(atlas, robot or ())]
        if out is not None:
            from llsrbm.atlas.picture import write_picture

            write_picture(maps, [_title(each.jumps) for each in maps], out)
        result = {"title": atlas.title, "maps": [_summary(each) for each in maps]}
        console.print_result(result, _description(result), stdout, as_json=as_json)
    return console.DONE


def _colour(name: str) -> Colour:
    from llsrbm.atlas.colours import COLOURS
    from llsrbm.request.messages import choices

    if name not in COLOURS:
        raise InputError(f'--colour: no "{name}"; {choices(name, COLOURS)}')
    return COLOURS[name]


def _groups(atlas: Atlas, robots: Sequence[str]) -> list[Jumps]:
    from llsrbm.request.messages import choices

    for name in robots:
        if name not in atlas.robots:
            raise InputError(f'--robot: no jumps of "{name}"; {choices(name, atlas.robots)}')
    return [jumps for jumps in atlas.groups if not robots or jumps.robot in robots]


def _map(jumps: Jumps, x: str, y: str, colour: Colour, at: Sequence[str]) -> Map:
    from llsrbm.atlas.map import ALL, NEAREST, map_of

    across, up = _axis(jumps, "--x", x), _axis(jumps, "--y", y)
    if across.name == up.name:
        raise InputError(f'--x and --y: both are "{x}"; expected two different axes')
    slices = dict(_value(text, lambda name: _axis(jumps, "--at", name)) for text in at)
    how = NEAREST if at else ALL
    return map_of(jumps, across, up, colour, projection=how, design=slices)


def _axis(jumps: Jumps, option: str, name: str) -> Axis:
    from llsrbm.request.messages import choices

    axes = {axis.name: axis for axis in jumps.axes}
    if len(axes) < 2:
        raise InputError(
            f"{jumps.robot}: the sweep varies {', '.join(axes) or 'nothing'}; expected two axes"
        )
    if name not in axes:
        raise InputError(
            f'{option}: the sweep of {jumps.robot} has no axis "{name}"; {choices(name, axes)}'
        )
    return axes[name]


def _value(text: str, axis_of: Callable[[str], Axis]) -> tuple[str, float]:
    """Name and SI value of AXIS=VALUE."""
    name, _, value = text.partition("=")
    axis = axis_of(name)
    try:
        number = float(value)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise InputError(f'--at: expected AXIS=VALUE with a number, got "{text:.80}"')
    return name, number / axis.scale


def _title(jumps: Jumps) -> str:
    from llsrbm.errors import Error
    from llsrbm.robots import load_robot

    try:
        return load_robot(jumps.robot).file.title
    except Error:  # of another machine: its name is enough
        return jumps.robot


def _intervals(name: str, at: Sequence[str]) -> dict[str, Any]:
    """The fields of a robot's request with what can be planned; or why it is not known."""
    from llsrbm.atlas.tracks import tracks, why_unknown
    from llsrbm.planning.problem.placement import make_task
    from llsrbm.robots import load_robot

    jump, limits = _at(name, at)
    robot = load_robot(name)
    make_task(jump, robot, None, limits)  # checks names and amounts
    return {
        "unknown": why_unknown(jump, limits, robot),
        "intervals": {
            field: track.intervals for field, track in tracks(jump, limits, robot).items()
        },
    }


def _at(robot: str, at: Sequence[str]) -> tuple[Jump, dict[str, float]]:
    from llsrbm.atlas.jumps import axis_of
    from llsrbm.request.jump import COMPONENTS
    from llsrbm.request.messages import choices
    from llsrbm.sweep.rows import LIMIT

    values: dict[str, Any] = {}
    limits: dict[str, float] = {}
    for text in at:
        name, number = _value(text, axis_of)
        if name.startswith(LIMIT):
            limits[name.removeprefix(LIMIT)] = number
        elif name in COMPONENTS:
            values[name] = number
        else:
            raise InputError(f'--at: "{name}"; {choices(name, (*COMPONENTS, LIMIT + "friction"))}')
    return Jump(robot=robot, **values), limits


def _in_words(found: dict[str, Any]) -> dict[str, str]:
    from llsrbm.atlas.jumps import axis_of
    from llsrbm.number_text import short

    lines = {}
    for robot, each in found.items():
        if each["unknown"]:
            lines[robot] = f"nothing is known {each['unknown']}"
        for field, intervals in each["intervals"].items():
            axis = axis_of(field)
            parts = [" to ".join(short(axis.scale * end, 3) for end in ends) for ends in intervals]
            lines[f"{robot} {field}"] = f"{' and '.join(parts) or 'nowhere'} {axis.unit}"
    return lines


def _summary(drawn: Map) -> dict[str, Any]:
    jumps = drawn.jumps
    strict = jumps.strict[jumps.planned > 0] if jumps.simulated else None
    return {
        "robot": jumps.robot,
        "model": jumps.model,
        "type": jumps.type,
        "axes": [axis.name for axis in jumps.axes],
        "jumps": len(jumps),
        "plannable_share": float(jumps.planned.mean()),
        "strict_share": None if strict is None or not len(strict) else float(strict.mean()),
        "border": [line.tolist() for line in drawn.border],
    }


def _description(result: dict[str, Any]) -> dict[str, str]:
    from llsrbm.number_text import percent

    lines = {"sweep": result["title"]}
    for found in result["maps"]:
        strict = found["strict_share"]
        line = f"{found['jumps']} jumps, {percent(found['plannable_share'])} plannable"
        if strict is not None:
            line += f", of these {percent(strict)} land by the strict measure"
        name = f"{found['robot']} {found['model']} {found['type']} "
        lines[name] = f"{line}; axes: {', '.join(found['axes'])}"
    return lines
