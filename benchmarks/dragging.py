"""A dragged slider: every plan starts from the one before, along a random walk over all requests.

    python -m benchmarks.dragging [--robot anymal] [--seeds 101:105] [--steps 50] [--compare 5]

A walk drags one slider, or two at once, to a random value in steps of 1-10 degrees or 1-5 cm, then
the next. Prints how many steps were solved from the plan before, CPU time from request to plan of
all steps (failures included), the largest recomputed violation, and how the cost compares with a
cold plan's every few steps. Tuned on seeds below 100.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from collections.abc import Iterator

import numpy as np

import llsrbm
from llsrbm.robots import load_robot

NAMES = ("twist", "forward", "lateral", "height")
STEPS = {"twist": (math.radians(1), math.radians(10))}
SHORT = (0.01, 0.05)  # m, steps of the other sliders
TWO_AT_ONCE = 0.3  # share of the drags
MARGIN = 1.05  # a cost that is worse by more counts as another optimum


def walk(robot: str, seed: int) -> Iterator[dict[str, float]]:
    """Requests of one seed, without an end."""
    rng = np.random.default_rng(seed)
    ranges = {name: getattr(load_robot(robot).file.task, name) for name in NAMES}
    at = dict.fromkeys(NAMES, 0.0)
    yield dict(at)
    while True:
        dragged = rng.choice(NAMES, 2 if rng.random() < TWO_AT_ONCE else 1, replace=False)
        goal = {name: rng.uniform(*ranges[name]) for name in dragged}
        step = {name: rng.uniform(*STEPS.get(name, SHORT)) for name in dragged}
        while any(at[name] != goal[name] for name in dragged):
            for name in dragged:
                at[name] += float(np.clip(goal[name] - at[name], -step[name], step[name]))
            yield dict(at)


def main() -> None:
    """Print one line of figures a seed, and all together."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--robot", default="anymal")
    parser.add_argument("--model", default="llsrbm-plus")
    parser.add_argument("--seeds", default="101:105")
    parser.add_argument("--steps", type=int, default=50)
    parser.add_argument("--compare", type=int, default=5)
    arguments = parser.parse_args()
    print("| seed | steps | from the plan before | iterations, median / p95 | CPU ms, median / p95 "
          "| violation | cost worse / better by 5 % |\n" + "|---" * 7 + "|")  # fmt: skip
    everything: list[tuple[float, ...]] = []
    costs: list[float] = []
    for seed in range(*map(int, arguments.seeds.split(":"))):
        rows, ratios = drag(arguments, seed)
        everything += rows
        costs += ratios
        print_row(str(seed), rows, ratios)
    print_row("all", everything, costs)


def drag(arguments: argparse.Namespace, seed: int) -> tuple[list[tuple[float, ...]], list[float]]:
    """(near, iterations, CPU ms, violation) a step, and costs over cold plans' costs."""
    rows, ratios = [], []
    near: llsrbm.Plan | None = None
    for k, motion in enumerate(walk(arguments.robot, seed)):
        if k > arguments.steps:
            break
        jump = llsrbm.Jump(robot=arguments.robot, model=arguments.model, **motion)
        start = time.process_time()
        try:
            plan = llsrbm.plan(jump, near=near, patient=False)
        except llsrbm.NotConverged as error:
            plan = error.plan
        elapsed = 1e3 * (time.process_time() - start)
        if near is not None:
            violation = max(v.amount for v in plan.violations.values()) if plan.solved else 0.0
            first = plan.solved and plan.report.attempts == 1
            rows.append((first, plan.report.iterations, elapsed, violation, plan.solved))
        near = plan if plan.solved else near
        if k % arguments.compare == 0 and plan.solved:
            try:
                cold = llsrbm.plan(jump, guesses=False, patient=False)
                ratios.append(plan.report.cost / cold.report.cost)
            except llsrbm.NotConverged:
                continue
    return rows, ratios


def print_row(name: str, rows: list[tuple[float, ...]], ratios: list[float]) -> None:
    """One line of the table."""
    first, iterations, elapsed, violation, solved = np.array(rows, dtype=float).T
    cost = np.array(ratios)
    failed = int((1 - solved).sum())
    print(
        f"| {name} | {len(rows)}, {failed} not solved | {100 * first.mean():.1f} % "
        f"| {np.median(iterations):.0f} / {np.percentile(iterations, 95):.0f} "
        f"| {np.median(elapsed):.0f} / {np.percentile(elapsed, 95):.0f} | {violation.max():.1e} "
        f"| {(cost > MARGIN).sum()} / {(cost < 1 / MARGIN).sum()} of {len(cost)}, "
        f"at worst {100 * (cost.max() - 1):+.1f} % |",
        flush=True,
    )


if __name__ == "__main__":
    sys.exit(main())
