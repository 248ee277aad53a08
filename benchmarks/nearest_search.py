"""Nearest jumps against a search: how much further away are they than what plans one by one find?

    python -m benchmarks.answers --robots anymal,go2 --requests 100 --out build/answers.jsonl
    python -m benchmarks.nearest_search --answers build/answers.jsonl --most 40

Of each refused request the search asks for less of one component and of all alike, and halves the
step six times: 30 plans, each from solutions nearby and without looking for a nearer jump: half a
minute. Distances are in shares of the robot's ranges.
"""

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

import llsrbm
from llsrbm.planning.answer.planner import Planner, planner_for
from llsrbm.planning.problem.placement import make_task
from llsrbm.planning.problem.shortfall import distance
from llsrbm.request.jump import COMPONENTS, Jump

HALVINGS = 6
REDUCED = (*((name,) for name in COMPONENTS), COMPONENTS)


def planned(planner: Planner, jump: Jump, limits: dict[str, float]) -> bool:
    """Whether a jump can be planned by the first attempts."""
    try:
        return planner.plan(jump, limits=limits, patient=False).solved
    except llsrbm.NotConverged:
        return False


def searched(planner: Planner, jump: Jump, limits: dict[str, float]) -> Iterator[Jump]:
    """The jumps that were found, one for each way to ask for less."""
    for names in REDUCED:
        share, step, found = 0.0, 1.0, None
        for _ in range(HALVINGS):
            step /= 2
            values = {name: (share + step) * getattr(jump, name) for name in names}
            less = replace(jump, **values)
            if planned(planner, less, limits):
                share, found = share + step, less
        if found is not None:
            yield found


def main(
    answers: Annotated[Path, typer.Option(help="By `benchmarks.answers --out`.")],
    most: Annotated[int, typer.Option(help="Refused requests.")] = 40,
) -> None:
    """Compare, with a line a request."""
    lines = answers.read_text(encoding="utf-8").splitlines()
    rows: list[dict[str, Any]] = [row for row in map(json.loads, lines) if "nearest" in row]
    further = []
    for row in rows[:most]:
        jump, limits = Jump(**row["request"]), row["limits"]
        planner = planner_for(jump.robot, jump.model)
        task = make_task(jump, planner.robot, None, limits)
        found = [distance(task, less) for less in searched(planner, jump, limits)]
        best = min(found, default=np.inf)
        further.append(row["distance"] - best)
        print(f"{jump.robot}: {row['distance']:.3f}, search {best:.3f}", flush=True)
    off = np.array(further)
    print(
        f"{len(off)} requests: further away than the search by {np.median(off):+.3f} at the median "
        f"and {off.max():+.3f} at most, nearer in {(off < 0).sum()}, by more than 0.05 further in "
        f"{(off > 0.05).sum()}"
    )


if __name__ == "__main__":
    typer.run(main)
