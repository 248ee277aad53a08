"""Certificates of random plans: the worst value of each check, and how many plans hold.

    python -m benchmarks.certificates --robots anymal,go2,slider,g1 --requests 30 --seed 7000

Requests are those of `benchmarks.range`. Rows are checks: how many of the plans hold, median and
worst of the worst values (shares of the limit, or mm), and where the worst one is.
"""

import time
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

import llsrbm
from benchmarks.counting import write_lines
from benchmarks.range import COMPONENTS, requests
from llsrbm.certificate import Finding


def one(request: dict[str, Any], draft: bool) -> dict[str, Any] | None:
    """The request, its certificate and how long that took; None: not planned."""
    motion = {name: request[name] for name in COMPONENTS if name in request}
    jump = llsrbm.Jump(robot=request["robot"], **motion)
    try:
        plan = llsrbm.plan(jump, patient=False, explains=False, draft=draft)
    except llsrbm.NotConverged:
        return None
    start = time.perf_counter()
    certificate = llsrbm.certify(plan)
    took = time.perf_counter() - start
    return {
        **request,
        "refined": plan.refined,
        "seconds": took,
        "holds": certificate.holds,
        "certificate": certificate.as_dict(),
    }


def table(robot: str, many: int, rows: list[dict[str, Any]]) -> Iterator[str]:
    """A head and a line a check."""
    held = sum(row["holds"] is True for row in rows)
    took = f"{np.median([row['seconds'] for row in rows]):.2f} s each"
    refined = sum(row["refined"] for row in rows)
    yield f"{robot}: {len(rows)} of {many} planned, {refined} refined, {held} hold; {took}"
    for name in rows[0]["certificate"]:
        found = [Finding(name=name, **row["certificate"][name]) for row in rows]
        known = [each for each in found if each.worst is not None]
        holds = sum(each.holds is True for each in found)
        if not known:
            yield f"  {name:16} {holds:3}  {found[0].why}"
            continue
        sign = -1 if name in ("self_distance", "clearance") else 1
        worst = max(known, key=lambda each: sign * (each.worst or 0.0))
        shown = [
            f"{1e3 * value:8.1f} mm" if worst.is_length else f"{100 * value:8.1f} %"
            for value in (np.median([each.worst for each in known]), worst.worst)
        ]
        yield f"  {name:16} {holds:3} {' '.join(shown)}  {worst.where} at {worst.time_s:.2f} s"


def main(
    robots: str = "anymal,go2,slider,g1",
    count: Annotated[int, typer.Option("--requests", help="A robot.")] = 30,
    seed: Annotated[int, typer.Option(help="Draws the requests.")] = 7000,
    draft: Annotated[bool, typer.Option("--draft", help="The first stage alone.")] = False,
    out: Annotated[Path | None, typer.Option(help="All results, JSON lines.")] = None,
) -> None:
    """Print a table a robot."""
    results = []
    for robot in robots.split(","):
        found = [one(request, draft) for request in requests(robot, count, seed)]
        rows = [row for row in found if row is not None]
        results += rows
        if rows:
            print("\n".join(table(robot, count, rows)), flush=True)
    if out is not None:
        write_lines(out, results)


if __name__ == "__main__":
    typer.run(main)
