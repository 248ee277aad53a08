"""The cost of sweeps, and their faults: each measurement is a command.

    python -m benchmarks.sweeps deaths --jumps 300 --kills 10
    python -m benchmarks.sweeps scheduler --jumps 200
    python -m benchmarks.sweeps disk --jumps 200           (as root: it mounts a small tmpfs)
    python -m benchmarks.sweeps scaling --jumps 100,1000,10000
    python -m benchmarks.sweeps workers --sweep anymal-10k
    python -m benchmarks.sweeps overhead --tasks 10000
    python -m benchmarks.sweeps memory --jumps 2000

The first three run a sweep undisturbed and again with what their name says, go on with the same
command until it is through, and compare the tables row by row, times aside. Workers, schedulers and
mounts that they end are those they have begun.
"""

import json
import random
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import psutil
import pyarrow.parquet as pq
import typer

from llsrbm.sweep.rows import TIMES

app = typer.Typer(add_completion=False, help=__doc__)

Jumps = Annotated[int, typer.Option(help="Jumps of the sweep.")]
Seeds = Annotated[int, typer.Option(help="Simulations a jump; 0: plan only.")]
Patient = Annotated[bool, typer.Option(help="Try other guesses where the analytic one fails.")]

_SOME = 3  # parts of the table that are there before something is broken


def spec(
    folder: Path, jumps: int, seeds: int = 0, robot: str = "anymal", *, patient: bool = True
) -> Path:
    """A spec's file of that many jumps."""
    path = folder / f"{robot}-{jumps}.toml"
    axes = "".join(f'{n} = {{ range = "robot" }}\n' for n in ("twist", "forward", "height"))
    simulate = f"\n[simulate]\nseeds = {seeds}\n" if seeds else ""
    path.write_text(
        f'title = "{jumps} jumps"\nrobots = ["{robot}"]\nsampling = "sobol"\ncount = {jumps}\n'
        f"patient = {str(patient).lower()}\n"
        f"\n[axes]\n{axes}{simulate}"
    )
    return path


def command(sweep: str | Path, out: Path, *more: str) -> list[str]:
    return [
        *(sys.executable, "-m", "llsrbm.cli", "sweep", "--draft", str(sweep)),
        *("--out", str(out), "--json", *more),
    ]


