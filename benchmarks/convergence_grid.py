"""Which jumps are planned from the analytic guess alone: the grid of the issue, three models.

python benchmarks/convergence_grid.py [--robot anymal] [--models srbm llsrbm llsrbm-plus]
"""

from __future__ import annotations

import argparse
import itertools
import math

import numpy as np

import llsrbm
from llsrbm import models


def jumps() -> list[dict[str, float]]:
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
    arguments = parser.parse_args()
    for model in arguments.models:
        first, iterations, worst, failed = 0, [], 0.0, 0
        for motion in jumps():
            jump = llsrbm.Jump(robot=arguments.robot, model=model, **motion)
            try:
                plan = llsrbm.plan(jump)
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
            f"{model}: {first} of {len(jumps())} from the analytic guess, "
            f"{len(iterations) - first} by further attempts, {failed} not; iterations "
            f"{np.median(iterations):.0f} median, {max(iterations)} most; "
            f"largest violation {worst:.1e}",
            flush=True,
        )


if __name__ == "__main__":
    main()
