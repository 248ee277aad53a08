"""Makes the planner's first guesses of a sweep's jumps: `python -m benchmarks.guess_tables`.

    python -m benchmarks.guess_tables [--sweep guesses] [--robots anymal,go2,slider,g1]
    python -m benchmarks.guess_tables --sweep guesses-flips --robots go2

`--sweep` is a spec's name or file, or the folder of a sweep that is done; then only what was
planned there is solved again. Each jump is followed by a second one that asks for one or two of its
components alone, as most requests do. To be run after a change of a robot file, of the planner's
constraints or costs, or of the version: until then tables are refused with a warning.
"""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import pyarrow.parquet as pq
import typer

from llsrbm.errors import NotConverged
from llsrbm.motion.plan import Plan
from llsrbm.ocp.horizon import Iterate
from llsrbm.planning.answer.planner import Planner, planner_of
from llsrbm.planning.solve.guess_table import REQUEST, make_table, table_path, write_table
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot
from llsrbm.sweep.points import Points
from llsrbm.sweep.rows import PLANNED
from llsrbm.sweep.spec import Spec, find_spec

KEPT = [set(c) for count in (1, 2) for c in combinations(REQUEST, count)]
"""Components of the second jump, in turns."""

Solved = tuple[Jump, Iterate, float]  # request, solution, cost

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
    found = [point.jump for point in made if point.jump.robot == robot and not point.limits]
    return [jump for jump in found if is_allowed(jump)]


def is_allowed(jump: Jump) -> bool:
    """Whether a request is within the robot's range, where the sweep's own is wider."""
    ranges = load_robot(jump.robot).file.for_jump(turns=jump.turns).task
    return all(
        low <= getattr(jump, name) <= high
        for name, (low, high) in ((name, getattr(ranges, name)) for name in REQUEST)
    )


def with_faces(requested: list[Jump]) -> Iterator[Jump]:
    for number, jump in enumerate(requested):
        yield jump
        kept = KEPT[number % len(KEPT)]
        yield replace(jump, **{name: 0.0 for name in REQUEST if name not in kept})


def of_tables(requested: list[Jump]) -> Iterator[list[Jump]]:
    """The jumps of each table: of one planner, and with the same whole turns."""
    kinds: dict[Any, list[Jump]] = {}
    for jump in requested:
        kinds.setdefault((planner_of(jump), jump.type, jump.roll, jump.pitch), []).append(jump)
    yield from kinds.values()


def solutions(planner: Planner, requested: list[Jump]) -> list[Solved]:
    """Solutions of those that can be planned at once.

    A whole turn is planned from the one nearest to it among those before, from the spot outwards:
    from guesses turns of many kinds are found, between which nothing can be interpolated.
    """
    robot, turns = planner.robot, requested[0].turns
    scale = np.ptp([getattr(robot.file.task, name) for name in REQUEST], axis=1) / 2
    place = {jump: np.array([getattr(jump, n) for n in REQUEST]) / scale for jump in requested}
    if turns:
        spot = replace(requested[0], **dict.fromkeys(REQUEST, 0.0))
        place[spot] = np.zeros(len(REQUEST))
        requested = sorted(place, key=lambda jump: float(np.linalg.norm(place[jump])))
    plans: dict[Jump, Plan] = {}
    for number, jump in enumerate(requested):
        from_here = [float(np.linalg.norm(place[other] - place[jump])) for other in plans]
        near = [*plans.values()][int(np.argmin(from_here))] if turns and plans else None
        try:
            plans[jump] = planner.plan(jump, near=near, patient=False)
        except NotConverged:
            continue
        if number % 10 == 0:
            print(f"{robot.name}: {number} of {len(requested)}", flush=True)
    return [(jump, plan.solution, plan.report.cost) for jump, plan in plans.items()]


def make(requested: list[Jump]) -> None:
    planner = planner_of(requested[0])
    planner.formulation.solver.settle()
    start = time.perf_counter()
    solved = solutions(planner, requested)
    path = table_path(planner.formulation)
    path.parent.mkdir(exist_ok=True)
    write_table(path, make_table(solved, planner.formulation), planner.formulation)
    size = path.stat().st_size
    if size > LARGEST:  # of more numbers a jump, fewer jumps: knees and soles
        kept = thinned(len(solved), size)
        solved = [solved[number] for number in kept]
        write_table(path, make_table(solved, planner.formulation), planner.formulation)
    print(
        f"{path.name}: {len(solved)} solutions, "
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
        for requested in of_tables([*with_faces(jumps(sweep, robot))]):
            make(requested)


if __name__ == "__main__":
    typer.run(main)
