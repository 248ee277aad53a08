"""`llsrbm library`: certified motions that are found by words, opened, exported and made."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperGroup

from llsrbm.commands import console, options
from llsrbm.errors import InputError, require

if TYPE_CHECKING:
    from llsrbm.library import Card, Library
    from llsrbm.library.attempt import Attempt
    from llsrbm.library.build import Runner

_LIST = "list"
_WITH_GAINS = {"npz", "mujoco"}  # formats that have a place for them


class _Words(TyperGroup):
    """A group of commands whose first word may be one to look for: `llsrbm library go2 flip`."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        if not args or args[0] not in (*self.commands, "-h", "--help"):
            args = [_LIST, *args]
        return super().parse_args(ctx, args)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        return super().get_command(ctx, cmd_name) or super().get_command(ctx, _LIST)


library_app = typer.Typer(name="library", cls=_Words, rich_markup_mode=None)

Folder = Annotated[
    Path | None,
    typer.Option("--dir", metavar="DIR", help="A library's folder [default: the one that ships]."),
]
Name = Annotated[str, typer.Argument(metavar="NAME", help="A motion's name; `llsrbm library`.")]
Out = Annotated[Path, typer.Option("--out", metavar="DIR", help="Folder of the library.")]
Seeds = Annotated[
    int, typer.Option(min=0, max=1000, help="Simulations of a motion; all have to be strict.")
]


@library_app.callback()
def _library() -> None:
    """Certified motions: found by words and figures, shown, exported, and made."""


@library_app.command(_LIST)
def list_command(
    words: Annotated[
        list[str] | None,
        typer.Argument(metavar="[WORDS]", help="Parts of names, robots, kinds or jump types."),
    ] = None,
    robot: Annotated[str | None, typer.Option(metavar="R", help="Motions of this robot.")] = None,
    kind: Annotated[
        str | None, typer.Option(metavar="K", help="Motions of this kind: back-flip, route, ...")
    ] = None,
    min_distance: Annotated[
        float | None, typer.Option(metavar="M", help="Leads so far or further, horizontally.")
    ] = None,
    max_distance: Annotated[
        float | None, typer.Option(metavar="M", help="Leads no further.")
    ] = None,
    min_turn: Annotated[
        float | None, typer.Option(metavar="DEG", help="Turns so far or further, either way.")
    ] = None,
    min_height: Annotated[
        float | None, typer.Option(metavar="M", help="Lands so high above its start, or higher.")
    ] = None,
    min_flight: Annotated[
        float | None, typer.Option(metavar="S", help="Is so long in the air, or longer.")
    ] = None,
    max_power: Annotated[
        float | None, typer.Option(metavar="W", help="Its drives give no more power together.")
    ] = None,
    folder: Folder = None,
    as_json: options.AsJson = False,
) -> int:
    """List motions, or those that words and figures say: `llsrbm library go2 flip`.

    All words have to be found. `llsrbm library` alone lists all; `list` may be left out.
    """
    with console.result_stream(as_json=as_json) as stdout:
        from llsrbm.library import Filters

        filters = Filters(
            robot=robot,
            kind=kind,
            min_distance=min_distance,
            max_distance=max_distance,
            min_turn=None if min_turn is None else math.radians(min_turn),
            min_height=min_height,
            min_flight=min_flight,
            max_power=max_power,
        )
        library = _opened(folder)
        cards = library.found(words or [], filters)
        if as_json:
            result = {"count": len(cards), "motions": [card.summary() for card in cards]}
            console.print_result(result, {}, stdout, as_json=True)
        elif cards:
            print("\n".join(_table(cards)), file=stdout)
        else:
            console.print_error(f"no motion of {len(library.cards)} is so")
    return console.DONE


def _opened(folder: Path | None) -> Library:
    from llsrbm.library import Library, shipped

    if folder is None:
        return shipped()
    library = Library(folder)
    if not library.files:
        raise InputError(
            f"{folder}: no library is there; expected a folder that `llsrbm library build` or "
            "`llsrbm library add` has made"
        )
    return library


def _table(cards: Sequence[Card]) -> list[str]:
    from llsrbm.number_text import aligned, decimal, degrees

    head = ("name", "leads", "turns", "up", "in the air", "power", "torque", "strict")
    rows = [head]
    for card in cards:
        figures, done = card.figures, card.simulated
        rows.append(
            (
                card.name,
                f"{decimal(figures.distance_m, 2)} m",
                degrees(figures.turn, 0),
                f"{decimal(figures.height_m, 2)} m",
                f"{decimal(figures.flight_s, 2)} s",
                f"{decimal(figures.peak_power_w)} W",
                f"{decimal(100 * figures.torque_share)} %",
                f"{done.strict} of {done.seeds}",
            )
        )
    return aligned(rows)