def finished(sweep: str | Path, out: Path, *more: str) -> dict[str, Any]:
    """Run to the end; what `--json` says."""
    done = subprocess.run(command(sweep, out, *more), capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise SystemExit(f"status {done.returncode}: {done.stderr}")
    return json.loads(done.stdout)


def same_rows(one: Path, other: Path) -> bool:
    """Whether two tables have the same rows, times aside."""
    tables = [pq.read_table(path / "jumps.parquet").drop_columns([*TIMES]) for path in (one, other)]
    different = [n for n in tables[0].column_names if not tables[0][n].equals(tables[1][n])]
    for name in different:
        print(f"  {name} differs")
    return not different and tables[0].equals(tables[1])


def verdict(name: str, whole: Path, broken: Path) -> None:
    same = same_rows(whole, broken)
    rows = len(pq.read_table(broken / "jumps.parquet", columns=["index"]))
    print(f"{name}: {rows} rows, {'the same' if same else 'DIFFERENT'} as undisturbed")
    raise typer.Exit(0 if same else 1)


@contextmanager
def scratch() -> Iterator[Path]:
    folder = Path(tempfile.mkdtemp(prefix="llsrbm-sweeps-"))
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def parts(out: Path) -> int:
    return len([*(out / "jumps.parquet").glob("*.parquet")])


def worker_processes(client: psutil.Process) -> list[psutil.Process]:
    """Worker processes of a client's local cluster."""
    found = []
    with suppress(psutil.NoSuchProcess):
        for child in client.children(recursive=True):
            with suppress(psutil.NoSuchProcess):
                if "spawn_main" in " ".join(child.cmdline()):
                    found.append(child)
    return found


@app.command()
def deaths(jumps: Jumps = 300, kills: int = 10, workers: int = 2, seed: int = 0) -> None:
    """Kill workers, each some time after it has begun to work."""
    rng = random.Random(seed)
    with scratch() as folder:
        sweep = spec(folder, jumps)
        finished(sweep, folder / "whole", "--workers", str(workers))
        process = subprocess.Popen(
            command(sweep, folder / "broken", "--workers", str(workers)),
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        killed = 0
        while killed < kills and process.poll() is None:
            if parts(folder / "broken") >= _SOME and (
                alive := worker_processes(psutil.Process(process.pid))
            ):
                rng.choice(alive).kill()
                killed += 1
            time.sleep(rng.uniform(1.0, 4.0))
        _, printed = process.communicate()
        print(f"{killed} workers killed, status {process.returncode}")
        if process.returncode != 0:
            print(printed)
            finished(sweep, folder / "broken", "--workers", str(workers))
        verdict("deaths", folder / "whole", folder / "broken")


class Cluster:
    """A scheduler and workers started by hand, over TCP."""

    def __init__(self, workers: int) -> None:
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        self.address = f"tcp://127.0.0.1:{port}"
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        dask = [sys.executable, "-m", "dask"]
        self.scheduler = subprocess.Popen(
            [*dask, "scheduler", "--host", "127.0.0.1", "--port", str(port), "--no-dashboard"],
            **quiet,
        )
        self.workers = subprocess.Popen(
            [
                *(*dask, "worker", self.address, "--nthreads", "1"),
                *("--nworkers", str(workers), "--death-timeout", "20", "--no-dashboard"),
            ],
            **quiet,
        )

    def close(self) -> None:
        for process in (self.workers, self.scheduler):
            process.send_signal(signal.SIGTERM)
        for process in (self.workers, self.scheduler):
            with suppress(subprocess.TimeoutExpired):
                process.wait(20)
            process.kill()


@app.command()
def scheduler(jumps: Jumps = 200, workers: int = 2) -> None:
    """Kill the scheduler of a cluster in the middle of a sweep."""
    with scratch() as folder:
        sweep = spec(folder, jumps)
        finished(sweep, folder / "whole", "--workers", str(workers))
        cluster = Cluster(workers)
        process = subprocess.Popen(
            command(sweep, folder / "broken", "--scheduler", cluster.address),
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        while process.poll() is None and parts(folder / "broken") < _SOME:
            time.sleep(0.2)
        cluster.scheduler.kill()
        start = time.perf_counter()
        _, printed = process.communicate()
        cluster.close()
        print(f"status {process.returncode} {time.perf_counter() - start:.1f} s later: {printed}")
        cluster = Cluster(workers)
        finished(sweep, folder / "broken", "--scheduler", cluster.address)
        cluster.close()
        verdict("scheduler", folder / "whole", folder / "broken")


@app.command()
def disk(jumps: Jumps = 200, workers: int = 2, size: str = "160k") -> None:
    """Fill the disk."""
    with scratch() as folder:
        sweep, small = spec(folder, jumps), folder / "small"
        small.mkdir()
        mount = ["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(small)]
        if subprocess.run(mount, check=False).returncode != 0:
            print("disk: a tmpfs cannot be mounted here; skipped")
            return
        try:
            finished(sweep, folder / "whole", "--workers", str(workers))
            broken = small / "out"
            done = subprocess.run(
                command(sweep, broken, "--workers", str(workers)),
                capture_output=True,
                text=True,
                check=False,
            )
            print(f"status {done.returncode}: {done.stderr}{parts(broken)} parts are whole")
            subprocess.run(["mount", "-o", "remount,size=64m", str(small)], check=True)
            finished(sweep, broken, "--workers", str(workers))
            verdict("disk", folder / "whole", broken)
        finally:
            subprocess.run(["umount", str(small)], check=False)


@app.command()
def scaling(
    jumps: Annotated[str, typer.Option(help="Sizes, with commas.")] = "100,1000,10000",
    workers: int = 2,
    seeds: Seeds = 0,
    patient: Patient = True,
) -> None:
    """Time against the number of jumps."""
    for size in map(int, jumps.split(",")):
        with scratch() as folder:
            start = time.perf_counter()
            sweep = spec(folder, size, seeds, patient=patient)
            result = finished(sweep, folder / "out", "--workers", str(workers))
            whole, run = time.perf_counter() - start, result["run"]
            sizes = [part.stat().st_size for part in (folder / "out" / "jumps.parquet").iterdir()]
            bytes_a_row = sum(sizes) / result["rows"]
        print(
            f"{size:7} jumps: {run['seconds']:8.1f} s ({whole:.1f} s from start to end), "
            f"{1e3 * run['seconds'] / size:6.1f} ms a jump, {100 * run['busy_share']:.1f} % inside "
            f"planning and simulation, {bytes_a_row:.0f} bytes a row",
            flush=True,
        )


@app.command()
def workers(
    sweep: Annotated[str, typer.Option(help="A spec's name or file.")] = "anymal-10k",
    counts: Annotated[str, typer.Option(help="Numbers of workers, with commas.")] = "1,2",
) -> None:
    """One worker against several, and whether their tables are the same."""
    with scratch() as folder:
        seconds = {}
        for count in counts.split(","):
            run = finished(sweep, folder / count, "--workers", count)["run"]
            seconds[count] = run["seconds"]
            print(
                f"{count} workers: {run['seconds']:.1f} s, {run['jumps_per_second']:.2f} jumps/s, "
                f"{100 * run['busy_share']:.1f} % inside planning and simulation",
                flush=True,
            )
        first, *others = seconds
        for count in others:
            same = "the same" if same_rows(folder / first, folder / count) else "OTHER"
            print(f"{count} against {first}: {seconds[first] / seconds[count]:.2f} x, {same} rows")


@app.command()
def overhead(tasks: int = 10_000, workers: int = 2) -> None:
    """Time of the scheduler for a jump: empty ones, as many under way as a sweep has."""
    from llsrbm.sweep.run import connected

    with connected(workers, None) as client:
        client.gather(client.map(_nothing, range(workers), pure=False))
        start = time.perf_counter()
        flight: set[Any] = set()
        sent = 0
        import distributed

        while sent < tasks or flight:
            while sent < tasks and len(flight) < 2 * workers:
                flight.add(client.submit(_nothing, sent, pure=False))
                sent += 1
            done, flight = distributed.wait(flight, return_when="FIRST_COMPLETED")
            flight = set(flight)
            for future in done:
                future.result()
        few = (time.perf_counter() - start) / tasks
        start = time.perf_counter()
        client.gather(client.map(_nothing, range(tasks), pure=False))
        many = (time.perf_counter() - start) / tasks
    print(
        f"{tasks} empty tasks: {1e3 * few:.2f} ms each with {2 * workers} under way, "
        f"{1e3 * many:.2f} ms each all at once"
    )


def _nothing(number: int) -> int:
    return number


@app.command()
def memory(
    jumps: Jumps = 2000,
    workers: int = 2,
    seeds: Seeds = 0,
    every: float = 5.0,
    patient: Patient = True,
) -> None:
    """Resident memory of client and workers over time, and how long it took."""
    with scratch() as folder:
        sweep = spec(folder, jumps, seeds, patient=patient)
        process = subprocess.Popen(
            command(sweep, folder / "out", "--workers", str(workers)),
            stdout=subprocess.PIPE,
            text=True,
        )
        client, seen = psutil.Process(process.pid), []
        while process.poll() is None:
            if parts(folder / "out") >= _SOME:
                with suppress(psutil.NoSuchProcess):
                    largest = max(
                        (w.memory_info().rss for w in worker_processes(client)), default=0
                    )
                    seen.append((client.memory_info().rss / 1e6, largest / 1e6))
            time.sleep(every)
        result = json.loads(process.communicate()[0])
    run = result["run"]
    print(
        f"{result['rows']} rows in {run['seconds']:.0f} s, {run['jumps_per_second']:.2f} jumps/s, "
        f"{100 * run['busy_share']:.1f} % inside planning and simulation"
    )
    for name, figures in zip(("client", "largest worker"), np.array(seen).T, strict=True):
        quarters = [np.median(part) for part in np.array_split(figures, 4)]
        print(f"{name}: {', '.join(f'{q:.0f}' for q in quarters)} MB (medians of quarters)")


if __name__ == "__main__":
    app()
