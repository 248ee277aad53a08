"""Which jumps are planned from the analytic guess alone: the grid of the issue, three models.

python benchmarks/convergence_grid.py [--robot anymal] [--fine] [--models ...]
"""

from __future__ import annotations

import argparse
import itertools
import math

import numpy as np

import llsrbm
from llsrbm import models
from llsrbm.robots import load_robot


def jumps(robot: str, fine: bool) -> list[dict[str, float]]:
    """Jumps of the grid that are in the robot's range."""
    task = load_robot(robot).file.task

    def allowed(name: str, value: float) -> bool:
        low, high = getattr(task, name)
        return bool(low - 1e-4 <= value <= high + 1e-4)

    wanted = everything() + (small_steps() if fine else [])
    return [jump for jump in wanted if all(allowed(*item) for item in jump.items())]


def small_steps() -> list[dict[str, float]]:
    """Twist -90 ... 90 deg by 15, boxes 0.05 ... 0.35 m high and 0.2 m ahead by 0.05."""
    twists = [{"twist": math.radians(twist)} for twist in range(-90, 91, 15)]
    return twists + [{"height": height / 100, "forward": 0.2} for height in range(5, 36, 5)]


def everything() -> list[dict[str, float]]:
    """Twist -180 ... 180 deg x forward 0 ... 0.6 m, then lateral, heights and mixes."""
    grid = [
        {"twist": math.radians(twist), "forward": forward}
        for twist, forward in itertools.product(range(-180, 181, 30), (0.0, 0.2, 0.4, 0.6))
    ]
    lateral = [
        {"lateral": side, "twist": math.radians(twist)}
        for side, twist in itertools.product((-0.3, -0.15, 0.15, 0.3), (0, 90))
    ]
    heights = [
        {"height": height, "forward": forward, "twist": math.radians(twist)}
        for height, forward, twist in itertools.product(
            (-0.2, -0.1, 0.1, 0.2, 0.3), (0.0, 0.3), (0, 90)
        )
    ]
    return grid + lateral + heights


def main() -> None:
    """Print a line a failure and a line a model."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robot", default="anymal")
    parser.add_argument("--models", nargs="+", default=models.names())
    parser.add_argument("--fine", action="store_true", help="twists and boxes in small steps too")
    arguments = parser.parse_args()
    wanted = jumps(arguments.robot, arguments.fine)
    for model in arguments.models:
        first, iterations, worst, failed = 0, [], 0.0, 0
        for motion in wanted:
            jump = llsrbm.Jump(robot=arguments.robot, model=model, **motion)
            try:
                plan = llsrbm.plan(jump, guesses=False)
            except llsrbm.NotConverged as error:
                failed += 1
                print(f"  {error}", flush=True)
                continue
            first += plan.report.attempts == 1
            if plan.report.attempts > 1:
                print(f"  {motion}: {plan.report.attempts} attempts", flush=True)
            iterations.append(plan.report.iterations)
            worst = max(worst, *(v.amount for v in plan.violations.values()))
        print(
            f"{model}: {first} of {len(wanted)} from the analytic guess, "
            f"{len(iterations) - first} by further attempts, {failed} not; iterations "
            f"{np.median(iterations):.0f} median, {max(iterations)} most; "
            f"largest violation {worst:.1e}",
            flush=True,
        )


if __name__ == "__main__":
    main()
