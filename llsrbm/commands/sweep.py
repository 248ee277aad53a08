"""`llsrbm sweep` and `llsrbm dataset`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from llsrbm.commands import console, options
from llsrbm.errors import InputError, require

if TYPE_CHECKING:
    from llsrbm.sweep.folder import Folder
    from llsrbm.sweep.points import Points
    from llsrbm.sweep.run import Progress


def sweep_command(
    spec: Annotated[
        str,
        typer.Argument(
            metavar="SPEC.toml", help="A spec's file, or a name: quick, anymal-10k, ..."
        ),
    ],
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Folder of the results.")],
    workers: Annotated[
        int | None,
        typer.Option(metavar="N", help="Processes on this machine [default: one a core]."),
    ] = None,
    scheduler: options.Scheduler = None,
    timeout: Annotated[
        float | None,
        typer.Option(
            metavar="SECONDS",
            help="Time a jump, simulations included [default: 300, and 30 for each simulation].",
        ),
    ] = None,
    draft: Annotated[
        bool, typer.Option("--draft", help="Centroidal plans alone, as `draft = true` of the spec.")
    ] = False,
    yes: Annotated[
        bool, typer.Option("--yes", help="Start a sweep of more than a million rows.")
    ] = False,
    as_json: options.AsJson = False,
) -> int:
    """Plan, and simulate, many jumps; DIR/jumps.parquet has a row of each.

    Plans that are not certified are rows and no more, unless drafts are asked for.
    A sweep that was cut off goes on where it was: run the same command again. Jumps that cannot be
    planned, or that time out, are rows too, and no failure of the sweep.
    """
    require("sweeps need Dask", "sweep", "distributed", "pyarrow")
    _check(workers, scheduler, timeout)
    with console.result_stream(as_json=as_json) as stdout:
        from llsrbm.processors import usable_processors
        from llsrbm.sweep.folder import Folder
        from llsrbm.sweep.points import Points
        from llsrbm.sweep.rows import origin
        from llsrbm.sweep.spec import find_spec

        found = find_spec(spec)
        points = Points(found.model_copy(update={"draft": True}) if draft else found)
        workers = workers or usable_processors()
        _announce(spec, points, None if scheduler else workers, large=yes)
        versions = origin(points.spec)
        with Folder(out, points, versions) as folder:
            _note_begun(folder)
            whole = folder.done.all()
            progress = None if whole else _run(folder, workers, scheduler, versions, timeout)
            result = _summary(folder, progress)
        console.print_result(result, _description(result), stdout, as_json=as_json)
    return console.DONE


def _check(workers: int | None, scheduler: str | None, timeout: float | None) -> None:
    if timeout is not None and not timeout > 0:
        raise InputError(f"--timeout {timeout:g}: expected a time above 0 (s)")
    options.check_workers(workers, scheduler)


def _announce(spec: str, points: Points, workers: int | None, *, large: bool) -> None:
    """Say what the sweep will take. Raises `InputError`: it is large, which was not confirmed."""
    from llsrbm.sweep.run import LARGE, estimate

    expected = estimate(points)
    _note(f"{points.spec.title}: {expected.line(workers)}")
    if expected.rows > LARGE and not large:
        raise InputError(
            f"{spec}: {expected.rows} rows are more than {LARGE}; expected --yes beside so "
            "large a sweep"
        )


def _note_begun(folder: Folder) -> None:
    """Say what an earlier run has left."""
    for name in folder.damaged:
        _note(f"{name} is damaged; its jumps are computed again")
    if folder.done.any():
        _note(f"going on: {int(folder.done.sum())} of {folder.points.count} jumps are done")


def _run(
    folder: Folder,
    workers: int,
    scheduler: str | None,
    versions: dict[str, str],
    timeout: float | None,
) -> Progress:
    from llsrbm.sweep.run import GO_ON, connected, default_limit, run

    try:
        with connected(workers, scheduler) as client, console.counting("jumps") as count:
            _note(f"dashboard: {client.dashboard_link}")
            return run(
                folder,
                client,
                versions,
                limit=timeout or default_limit(folder.points.spec),
                progress=lambda news: count(news.done, news.jumps),
                note=_note,
            )
    except KeyboardInterrupt:
        _note(f"interrupted; {GO_ON}")
        raise


def _note(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


def _summary(folder: Folder, progress: Progress | None) -> dict[str, Any]:
    import pyarrow.dataset

    robots: dict[str, dict[str, int]] = {}
    table = pyarrow.dataset.dataset(folder.table)
    for batch in table.to_batches(columns=["robot", "status", "landed", "strict"]):
        for row in batch.to_pylist():
            counts = robots.setdefault(row["robot"], {"rows": 0})
            counts["rows"] += 1
            for name in (row["status"], *(n for n in ("landed", "strict") if row[n])):
                counts[name] = counts.get(name, 0) + 1
    run = None
    if progress is not None:
        run = {
            "jumps": progress.done - progress.begun_at,
            "workers": progress.workers,
            "seconds": progress.seconds,
            "jumps_per_second": progress.rate,
            "planning_s": progress.planning,
            "simulating_s": progress.simulating,
            "busy_share": progress.busy,
        }
    return {
        "table": str(folder.table),
        "title": folder.points.spec.title,
        "jumps": folder.points.count,
        "rows": folder.points.rows,
        "robots": robots,
        "run": run,
    }


def _description(result: dict[str, Any]) -> dict[str, str]:
    from llsrbm.number_text import duration

    lines = {}
    for robot, counts in result["robots"].items():
        parts = (f"{count} {name}" for name, count in counts.items() if name != "rows")
        lines[f"{robot} "] = f"{counts['rows']} rows: {', '.join(parts)}"
    run = result["run"]
    if run is not None:
        lines["run"] = (
            f"{run['jumps']} jumps in {duration(run['seconds'])}, "
            f"{run['jumps_per_second']:.1f} a second on {run['workers']} workers, which spent "
            f"{100 * run['busy_share']:.0f} % of it planning and simulating"
        )
    lines["table"] = result["table"]
    return lines


def dataset_command(
    sweep: Annotated[
        Path,
        typer.Argument(metavar="DIR", help="Folder that `llsrbm sweep` wrote, with simulations."),
    ],
    format_: Annotated[
        str,
        typer.Option("--format", metavar="F", help="lerobot, or one of `llsrbm formats`."),
    ],
    out: Annotated[Path, typer.Option(metavar="OUT", help="Folder of the data set.")],
    robot: Annotated[str | None, typer.Option(help="Motions of this robot alone.")] = None,
    source: Annotated[
        str, typer.Option(help="rollout: what the robot did; plan: what was planned.")
    ] = "rollout",
    limit: Annotated[int | None, typer.Option(metavar="N", help="Motions at most.")] = None,
    fps: Annotated[
        float | None, typer.Option(help="Frames per second [default: the format's own].")
    ] = None,
    as_json: options.AsJson = False,
) -> int:
    """Write the strict jumps of a sweep as files for training, with an index.

    Motions are computed again from the sweep's table. A data set that was cut off goes on where it
    was: run the same command again.
    """
    with console.result_stream(as_json=as_json) as stdout:
        from llsrbm.sweep.dataset import make_dataset

        with console.counting("motions") as progress:
            done = make_dataset(
                sweep,
                out,
                format_,
                robot=robot,
                source=source,
                limit=limit,
                fps=fps,
                progress=progress,
            )
        if done.left_out:
            console.print_error(
                f"{len(done.left_out)} rows are not strict when computed again, and are left out: "
                f"{', '.join(map(str, done.left_out[:10]))}"
            )
        result = {
            "motions": done.motions,
            "computed": done.computed,
            "left_out": list(done.left_out),
            "index": str(done.index),
        }
        motions = f"{done.motions}, of them {done.computed} computed now"
        lines = {"motions": motions, "index": str(done.index)}
        console.print_result(result, lines, stdout, as_json=as_json)
    return console.DONE
