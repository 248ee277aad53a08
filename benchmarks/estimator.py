"""The cost of a state estimate that drifts: the same jumps and seeds with it and with the truth.

    python -m benchmarks.estimator --robot anymal --seeds 1000:1010

Everything else is disturbed alike. The estimators are those of `llsrbm.simulation.sensors`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import Annotated, Any

import numpy as np
import typer

import llsrbm
from benchmarks.counting import count, seeds_of
from benchmarks.robustness import FORWARD, Cell, one
from llsrbm.simulation.sensors import ESTIMATORS

FLAT, HALF = 0.025, {"board": 0.025, "half_board": True}
QUADRUPED = (
    Cell("20 cm", forward=0.2),
    FORWARD,
    Cell("30 deg, board", twist_deg=30, board=FLAT),
    Cell("30 deg, half board", twist_deg=30, **HALF),
    Cell("20 cm, board", forward=0.2, board=FLAT),
)
CELLS = {
    "slider": (
        Cell("10 cm", forward=0.1),
        Cell("20 cm", forward=0.2),
        Cell("40 cm", forward=0.4),
        Cell("vertical, board", board=FLAT),
        Cell("20 cm, board", forward=0.2, board=FLAT),
        Cell("vertical, half board", **HALF),
    )
}
"""Forward jumps, whose landing depends on where the robot believes to be, and board experiments."""


def table(results: list[dict[str, Any]]) -> Iterator[str]:
    columns = f"{'strict':>8}{'recovered':>11}{'landed':>8}{'feet':>7}{'yaw':>7}"
    yield f"{'cell':22}{'estimator':11}{columns}"
    for cell in dict.fromkeys(result["cell"] for result in results):
        for estimator in ESTIMATORS:
            rows = [r for r in results if (r["cell"], r["estimator"]) == (cell, estimator)]
            counts = count(rows)
            feet = 1e3 * np.median([row["foot_error"] for row in rows])
            heading = math.degrees(np.median([abs(row["final_yaw_error"]) for row in rows]))
            yield (
                f"{cell:22}{estimator:11}"
                f"{counts.strict:>5}/{counts.requests}{counts.recovered:>11}{counts.stand:>8}"
                f"{feet:>7.0f}{heading:>7.2f}"
            )


def main(
    robot: str = "anymal",
    seeds: Annotated[str, typer.Option(help="First:last+1.")] = "1000:1010",
    jobs: int = 2,
) -> None:
    work = [
        (cell, robot, "llsrbm-plus", seed, llsrbm.Scenario(noise=1.0, estimator=estimator))
        for cell in CELLS.get(robot, QUADRUPED)
        for estimator in ESTIMATORS
        for seed in seeds_of(seeds)
    ]
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        outcomes = pool.map(one, work, chunksize=2 * len(seeds_of(seeds)))
        results = [
            outcome | {"estimator": scenario.estimator}
            for (*_, scenario), outcome in zip(work, outcomes, strict=True)
        ]
    print(f"{robot}, median foot error in mm and heading error in deg at the end")
    print("\n".join(table(results)))


if __name__ == "__main__":
    typer.run(main)
