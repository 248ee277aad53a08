"""Time and truth of answers: requests planned, or refused with the nearest jump and one reason.

    python -m benchmarks.answers --robots anymal,go2 --requests 200 --seed 950

Requests are uniform over the robot file's [task], one after another on an otherwise idle machine,
planned as `llsrbm plan` does. Times are from request to answer, as multiples of the median of plain
cold drafts in the same run: from the analytic guess, solved by the first attempt.
A refusal's limit is checked: with that limit alone, or with both where two are said to stop
it together, the request has to be planned: as loose as is said to be needed, or at the loose end.
`--limit NAME=VALUE` tightens limits, for more refusals; `--hurried` takes the nearest jump as first
found, its reasons unchecked; `--out` keeps a line a request.
"""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

import llsrbm
from llsrbm.errors import Stop
from llsrbm.planning.answer.planner import Planner, planner_for
from llsrbm.planning.problem.placement import limits_of, make_task
from llsrbm.planning.problem.shortfall import distance
from llsrbm.planning.whole_body.refine import refiner_of
from llsrbm.request.jump import COMPONENTS, Jump
from llsrbm.robots import load_robot

COLD_PLANS = 30  # requests from the first on


def requests(robot: str, count: int, seed: int) -> list[Jump]:
    """Uniform over the range, the same for the same seed."""
    task, rng = load_robot(robot).file.task, np.random.default_rng(seed)
    return [
        Jump(robot=robot, **{c: float(rng.uniform(*getattr(task, c))) for c in COMPONENTS})
        for _ in range(count)
    ]


def answer(planner: Planner, jump: Jump, limits: dict[str, float], hurried: bool) -> dict[str, Any]:
    """One request's answer."""
    row: dict[str, Any] = {"request": jump.as_dict(), "limits": limits}
    start = time.perf_counter()
    try:
        plan = llsrbm.plan(jump, limits=limits, hurried=hurried)
    except llsrbm.NotConverged as error:
        row |= {"seconds": time.perf_counter() - start, "reason": error.reason}
        if error.nearest is not None:
            task = make_task(jump, planner.robot, None, limits)
            row["nearest"] = error.nearest.jump.as_dict()
            row["certified"] = error.nearest.certified
            row["distance"] = distance(task, error.nearest.jump)
            named = error.stops[: 1 if error.stops and error.stops[0].amount > 0 else 2]
            named = tuple(stop for stop in named if stop.limit is not None)  # others are of shapes
            row["named"] = [stop.limit for stop in named]
            row["right"] = not hurried and bool(named) and _enough(planner, jump, limits, named)
        return row
    row |= {"seconds": time.perf_counter() - start, "certified": plan.certified}
    return row | {"planned": True, "from_table": plan.report.attempts == 0}


def _enough(
    planner: Planner, jump: Jump, limits: dict[str, float], named: tuple[Stop, ...]
) -> bool:
    """Whether the request can be planned with the named limits alone looser."""
    own = limits_of(planner.robot)
    found = [own[stop.limit][0] for stop in named]
    needed = {stop.limit: stop.needed for stop in named if stop.amount > 0}
    loose = {limit.name: limit.loosest for limit in found}
    for looser in (needed, loose) if needed else (loose,):
        try:
            if planner.plan(jump, limits=limits | looser, explains=False).solved:
                return True
        except llsrbm.NotConverged:
            continue
    return False


def cold_time(planner: Planner, jumps: list[Jump]) -> float:
    """Median time (s) of plain cold drafts."""
    seconds = []
    for jump in jumps:
        start = time.perf_counter()
        try:
            planner.plan(jump, patient=False)
        except llsrbm.NotConverged:
            continue
        seconds.append(time.perf_counter() - start)
    return float(np.median(seconds))


def main(
    robots: Annotated[str, typer.Option(help="Names with commas.")] = "anymal,go2,slider",
    requests_each: Annotated[int, typer.Option("--requests")] = 200,
    seed: int = 950,
    limit: Annotated[list[str], typer.Option(help="NAME=VALUE")] = [],  # noqa: B006
    hurried: Annotated[bool, typer.Option(help="The nearest jump as first found.")] = False,
    out: Path | None = None,
) -> None:
    """Answer all requests, and print a line a robot."""
    limits = {name: float(value) for name, value in (text.split("=") for text in limit)}
    rows: list[dict[str, Any]] = []
    for name in robots.split(","):
        planner = planner_for(name, Jump().model)
        planner.formulation.solver.settle()
        refiner_of(llsrbm.plan(Jump(robot=name), draft=True)).solver.settle()
        jumps = requests(name, requests_each, seed)
        cold = cold_time(planner, jumps[:COLD_PLANS])
        found = [answer(planner, jump, limits, hurried) for jump in jumps]
        print(summary(name, found, cold), flush=True)
        rows += found
    if out is not None:
        out.write_text("".join(json.dumps(row) + "\n" for row in rows), encoding="utf-8")


def summary(name: str, rows: list[dict[str, Any]], cold: float) -> str:
    """One line; `cold`: time of a plain cold draft, s."""
    planned = [row for row in rows if "planned" in row]
    refused = [row for row in rows if "planned" not in row]
    near = [row for row in refused if "nearest" in row]
    hold = [sum(row["certified"] for row in part) for part in (planned, near)]
    alone = [row["right"] for row in near if len(row["named"]) == 1]
    pairs = [row["right"] for row in near if len(row["named"]) > 1]
    distances = [row["distance"] for row in near] or [0.0]
    return (
        f"{name}: {len(planned)} of {len(rows)} planned, {hold[0]} "
        f"with a certificate that holds, {sum(r['from_table'] for r in planned)} from the table; "
        f"{len(near)} of {len(refused)} refusals with a nearest, {hold[1]} of them "
        f"with a certificate, {np.median(distances):.3f} of the ranges away (largest "
        f"{max(distances):.3f}), right are {sum(alone)} of {len(alone)} limits named alone "
        f"and {sum(pairs)} of {len(pairs)} pairs; a cold draft {1e3 * cold:.0f} ms; "
        f"plans {_times(planned, cold)}; refusals {_times(refused, cold)}"
    )


def _times(rows: list[dict[str, Any]], cold: float) -> str:
    """Median, 95th percentile and worst of the times, as multiples of `cold`."""
    if not rows:
        return "none"
    multiples = np.array([row["seconds"] for row in rows]) / cold
    median, p95 = np.quantile(multiples, [0.5, 0.95])
    return f"median {median:.1f}, p95 {p95:.1f}, worst {multiples.max():.1f} x"


if __name__ == "__main__":
    typer.run(main)
