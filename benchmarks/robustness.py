"""Does the whole robot follow its plans? Many seeds a jump, judged strictly.

    python -m benchmarks.robustness --seeds 1000:1020 --models llsrbm-plus,llsrbm,srbm
    python -m benchmarks.robustness --robot slider --seeds 1000:1010 --trunk-mass 0.15

Each cell is one plan, simulated once a seed with everything disturbed that
`llsrbm.simulation.disturbance` disturbs. Strict success is defined in `llsrbm.simulation.verdict`.
Controller and planner were tuned on seeds below 1000. Timings mean something only with --jobs 1
and nothing else running.
"""

import math
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

import llsrbm
from benchmarks.counting import count, seeds_of, write_lines
from llsrbm.mechanics import yaw


@dataclass(frozen=True)
class Cell:
    """One row of the table."""

    name: str
    twist_deg: float = 0.0
    forward: float = 0.0
    height: float = 0.0
    board: float = 0.0
    half_board: bool = False

    def jump(self, robot: str, model: str) -> llsrbm.Jump:
        return llsrbm.Jump(
            robot=robot,
            model=model,
            twist=math.radians(self.twist_deg),
            forward=self.forward,
            height=self.height,
        )


TWIST, FORWARD = Cell("90 deg", twist_deg=90), Cell("30 cm", forward=0.3)
QUADRUPED = (
    TWIST,
    Cell("-90 deg", twist_deg=-90),
    FORWARD,
    Cell("45 deg + 20 cm", twist_deg=45, forward=0.2),
    Cell("30 deg, board", twist_deg=30, board=0.025),
    Cell("30 deg, half board", twist_deg=30, board=0.025, half_board=True),
)
CELLS = {
    "anymal": QUADRUPED,
    "go2": (TWIST, FORWARD),
    "slider": (
        Cell("vertical"),
        Cell("20 cm", forward=0.2),
        TWIST,
        Cell("35 cm box", forward=0.2, height=0.35),
        Cell("180 deg", twist_deg=180),
        Cell("40 cm box", forward=0.2, height=0.4),
        Cell("40 cm", forward=0.4),
    ),
}
"""What the project's issues ask of each robot; another quadruped is given the first row's."""

_plans: dict[tuple[str, str, Cell], Any] = {}


def one(work: tuple[Cell, str, str, int, llsrbm.Scenario]) -> dict[str, Any]:
    cell, robot, model, seed, scenario = work
    key = (robot, model, cell)
    if key not in _plans:
        _plans[key] = llsrbm.plan(cell.jump(robot, model), draft=True)
    plan = _plans[key]
    bound = scenario.trunk_mass
    scenario = scenario.but(
        board=cell.board,
        half_board=cell.half_board,
        seed=seed,
        trunk_mass=None if bound is None else bound * (-1) ** seed,
    )
    rollout = llsrbm.simulate(plan, scenario)
    rates = yaw_rates(plan, rollout)
    return {"cell": cell.name, "model": model, "seed": seed, **asdict(rollout.outcome), **rates}


def yaw_rates(plan: Any, rollout: Any) -> dict[str, float]:
    """How the yaw rate of lift-off holds on in flight, and when the goal is reached."""
    heading = np.abs(yaw(rollout.base_quat))
    rate = np.gradient(heading, rollout.time)
    takeoff, planned = plan.lift_off, plan.touchdown
    touchdown = rollout.outcome.touchdown_true_s or planned
    flying = (rollout.time >= takeoff + 0.02) & (rollout.time <= touchdown - 0.01)
    goal = abs(rollout.jump.twist)
    reached = np.flatnonzero(heading >= 0.95 * goal)
    return {
        "yaw_rate_takeoff": float(rate[np.searchsorted(rollout.time, takeoff)]),
        "yaw_rate_least": float(rate[flying].min()) if flying.any() else math.nan,
        "yaw_rate_mean": float(rate[flying].mean()) if flying.any() else math.nan,
        "yaw_at_touchdown_deg": float(
            np.degrees(heading[min(np.searchsorted(rollout.time, touchdown), len(heading) - 1)])
        ),
        "goal_reached_s": float(rollout.time[reached[0]]) if goal and len(reached) else math.nan,
    }


