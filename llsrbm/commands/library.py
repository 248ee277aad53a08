"""`llsrbm library`: certified motions that are found by words, opened, exported and made."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperGroup

from llsrbm.commands import console, options
from llsrbm.errors import require

if TYPE_CHECKING:
    from llsrbm.library import Library
    from llsrbm.library.attempt import Attempt
    from llsrbm.library.build import Runner

_LIST = "list"


class _Words(TyperGroup):
    """A group of commands whose first word may be one to look for: `llsrbm library go2 flip`."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        if not args or args[0] not in (*self.commands, "-h", "--help"):
            args = [_LIST, *args]
        return super().parse_args(ctx, args)


library_app = typer.Typer(name="library", cls=_Words, rich_markup_mode=None)

Folder = Annotated[
    Path | None,
    typer.Option("--dir", metavar="DIR", help="A library's folder [default: the one that ships]."),
]
Name = Annotated[str, typer.Argument(metavar="NAME", help="A motion's name; `llsrbm library`.")]
Out = Annotated[Path, typer.Option("--out", metavar="DIR", help="Folder of the library.")]
Seeds = Annotated[
    int, typer.Option(min=0, max=1000, help="Simulations of a motion, all of which be strict.")
]


@library_app.callback()
def _library() -> None:
    """Certified motions: found by words and figures, shown, exported, and made."""


def _opened(folder: Path | None) -> Library:
    from llsrbm.library import Library, shipped

    return shipped() if folder is None else Library(folder)


@library_app.command("build")
def build_command(
    out: Out,
    robots: Annotated[str, typer.Option(metavar="R,...", help="Names of robots, or all.")] = "all",
    count: Annotated[
        int, typer.Option(metavar="N", min=0, help="Motions in all, as many of each robot.")
    ] = 100,
    requests: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Also those of a JSON list of requests, as `plan --json` has one.",
        ),
    ] = None,
    seeds: Seeds = 2,
    workers: options.Workers = None,
    scheduler: options.Scheduler = None,
    as_json: options.AsJson = False,
) -> int:
    """Make a library: draw requests, plan, check and simulate them, keep those that hold.

    A motion is kept if its certificate holds and every simulation of it is strict. A build that was
    cut off goes on where it was: run the same command again. With a higher count, more are added.
    """
    options.check_workers(workers, scheduler)
    with console.result_stream(as_json=as_json) as stdout:
        from llsrbm.library.build import Build, in_turn, on_workers, read_requests

        names = _robots(robots)
        given = [] if requests is None else read_requests(requests)
        build = Build(out)
        total = count + len(given)

        def all_requests() -> Any:
            yield from given
            yield from build.draws(names, count)

        with console.counting("motions") as progress:

            def note(_: Attempt) -> None:
                progress(len(build.library.cards), total)

            def run(runner: Runner) -> Any:
                return build.run(all_requests(), seeds, runner, note)

            if scheduler is None and (workers or 1) == 1:
                counts = run(in_turn)
            else:
                require("builds on several workers need Dask", "sweep", "distributed", "pyarrow")
                from llsrbm.sweep.run import connected

                with connected(workers or 1, scheduler) as client:
                    counts = run(on_workers(client))
        result = _packed(build.library) | {"tried": dict(sorted(counts.items()))}
        console.print_result(result, _made(result), stdout, as_json=as_json)
    return console.DONE


def _robots(names: str) -> list[str]:
    from llsrbm.request.messages import look_up
    from llsrbm.robots.schema import robot_files

    known = robot_files()
    if names == "all":
        return list(known)
    for name in names.split(","):
        look_up("robot", name, known)
    return names.split(",")


def _packed(library: Library) -> dict[str, Any]:
    from llsrbm.library.description import write_description

    library.packed()
    return write_description(library)


def _made(result: dict[str, Any]) -> dict[str, str]:
    done = result["simulations"]
    robots = (f"{own['motions']} of {robot}" for robot, own in result["robots"].items())
    tried = (f"{number} {status}" for status, number in result["tried"].items())
    return {
        "Motions": f"{result['motions']}: {', '.join(robots)}",
        "Certified": f"{result['certified']} of {result['motions']}",
        "Strict": f"{done['strict']} of {done['seeds']} simulations",
        "Tried now": ", ".join(tried) or "nothing",
        "Size": f"{sum(file['bytes'] for file in result['files']) / 1e6:.1f} MB",
    }
