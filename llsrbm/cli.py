"""The command line: `llsrbm plan | export | robots | models | formats`, and what others add.

Exit status: 0 done, 1 it ran and failed, 2 bad input with one line on stderr. Heavy imports happen
inside the commands, so that `llsrbm --help` answers at once.
"""

from __future__ import annotations

import contextlib
import json
import math
import os
import sys
from collections.abc import Iterator, Sequence
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TextIO

import typer
from typer.core import TyperGroup

from llsrbm.errors import Error, InputError, NotConverged

if TYPE_CHECKING:
    from llsrbm.trajectory.plan import Plan

DONE, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130

_PLUGINS = "llsrbm.commands"  # entry points that add commands, e.g. `serve` of the application


class _Commands(TyperGroup):
    """The commands of this module, and those of other packages, loaded when they are used."""

    def list_commands(self, ctx: Any) -> list[str]:
        return [*super().list_commands(ctx), *(name for name in _plugins())]

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        command = super().get_command(ctx, cmd_name)
        if command is None and cmd_name in _plugins():
            command = _load(_plugins()[cmd_name])
        if command is None:
            names = ", ".join(self.list_commands(ctx))
            raise InputError(f'no command "{cmd_name}"; the commands are {names}')
        return command


app = typer.Typer(
    name="llsrbm",
    cls=_Commands,
    help="Plan jumps of legged robots with lump-leg single rigid body models.",
    epilog="Exit status: 0 done, 1 it ran and failed, 2 bad input.",
    add_completion=False,
    invoke_without_command=True,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)


@app.callback()
def _llsrbm(
    context: typer.Context,
    version: Annotated[bool, typer.Option("--version", help="Print the version.")] = False,
) -> None:
    if version:
        from llsrbm.version import package_version

        print(package_version())
        raise typer.Exit(DONE)
    if context.invoked_subcommand is None:
        print(context.get_help())


@app.command("plan")
def plan_command(
    robot: Annotated[
        str, typer.Option(help="A name (see `llsrbm robots`) or the path of a robot file.")
    ] = "anymal",
    model: Annotated[str, typer.Option(help="See `llsrbm models`.")] = "llsrbm-plus",
    twist: Annotated[float, typer.Option(metavar="DEG", help="Turn to the left.")] = 0.0,
    forward: Annotated[float, typer.Option(metavar="M", help="Displacement along x.")] = 0.0,
    lateral: Annotated[float, typer.Option(metavar="M", help="Displacement to the left.")] = 0.0,
    height: Annotated[float, typer.Option(metavar="M", help="Of the landing surface.")] = 0.0,
    solver: Annotated[str, typer.Option(help="fatrop or ipopt.")] = "fatrop",
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write the plan here (npz).")
    ] = None,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print one JSON object on stdout, the rest on stderr.")
    ] = False,
) -> int:
    """Plan one jump from standing to standing.

    A plan that does not converge is written all the same, and the exit status is 1.
    """
    with _stdout_kept_for_result() if as_json else _plain_stdout() as stdout:
        import llsrbm
        from llsrbm.trajectory.summary import plan_summary

        jump = llsrbm.Jump(
            robot=robot,
            model=model,
            twist=math.radians(twist),
            forward=forward,
            lateral=lateral,
            height=height,
        )
        status, failure = DONE, None
        try:
            plan = llsrbm.plan(jump, solver=solver, progress=_progress)
        except NotConverged as error:
            plan, status, failure = error.plan, FAILED, error
        if out is not None:
            plan.save(out)
        if as_json:
            print(json.dumps(plan_summary(plan), allow_nan=False), file=stdout)
        else:
            _describe(plan, stdout)
        if failure is not None:
            _complain(str(failure))
    return status


@app.command("export")
def export_command(
    file: Annotated[Path, typer.Argument(metavar="FILE.npz", help="A native file.")],
    out: Annotated[Path, typer.Option(metavar="FILE", help="The file to write.")],
    format_: Annotated[str, typer.Option("--format", metavar="F", help="See `llsrbm formats`.")],
    fps: Annotated[float, typer.Option(help="Frames per second, for formats with a rate.")] = 60.0,
) -> int:
    """Write a native file in another format."""
    from llsrbm.exporters import export
    from llsrbm.trajectory.files import load

    export(load(file), out, format=format_, fps=fps)
    return DONE


@app.command("robots")
def robots_command() -> int:
    """List the robots that come with the project."""
    from llsrbm.robots import read_robot_file
    from llsrbm.robots.assets import robot_files

    _print_table({name: read_robot_file(path).title for name, path in robot_files().items()})
    return DONE


