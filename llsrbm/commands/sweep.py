"""`llsrbm sweep`."""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from llsrbm.commands import console, options
from llsrbm.errors import InputError

if TYPE_CHECKING:
    from llsrbm.sweep.run import Progress
    from llsrbm.sweep.table import Folder

_LINE_TIME = 30.0  # s between lines where there is no terminal


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
    scheduler: Annotated[
        str | None,
        typer.Option(metavar="ADDRESS", help="A Dask scheduler that runs: tcp://host:8786."),
    ] = None,
    yes: Annotated[bool, typer.Option("--yes", help="Begin, however large it is.")] = False,
    as_json: options.AsJson = False,
) -> int:
    """Plan, and simulate, many jumps; DIR/jumps.parquet has a row of each.

    A sweep that was cut off goes on where it was: run the same command again. Jumps that cannot be
    planned are rows too, and no failure of the sweep.
    """
    if workers is not None and workers < 1:
        raise InputError(f"--workers {workers}: expected 1 or more")
    if workers is not None and scheduler is not None:
        raise InputError(
            "--workers and --scheduler: expected one of them; a cluster that runs has its workers"
        )
    with console.result_stream(as_json=as_json) as stdout:
        from llsrbm.sweep.estimate import LARGE, estimate
        from llsrbm.sweep.points import Points
        from llsrbm.sweep.shard import origin
        from llsrbm.sweep.spec_file import find_spec
        from llsrbm.sweep.table import Folder

        points = Points(find_spec(spec))
        workers = workers or os.cpu_count() or 1
        expected = estimate(points)
        _say(f"{points.spec.title}: {expected.in_words(None if scheduler else workers)}")
        if expected.rows > LARGE and not yes:
            raise InputError(
                f"{spec}: {expected.rows} rows are more than {LARGE}; expected --yes beside so "
                "large a sweep"
            )
        of = origin(points.spec)
        with Folder(out, points, of) as folder:
            for name in folder.damaged:
                _say(f"{name} is damaged; its jumps are computed again")
            if folder.done.any():
                _say(f"going on: {int(folder.done.sum())} of {points.count} jumps are done")
            progress = None if folder.done.all() else _run(folder, workers, scheduler, of)
            folder.finish()
            result = _summary(folder, progress)
        if as_json:
            print(json.dumps(result, allow_nan=False), file=stdout)
        else:
            console.print_lines(_description(result), stdout)
    return console.DONE


def _run(folder: Folder, workers: int, scheduler: str | None, origin: dict[str, str]) -> Progress:
    from llsrbm.sweep.run import GO_ON, connected, run

    try:
        with connected(workers, scheduler) as client, _bar() as progress:
            _say(f"dashboard: {client.dashboard_link}")
            return run(folder, client, origin, progress=progress, told=_say)
    except KeyboardInterrupt:
        _say(f"interrupted; {GO_ON}")
        raise


def _say(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


@contextmanager
def _bar() -> Iterator[Callable[[Progress], None]]:
    """A bar for a person, a line now and then for a log."""
    if not sys.stderr.isatty():
        yield _lines()
        return
    from rich import progress as rich
    from rich.console import Console

    columns = (
        rich.BarColumn(),
        rich.MofNCompleteColumn(),
        rich.TextColumn("{task.fields[rate]}"),
    )
    with rich.Progress(*columns, console=Console(stderr=True)) as bar:
        task = bar.add_task("", total=None, rate="")

        def told(news: Progress) -> None:
            bar.update(task, total=news.jumps, completed=news.done, rate=_rate(news))

        yield told


def _lines() -> Callable[[Progress], None]:
    last = time.monotonic()

    def told(news: Progress) -> None:
        nonlocal last
        if time.monotonic() - last >= _LINE_TIME:
            last = time.monotonic()
            _say(f"{news.done} of {news.jumps} jumps, {_rate(news)}")

    return told


def _rate(news: Progress) -> str:
    from llsrbm.sweep.estimate import duration_in_words

    if not news.rate:
        return ""
    return f"{news.rate:.1f} a second, {duration_in_words(news.left)} left"


def _summary(folder: Folder, progress: Progress | None) -> dict[str, Any]:
    """The whole table in figures, and this run's times."""
    import pyarrow.parquet as pq

    robots: dict[str, dict[str, int]] = {}
    file = pq.ParquetFile(folder.table)
    for batch in file.iter_batches(columns=["robot", "status", "landed", "strict"]):
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
    from llsrbm.sweep.estimate import duration_in_words

    lines = {}
    for robot, counts in result["robots"].items():
        told = (f"{count} {name}" for name, count in counts.items() if name != "rows")
        lines[f"{robot} "] = f"{counts['rows']} rows: {', '.join(told)}"
    run = result["run"]
    if run is not None:
        lines["run"] = (
            f"{run['jumps']} jumps in {duration_in_words(run['seconds'])}, "
            f"{run['jumps_per_second']:.1f} a second on {run['workers']} workers, which spent "
            f"{100 * run['busy_share']:.0f} % of it planning and simulating"
        )
    lines["table"] = result["table"]
    return lines