def table(results: list[dict[str, Any]]) -> Iterator[str]:
    columns = (
        "strict", "landed", "yaw err", "lat med", "p90", "min", "false", "missed", "sat %",
        "dq off", "foot td", "foot", "tilt", "air", "tick", "p99", "x real",
    )  # fmt: skip
    yield f"{'cell':20} {'model':12}" + "".join(f"{column:>9}" for column in columns)
    cells = dict.fromkeys((result["cell"], result["model"]) for result in results)
    for cell, model in cells:
        rows = [r for r in results if (r["cell"], r["model"]) == (cell, model)]
        counts, true = count(rows), _column(rows, "touchdown_true_s")
        latency = 1e3 * (_column(rows, "touchdown_detected_s") - true)
        values = (
            f"{counts.strict}/{counts.requests}",
            f"{counts.stand}",
            f"{np.degrees(np.nanmedian(_column(rows, 'yaw_error_at_touchdown'))):.1f}",
            f"{np.nanmedian(latency):.1f}",
            f"{np.nanpercentile(latency, 90):.1f}",
            f"{np.nanmin(latency):.1f}",
            f"{sum(r['false_touchdowns'] for r in rows)}",
            f"{sum(r['touchdown_detected_s'] is None for r in rows)}",
            f"{100 * np.median(_column(rows, 'saturated_fraction')):.1f}",
            f"{np.median(_column(rows, 'takeoff_joint_speed')):.1f}",
            f"{1e3 * np.nanmedian(_column(rows, 'foot_error_at_touchdown')):.0f}",
            f"{1e3 * np.max(_column(rows, 'foot_error')):.0f}",
            f"{np.degrees(np.max(_column(rows, 'peak_tilt'))):.1f}",
            f"{1e3 * np.max(_column(rows, 'second_flight_s')):.0f}",
            f"{1e6 * np.median(_column(rows, 'tick_median_s')):.0f}",
            f"{1e6 * np.max(_column(rows, 'tick_p99_s')):.0f}",
            f"{np.median(_column(rows, 'real_time_factor')):.1f}",
        )
        yield f"{cell:20} {model:12}" + "".join(f"{value:>9}" for value in values)
        for row in rows:
            if not row["strict"]:
                yield f"    seed {row['seed']}: {_failure(row)}"


def yaw_table(results: list[dict[str, Any]]) -> Iterator[str]:
    """How the models' twists compare in flight: the paper's figure, as medians."""
    columns = ("rate off", "least", "mean", "kept %", "yaw td", "95 % at")
    yield f"{'twist':20} {'model':12}" + "".join(f"{column:>9}" for column in columns)
    cells = dict.fromkeys(
        (r["cell"], r["model"]) for r in results if not math.isnan(r["goal_reached_s"])
    )
    for cell, model in cells:
        rows = [r for r in results if (r["cell"], r["model"]) == (cell, model)]
        off, least, mean, at_touchdown, reached = (
            np.nanmedian(_column(rows, name))
            for name in (
                "yaw_rate_takeoff",
                "yaw_rate_least",
                "yaw_rate_mean",
                "yaw_at_touchdown_deg",
                "goal_reached_s",
            )
        )
        values = (
            f"{off:.2f}",
            f"{least:.2f}",
            f"{mean:.2f}",
            f"{100 * least / off:.0f}",
            f"{at_touchdown:.1f}",
            f"{reached:.3f}",
        )
        yield f"{cell:20} {model:12}" + "".join(f"{value:>9}" for value in values)


def _column(rows: list[dict[str, Any]], name: str) -> np.ndarray:
    return np.array([math.nan if row[name] is None else row[name] for row in rows], dtype=float)


def _failure(row: dict[str, Any]) -> str:
    return (
        f"{row['status']} {row['reason']} foot {1e3 * row['foot_error']:.0f} mm, "
        f"tilt {math.degrees(row['final_tilt']):.1f}, "
        f"at most {math.degrees(row['peak_tilt']):.1f} deg, "
        f"air {1e3 * row['second_flight_s']:.0f} ms, trunk {row['trunk_touched']}"
    )


def main(
    seeds: Annotated[str, typer.Option(help="First:last+1.")] = "1000:1020",
    models: str = "llsrbm-plus",
    robot: str = "anymal",
    cells: Annotated[str, typer.Option(help="Part of the names; all if empty.")] = "",
    jobs: int = 2,
    noise: float = 1.0,
    detector: str = llsrbm.Scenario.detector,
    landing: str = llsrbm.Scenario.landing,
    solver: str = llsrbm.Scenario.solver,
    replan: Annotated[bool, typer.Option("--replan", help="Plan anew under way.")] = False,
    trunk_mass: Annotated[
        float | None,
        typer.Option(
            help="Error of the trunk's mass in place of the drawn one: + for even seeds, - for odd."
        ),
    ] = None,
    out: Annotated[Path | None, typer.Option(help="All outcomes, JSON lines.")] = None,
) -> None:
    scenario = llsrbm.Scenario(
        noise=noise,
        detector=detector,
        landing=landing,
        solver=solver,
        replan=replan,
        trunk_mass=trunk_mass,
    )
    work = [
        (cell, robot, model, seed, scenario)
        for model in models.split(",")
        for cell in CELLS.get(robot, QUADRUPED)
        if cells in cell.name
        for seed in seeds_of(seeds)
    ]
    if jobs == 1:
        results = [one(item) for item in work]
    else:
        with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
            results = list(pool.map(one, work, chunksize=len(seeds_of(seeds))))
    print("\n".join((*table(results), "", *yaw_table(results))))
    if out is not None:
        write_lines(out, results)


if __name__ == "__main__":
    typer.run(main)
