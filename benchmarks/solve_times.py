"""Solve times of the planner against the paper's formulation, all in one run.

    python -m benchmarks.solve_times [--repeats 15] [--baseline-repeats 3]
        [--against COMMIT] [--crocoddyl] [--only-compare]

Cold: from the analytic guess. Warm: each jump from the plan of its neighbour, one slider step
(2 deg or 1 cm) away, up and down. Baseline: `opti_baseline.py`, expanded to SX (the faster of
Opti's two ways) and as written. After that, in turns (`interleaved.py`): ANYmal, SLIDER, an older
version of the project, and Crocoddyl. Use an idle machine; ratios are taken within the run.
"""

import argparse
import math
import os
import statistics
import sys

import numpy as np

import llsrbm
from benchmarks.interleaved import compare
from benchmarks.opti_baseline import solve_baseline
from llsrbm.motion.solve_report import SolveReport
from llsrbm.planning.answer.planner import Planner, planner_for
from llsrbm.planning.problem.placement import make_task

INTERVALS = 48
TASKS = {"twist": {"twist": math.radians(90.0)}, "forward": {"forward": 0.3}}
STEP = {"twist": math.radians(2.0), "forward": 0.01}


def cold(planner: Planner, jump: llsrbm.Jump, repeats: int) -> list[SolveReport]:
    """The same jump again and again from the analytic guess."""
    return [planner.plan(jump).report for _ in range(repeats)]


def warm(planner: Planner, model: str, kind: str, repeats: int) -> list[SolveReport]:
    """A slider that moves up and down about the jump."""
    value = TASKS[kind][kind]
    plan = planner.plan(llsrbm.Jump(model=model, **{kind: value}))
    reports = []
    for k in range(repeats):
        value += STEP[kind] * (1 if k % 10 < 5 else -1)
        plan = planner.plan(llsrbm.Jump(model=model, **{kind: value}), near=plan)
        reports.append(plan.report)
    return reports


def milliseconds(times: list[float]) -> str:
    """Median / p95."""
    return f"{1e3 * statistics.median(times):.0f} / {1e3 * np.percentile(times, 95):.0f}"


def baseline(
    planner: Planner, jump: llsrbm.Jump, repeats: int, cold_time: float, warm_time: float
) -> list[str]:
    """The paper's formulation, expanded and as written, beside the planner's times (s)."""
    cells, task = [], make_task(jump, planner.robot)
    for expand in (True, False):
        results = [solve_baseline(task, planner.model, INTERVALS, expand) for _ in range(repeats)]
        if not all(r.converged for r in results):
            cells.append("not converged")
            continue
        base = statistics.median(r.solve_time_s for r in results)
        cells.append(
            f"{1e3 * base:.0f} ({base / cold_time:.1f}x cold, {base / warm_time:.1f}x warm)"
        )
    return cells


def tables(repeats: int, baseline_repeats: int) -> None:
    """Print times of all models, and of the paper's formulation."""
    print(f"ANYmal, {INTERVALS} intervals, milliseconds as median / p95; it = iterations, median")
    columns = [
        "task",
        "model",
        "cold",
        "it",
        "warm",
        "it",
        "total/solve",
        "Opti-expanded",
        "Opti-as-written",
    ]
    print("| " + " | ".join(columns) + " |")
    print("|" + "---|" * len(columns))
    solve: dict[tuple[str, str], float] = {}
    for kind, motion in TASKS.items():
        for model in ("srbm", "llsrbm", "llsrbm-plus"):
            planner = planner_for("anymal", model)
            jump = llsrbm.Jump(model=model, **motion)
            cold(planner, jump, 2)
            cold_reports = cold(planner, jump, repeats)
            warm_reports = warm(planner, model, kind, repeats)
            cold_times = [r.solve_time_s for r in cold_reports]
            warm_times = [r.solve_time_s for r in warm_reports]
            overhead = statistics.median(
                r.total_time_s / r.solve_time_s for r in cold_reports + warm_reports
            )
            median = statistics.median(cold_times)
            solve[kind, model] = median
            row = [
                kind,
                model,
                milliseconds(cold_times),
                f"{statistics.median(r.iterations for r in cold_reports):.0f}",
                milliseconds(warm_times),
                f"{statistics.median(r.iterations for r in warm_reports):.0f}",
                f"{overhead:.2f}",
            ]
            if model != "llsrbm-plus":
                times = median, statistics.median(warm_times)
                row += baseline(planner, jump, baseline_repeats, *times)
            else:
                row += ["", ""]
            print("| " + " | ".join(row) + " |", flush=True)
    for kind in TASKS:
        ratio = solve[kind, "llsrbm-plus"] / solve[kind, "llsrbm"]
        print(f"{kind}: llsrbm-plus takes {ratio:.2f} x the time of llsrbm")


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=15)
    parser.add_argument("--baseline-repeats", type=int, default=3)
    parser.add_argument("--against", metavar="COMMIT", help="an older version to compare with")
    parser.add_argument("--crocoddyl", action="store_true", help="compare with Crocoddyl, too")
    parser.add_argument("--only-compare", action="store_true", help="no tables of models")
    arguments = parser.parse_args()
    load = os.getloadavg()[0]
    if load > 0.5:
        print(f"note: the load is {load:.1f}; times are worth little, ratios a little more")
    if not arguments.only_compare:
        tables(arguments.repeats, arguments.baseline_repeats)
    compare(arguments.repeats, arguments.against, arguments.crocoddyl)


if __name__ == "__main__":
    sys.exit(main())
