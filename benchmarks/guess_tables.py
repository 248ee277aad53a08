"""Makes the planner's first guesses of a sweep's jumps: `python -m benchmarks.guess_tables`.

    python -m benchmarks.guess_tables [--sweep guesses] [--robots anymal,go2,slider,g1]

`--sweep` is a spec's name or file, or the folder of a sweep that is done; then only what was
planned there is solved again. Of each jump a second one is made that asks for one or two of its
components alone, as most requests do. To be run after a change of a robot file, of the planner's
constraints or costs, or of the version: until then tables are refused, and
`tests/llsrbm/planning/solve/test_guess_table.py` fails.
"""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from typing import Annotated

import pyarrow.parquet as pq
import typer

from llsrbm.errors import NotConverged
from llsrbm.planning.solve.guess_table import REQUEST, make_table, table_path, write_table
from llsrbm.planning.solve.planner import planner_of
from llsrbm.request.jump import Jump
from llsrbm.sweep.points import Points
from llsrbm.sweep.rows import PLANNED
from llsrbm.sweep.spec import Spec, find_spec

KEPT = [set(c) for count in (1, 2) for c in combinations(REQUEST, count)]
"""Components of the second jump, in turns."""

LARGEST = 2 * 10**6  # bytes of a robot's file
ROOM = 0.97  # of that, as solutions are not all of one size


def jumps(sweep: str, robot: str) -> list[Jump]:
    """A sweep's requests to a robot."""
    folder = Path(sweep)
    if (folder / "sweep.json").is_file():
        spec = Spec.from_table(json.loads((folder / "sweep.json").read_text())["spec"])
        table = pq.read_table(folder / "jumps.parquet", columns=["jump", "status"]).to_pylist()
        numbers = dict.fromkeys(row["jump"] for row in table if row["status"] == PLANNED)
        points = Points(spec)
        made = [points[number] for number in numbers]
    else:
        made = [*Points(find_spec(sweep))]
    return [point.jump for point in made if point.jump.robot == robot and not point.limits]


def with_faces(requested: list[Jump]) -> Iterator[Jump]:
    for number, jump in enumerate(requested):
        yield jump
        kept = KEPT[number % len(KEPT)]
        yield replace(jump, **{name: 0.0 for name in REQUEST if name not in kept})


def make(robot: str, sweep: str) -> None:
    planner = planner_of(Jump(robot=robot))
    planner.formulation.solver.settle()
    solved, requested, start = [], [*with_faces(jumps(sweep, robot))], time.perf_counter()
    for number, jump in enumerate(requested):
        try:
            plan = planner.plan(jump, patient=False)
        except NotConverged:
            continue
        solved.append((jump, plan.solution, plan.report.cost))
        if number % 50 == 0:
            print(f"{robot}: {number} of {len(requested)}", flush=True)
    path = table_path(robot)
    path.parent.mkdir(exist_ok=True)
    write_table(path, make_table(solved, planner.formulation), planner.formulation)
    size = path.stat().st_size
    if size > LARGEST:  # of more numbers a jump, fewer jumps: knees and soles
        kept = thinned(len(solved), size)
        solved = [solved[number] for number in kept]
        write_table(path, make_table(solved, planner.formulation), planner.formulation)
    print(
        f"{path.name}: {len(solved)} solutions of {len(requested)} jumps, "
        f"{path.stat().st_size / 1e6:.2f} MB, {time.perf_counter() - start:.0f} s",
        flush=True,
    )


def thinned(count: int, size: int) -> list[int]:
    """Numbers of so many solutions, evenly spread, that a file of `size` bytes is small enough."""
    kept = int(count * LARGEST / size * ROOM)
    return [round(number * (count - 1) / (kept - 1)) for number in range(kept)]


def main(
    sweep: Annotated[str, typer.Option(help="Spec's name or file, or a sweep's folder.")] = (
        "guesses"
    ),
    robots: Annotated[str, typer.Option(help="Names, with commas.")] = "anymal,go2,slider,g1",
) -> None:
    for robot in robots.split(","):
        make(robot, sweep)


if __name__ == "__main__":
    typer.run(main)