@library_app.command("show")
def show_command(
    name: Name,
    folder: Folder = None,
    stated: Annotated[
        bool, typer.Option("--stated", help="The certificate of its card, not checked again.")
    ] = False,
    as_json: options.AsJson = False,
) -> int:
    """Show one motion: its request, figures, and the certificate, which is checked again.

    The exit status is 1 where a check does not hold.
    """
    with console.result_stream(as_json=as_json) as stdout:
        from llsrbm.certificate import stated as stated_certificate
        from llsrbm.commands.check import certificate_table

        library = _opened(folder)
        card = library.card(name)
        plan = library.open(name, check=not stated)
        certificate = stated_certificate(plan)
        assert certificate is not None  # a motion's card has one
        if as_json:
            result = {
                **card.summary(),
                "request": card.request.as_dict(),
                "checked_again": not stated,
                "holds": certificate.holds,
                "certificate": certificate.as_dict(),
            }
            console.print_result(result, {}, stdout, as_json=True)
        else:
            lines = [*_table([card]), options.in_words(card.request)]
            print("\n".join([*lines, *certificate_table(certificate)]), file=stdout)
    return console.DONE if certificate.holds else console.FAILED


@library_app.command("export")
def export_motion_command(
    context: typer.Context,
    name: Name,
    out: options.Exported,
    format_: options.Formats,
    folder: Folder = None,
    fps: options.FrameRate = 60.0,
    pad: options.Pad = 0.0,
    order: options.Order = "depth-first",
) -> int:
    """Write a motion in other formats, with its feed-forward torques.

    Its certificate is checked again. `npz` and `mujoco` carry the gains of its feedback, too; the
    folder for MuJoCo has a script that replays it by them. For simulations and films, write it as
    `npz` and go on from there.
    """
    import llsrbm

    given = options.given(context, fps=fps, pad=pad, order=order)
    plan = _opened(folder).open(name)
    if not plan.certified:
        console.print_error(
            f"{name}: its certificate does not hold any more; `library show {name}`"
        )
    if not _WITH_GAINS.isdisjoint(format_):
        plan = llsrbm.with_feedback(plan)
    llsrbm.export(plan, out, format=format_, **given)
    return console.DONE


@library_app.command("add")
def add_command(
    plans: Annotated[
        list[Path], typer.Argument(metavar="PLAN.npz", help="Files of whole bodies' plans.")
    ],
    out: Out,
    seeds: Seeds = 2,
    not_strict: Annotated[
        bool,
        typer.Option(
            "--not-strict",
            help="Also those that are not strict in all simulations; cards say in how many.",
        ),
    ] = False,
    as_json: options.AsJson = False,
) -> int:
    """Add plans to a library: certified ones, of which every simulation is strict.

    The exit status is 1 if one was not added, with the reason on stderr.
    """
    status = console.DONE
    with console.result_stream(as_json=as_json) as stdout:
        from llsrbm.library import Library
        from llsrbm.library.attempt import judged

        library = Library(out)
        added = []
        for file in plans:
            try:
                added.append(
                    library.put(judged(options.read_plan(file), seeds, not_strict=not_strict)).name
                )
            except InputError as error:
                console.print_error(f"{file}: {error}")
                status = console.FAILED
        result = _packed(library) | {"added": added}
        lines = {"Added": ", ".join(added) or "none", "Motions": str(result["motions"])}
        console.print_result(result, lines, stdout, as_json=as_json)
    return status


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
    mirror: Annotated[
        bool,
        typer.Option("--mirror", help="Then also their images in a mirror: left jumps right."),
    ] = False,
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
        from llsrbm.library.build import Build, read_requests

        names = _robots(robots)
        given = [] if requests is None else read_requests(requests)
        build = Build(out)
        total = count + len(given)

        def all_requests() -> Any:
            yield from given
            yield from build.draws(names, count)
            if mirror:
                yield from build.images(names)

        with console.counting("motions") as progress:

            def note(_: Attempt) -> None:
                done = sum(map(build.kept, names))
                progress(done, max(done, total))

            counts = _run(
                lambda runner: build.run(all_requests(), seeds, runner, note), workers, scheduler
            )
        build.close()
        result = _packed(build.library) | {"tried": dict(sorted(counts.items()))}
        console.print_result(result, _made(result), stdout, as_json=as_json)
    return console.DONE


def _run(
    run: Callable[[Runner], dict[str, int]], workers: int | None, scheduler: str | None
) -> dict[str, int]:
    """Run a build in this process, or on workers or a cluster."""
    from llsrbm.library.build import in_turn, on_workers

    if scheduler is None and (workers or 1) == 1:
        return run(in_turn)
    require("builds on several workers need Dask", "sweep", "distributed", "pyarrow")
    from llsrbm.sweep.run import connected

    with connected(workers or 1, scheduler) as client:
        return run(on_workers(client))


@library_app.command("site")
def site_command(
    out: Annotated[Path, typer.Argument(metavar="DIR", help="Folder of the site.")],
    folder: Folder = None,
) -> int:
    """Write a site that opens from disk: a list with filters, and a page a motion.

    A motion's page has its player, figures, certificate and files. DIR is made, or is one that this
    wrote before.
    """
    from llsrbm.library.site import write_site

    with console.counting("pages") as progress:
        write_site(_opened(folder), out, progress)
    print(out / "index.html")
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

    library.folder.mkdir(parents=True, exist_ok=True)  # there is none where nothing was kept
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
