"""Estimators of the robot's state: what they cost, and by how much they err.

    python -m benchmarks.estimator cost --robot anymal --seeds 1000:1010
    python -m benchmarks.estimator errors --robots go2,anymal,slider --seeds 9000:9020

`cost` simulates the same jumps and seeds with each of `llsrbm.simulation.sensors`, everything else
disturbed alike. `errors` compares estimates with the truth at lift-off, at the first contact and a
second after it, each seed of each jump. `imu` was
tuned on seeds 8900 to 8999.
"""

import math
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from multiprocessing import get_context
from typing import Annotated, Any

import numpy as np
import pinocchio as pin
import typer

import llsrbm
from benchmarks.counting import count, seeds_of
from benchmarks.robustness import FORWARD, TWIST, Cell, one
from llsrbm.mechanics import rotation_matrices
from llsrbm.simulation import simulate as simulation
from llsrbm.simulation.sensors import ESTIMATORS, Sensors

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

JUMPS = {
    "slider": (
        Cell("vertical"),
        Cell("20 cm", forward=0.2),
        Cell("40 cm", forward=0.4),
        TWIST,
        Cell("35 cm box", forward=0.2, height=0.35),
    ),
    "g1": (Cell("vertical"), Cell("20 cm", forward=0.2), Cell("30 deg", twist_deg=30)),
}
"""Whose errors are measured; of quadrupeds those below."""
QUADRUPEDS_JUMPS = (
    FORWARD,
    TWIST,
    Cell("-90 deg", twist_deg=-90),
    Cell("45 deg + 20 cm", twist_deg=45, forward=0.2),
    Cell("20 cm box", forward=0.3, height=0.2),
)
AFTER = 1.0  # s after the first contact, when it stands
INSTANTS = ("lift-off", "touchdown", "1 s later")
FIGURES = {"speed": "cm/s", "vertical": "cm/s", "height": "mm", "yaw": "deg", "tilt": "deg"}

app = typer.Typer(help=__doc__, add_completion=False)


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


@app.command()
def cost(
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


class Watched(Sensors):
    """Sensors whose every measurement is kept, beside the true state."""

    kept: list[tuple[Any, ...]]

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        Watched.kept = []

    def measure(self, time, state, last, standing):
        measured = super().measure(time, state, last, standing)
        Watched.kept.append((time, state, (measured.q, measured.v)))
        return measured


def erring(work: tuple[str, Cell, int, str]) -> dict[str, Any]:
    """One jump: its errors at each instant."""
    robot, cell, seed, estimator = work
    plan = _planned(robot, cell)
    simulation.Sensors = Watched
    outcome = llsrbm.simulate(plan, seed=seed, estimator=estimator).outcome
    touchdown = outcome.touchdown_true_s or plan.touchdown
    times = np.array([time for time, *_ in Watched.kept])
    at = np.searchsorted(times, [plan.lift_off, touchdown, touchdown + AFTER]).clip(
        max=len(times) - 1
    )
    errors = [error(*Watched.kept[k][1:]) for k in at]
    return {"robot": robot, "estimator": estimator, "strict": outcome.strict, "errors": errors}


@cache
def _planned(robot: str, cell: Cell) -> Any:
    return llsrbm.plan(cell.jump(robot, "llsrbm-plus"), draft=True)


def error(true: tuple[Any, Any], estimated: tuple[Any, Any]) -> list[float]:
    """Sizes of the errors of a state, as `FIGURES` has them."""
    R, R_estimated = (rotation_matrices(q[[6, 3, 4, 5]]) for q, _ in (true, estimated))
    velocity = R_estimated @ estimated[1][:3] - R @ true[1][:3]
    turn = pin.log3(R_estimated @ R.T)
    return [
        100 * float(np.linalg.norm(velocity)),
        100 * abs(velocity[2]),
        1e3 * abs(estimated[0][2] - true[0][2]),
        math.degrees(abs(turn[2])),
        math.degrees(math.hypot(*turn[:2])),
    ]


@app.command()
def errors(
    robots: str = "go2,anymal,slider",
    seeds: Annotated[str, typer.Option(help="First:last+1, of each jump.")] = "9000:9020",
    estimators: str = "drift,imu",
    jobs: int = 2,
) -> None:
    work = [
        (robot, cell, seed, estimator)
        for robot in robots.split(",")
        for cell in JUMPS.get(robot, QUADRUPEDS_JUMPS)
        for seed in seeds_of(seeds)
        for estimator in estimators.split(",")
    ]
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        results = list(pool.map(erring, work, chunksize=len(seeds_of(seeds))))
    print("Median and 95th percentile of errors; angles in deg.")
    print("| robot | estimator | strict | when |", end="")
    print(" | ".join(f" {name}, {unit}" for name, unit in FIGURES.items()), "|")
    print("|---|---|---|---|" + "---|" * len(FIGURES))
    for robot, estimator in dict.fromkeys((r["robot"], r["estimator"]) for r in results):
        rows = [r for r in results if (r["robot"], r["estimator"]) == (robot, estimator)]
        sizes = np.array([r["errors"] for r in rows])
        strict = f"{sum(r['strict'] for r in rows)}/{len(rows)}"
        for i, instant in enumerate(INSTANTS):
            pairs = np.percentile(sizes[:, i], [50, 95], axis=0).T
            cells = " | ".join(f"{median:.1f} / {worst:.1f}" for median, worst in pairs)
            print(f"| {robot} | {estimator} | {strict} | {instant} | {cells} |")


if __name__ == "__main__":
    app()