@app.command("models")
def models_command() -> int:
    """List the models that a planner can believe in."""
    from llsrbm import models

    _print_table(models.describe())
    return DONE


@app.command("formats")
def formats_command() -> int:
    """List the formats that `llsrbm export` writes."""
    from llsrbm.exporters import formats

    _print_table(formats())
    return DONE


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command line and return its exit status.

    Args:
        arguments: without the program's name; default: the process's own.
    """
    command = typer.main.get_command(app)
    try:
        status = command.main(
            args=None if arguments is None else list(arguments),
            prog_name="llsrbm",
            standalone_mode=False,
        )
        sys.stdout.flush()
    except typer.TyperException as error:  # what typer says about options and arguments
        _complain(error.format_message())
        return error.exit_code
    except InputError as error:
        _complain(str(error))
        return BAD_INPUT
    except Error as error:
        _complain(str(error))
        return FAILED
    except (KeyboardInterrupt, typer.Abort):
        return INTERRUPTED
    except BrokenPipeError:
        # Whoever read stdout has gone (`llsrbm models | head -1`); Python's own flush at exit would
        # complain about it.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return FAILED
    return status if isinstance(status, int) else DONE


def _complain(message: str) -> None:
    print(f"llsrbm: {' '.join(message.split())}", file=sys.stderr)


def _progress(message: str) -> None:
    """Tell a waiting person; a script's stderr is for what is wrong."""
    if sys.stderr.isatty():
        print(message, file=sys.stderr)


def _plugins() -> dict[str, EntryPoint]:
    return {point.name: point for point in sorted(entry_points(group=_PLUGINS))}


def _load(point: EntryPoint) -> Any:
    """The command that another package registered: a function as typer takes them."""
    try:
        function = point.load()
    except (ImportError, AttributeError) as error:
        raise Error(f'command "{point.name}" ({point.value}) cannot be loaded: {error}') from error
    single = typer.Typer(
        add_completion=False,
        rich_markup_mode=None,
        context_settings={"help_option_names": ["-h", "--help"]},
    )
    single.command(point.name)(function)
    return typer.main.get_command(single)


@contextlib.contextmanager
def _plain_stdout() -> Iterator[TextIO]:
    yield sys.stdout


@contextlib.contextmanager
def _stdout_kept_for_result() -> Iterator[TextIO]:
    """Send everything that is printed, compiled libraries' banners included, to stderr.

    Yields:
        The real stdout.
    """
    sys.stdout.flush()
    kept = os.dup(1)
    os.dup2(2, 1)
    try:
        with (
            os.fdopen(os.dup(kept), "w", encoding="utf-8") as stdout,
            contextlib.redirect_stdout(sys.stderr),
        ):
            yield stdout
    finally:
        os.dup2(kept, 1)
        os.close(kept)


def _print_table(rows: dict[str, str]) -> None:
    width = max(len(name) for name in rows)
    for name, description in rows.items():
        print(f"{name:{width}}  {description}")


def _describe(plan: Plan, stdout: TextIO) -> None:
    """A plan in a few lines for a person: degrees, milliseconds."""
    from llsrbm.joint_margins import joint_margins
    from llsrbm.robots import load_robot
    from llsrbm.trajectory.summary import peak_yaw_rate, worst_violation, yaw

    jump, report = plan.jump, plan.report
    takeoff, flight, landing = plan.phase_start[1:] - plan.phase_start[:-1]
    lines = {
        "request": f"{jump.robot}, {jump.model}: twist {math.degrees(jump.twist):.0f} deg, forward "
        f"{jump.forward:.2f} m, lateral {jump.lateral:.2f} m, height {jump.height:.2f} m",
        "solver": f"{report.status} by {report.solver} in {report.iterations} iterations, "
        f"{1e3 * report.solve_time_s:.0f} ms ({1e3 * report.total_time_s:.0f} ms from request to "
        f"plan, {report.build_time_s:.2f} s to build the solver)",
        "duration": f"{plan.duration:.2f} s: take-off {takeoff:.2f}, flight {flight:.2f}, "
        f"landing {landing:.2f} s",
        "turn": f"{math.degrees(yaw(plan)[-1]):.1f} deg, peak yaw rate {peak_yaw_rate(plan):.2f} "
        "rad/s",
        "joints": joint_margins(plan, load_robot(jump.robot)).worst(),
        "violation": worst_violation(plan),
    }
    for name, value in lines.items():
        print(f"{name:<10}{value}", file=stdout)


if __name__ == "__main__":
    sys.exit(main())
