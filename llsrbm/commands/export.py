"""`llsrbm export`, `llsrbm replay` and `llsrbm formats`."""

from __future__ import annotations

import math
import tempfile
import webbrowser
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from llsrbm.commands import console, options
from llsrbm.errors import InputError

if TYPE_CHECKING:
    from llsrbm.formats import Format
    from llsrbm.robots import Robot

FormatName = typer.Option("--format", metavar="F", help="See `llsrbm formats`.")


def export_command(
    context: typer.Context,
    file: Annotated[Path, typer.Argument(metavar="FILE.npz", help="A native file.")],
    out: options.Exported,
    format_: options.Formats,
    fps: options.FrameRate = 60.0,
    pad: options.Pad = 0.0,
    order: options.Order = "depth-first",
    size: options.Size = "960x540",
    camera: Annotated[
        str,
        typer.Option(
            metavar="A,E,D", help="Camera of a video: azimuth, elevation [deg], distance [m]."
        ),
    ] = "",
    packed: Annotated[
        bool, typer.Option("--packed", help="Also write the robot's own messages, packed.")
    ] = False,
) -> int:
    """Write a native file, a plan's or a rollout's, in other formats.

    Options that are left out are as each format has them; see `llsrbm formats --format F`.
    """
    from llsrbm.certificate import certified
    from llsrbm.formats import export, remarks_of
    from llsrbm.motion.trajectory import load

    given = options.given(context, fps=fps, pad=pad, order=order, packed=packed)
    if options.is_given(context, "size"):
        pixels = _numbers("--size", size, "x", 2)
        given["size"] = tuple(int(n) if n.is_integer() else n for n in pixels)
    if options.is_given(context, "camera"):
        given["camera"] = _numbers("--camera", camera, ",", 3)
    trajectory = load(file)
    console.print_remarks(remarks_of(trajectory))
    export(certified(trajectory), out, format=format_, **given)
    return console.DONE


def replay_command(
    file: Annotated[Path, typer.Argument(metavar="FILE.npz", help="A native file.")],
    out: Annotated[
        Path | None,
        typer.Option(metavar="FILE.html", help="Where to; default: a temporary file."),
    ] = None,
    open_: Annotated[
        bool, typer.Option("--open/--no-open", help="Open it in the default browser.")
    ] = True,
) -> int:
    """Look at a plan or a rollout in the browser: one page, without a server.

    Prints the page's path. It stays where it is and may be passed on.
    """
    from llsrbm.formats import export, file_name, remarks_of
    from llsrbm.motion.trajectory import load

    trajectory = load(file)
    console.print_remarks(remarks_of(trajectory))
    if out is None:
        out = Path(tempfile.mkdtemp(prefix="llsrbm-")) / file_name(trajectory, ["html"])
    export(trajectory, out, format="html")
    out = out.resolve()
    print(out)
    if open_ and not webbrowser.open(out.as_uri()):
        console.print_error(f"no browser was found; expected one that opens {out}")
        return console.FAILED
    return console.DONE


def formats_command(
    format_: Annotated[str | None, FormatName] = None,
    robot: Annotated[
        str | None,
        typer.Option(metavar="R", help="Also name the formats that this robot has no files of."),
    ] = None,
) -> int:
    """List the formats that `llsrbm export` writes by their purpose, or the conventions of one.

    A format that cannot be written here, or of the robot, has the reason behind it.
    """
    from llsrbm.formats import FORMATS, find
    from llsrbm.robots import load_robot

    loaded = None if robot is None else load_robot(robot)
    if format_ is None:
        rows = {n: f"{each.purpose.value}: {_title(each, loaded)}" for n, each in FORMATS.items()}
        console.print_table(rows)
    else:
        for line in _facts(find(format_), loaded):
            print(line)
    return console.DONE


def _facts(format_: Format, robot: Robot | None) -> list[str]:
    from llsrbm.formats.table import quantity_rows

    lines = [f"{format_.name}: {_title(format_, robot)}", ""]
    lines += format_.conventions.strip().splitlines()
    taken = [f"{name} (default {getattr(format_.defaults, name)})" for name in format_.options]
    reads = "yes, for looking and comparing" if format_.read is not None else "no"
    if format_.name == "npz":
        reads = "yes"
    lines += [
        "",
        f"purpose       {format_.purpose.value}",
        f"name ends in  {format_.suffix or '(a folder)'}",
        f"holds         plan, rollout{', motion' if format_.write_motion else ''}",
        f"options       {', '.join(taken) or 'none'}",
        f"can be opened {reads}",
    ]
    return lines + (quantity_rows() if format_.name in ("npz", "csv") else [])


def _title(format_: Format, robot: Robot | None) -> str:
    from llsrbm.formats import availability

    reason = availability(format_, robot)
    return f"{format_.title} ({reason})" if reason else format_.title


def _numbers(option: str, given: str, separator: str, count: int) -> tuple[float, ...]:
    try:
        numbers = tuple(float(part) for part in given.split(separator))
    except ValueError:
        numbers = ()
    if len(numbers) != count or not all(map(math.isfinite, numbers)):
        raise InputError(
            f"{option} {given}: expected {count} numbers separated by {separator!r}"
        ) from None
    return numbers
