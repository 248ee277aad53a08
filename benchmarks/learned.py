"""Iterations that tables of solved jumps save (`python -m benchmarks.learned [--robots go2]`).

The same random requests begin from their drafts and from jumps nearby, one after the other in one
process, with compiled functions. Iterations and wall time of the whole body's problem, whether
certificates hold, and the cost against that from the draft; the share that the table led to is
that which took fewer iterations than from the draft. Last, what `llsrbm.plan` takes, certificate
and all, over a draft.
"""

import time
from collections.abc import Iterator

import numpy as np
import typer

import llsrbm
from benchmarks.range import COMPONENTS, requests
from llsrbm.certificate import certified
from llsrbm.planning.whole_body.refine import refined, refiner_of


def compared(robot: str, count: int, seed: int) -> Iterator[list[float]]:
    """Iterations, s and whether the certificate holds, from draft and table; the cost's ratio, and
    the times of draft and whole plan, s.
    """
    for request in requests(robot, count, seed):
        jump = llsrbm.Jump(
            robot=robot, **{name: request[name] for name in COMPONENTS if name in request}
        )
        begun = time.perf_counter()
        try:
            draft = llsrbm.plan(jump, patient=False, explains=False, draft=True)
        except llsrbm.NotConverged:
            continue
        drafted, row, costs = time.perf_counter() - begun, [], []
        refiner_of(draft).solver.settle()
        for learned in (False, True):
            begun = time.perf_counter()
            plan = refined(draft, learned=learned)
            seconds = time.perf_counter() - begun
            assert plan.refinement is not None
            row += [plan.refinement.iterations, seconds, float(certified(plan).certified)]
            costs.append(plan.refinement.cost)
        begun = time.perf_counter()
        llsrbm.plan(jump, patient=False, explains=False)
        yield [*row, costs[1] / costs[0], drafted, time.perf_counter() - begun]


def main(robots: str = "anymal,go2,slider,g1", jumps: int = 40, seed: int = 6101) -> None:
    """Print a line a robot."""
    for robot in robots.split(","):
        warm = llsrbm.plan(llsrbm.Jump(robot=robot, twist=0.3), draft=True)
        refined(warm)
        rows = np.array([*compared(robot, jumps, seed)])
        middle, sums = np.median(rows, axis=0), rows.sum(axis=0)
        times = rows[:, 8] / rows[:, 7]
        print(
            f"{robot:8} {len(rows)} jumps; iterations {middle[0]:.0f} -> {middle[3]:.0f} (mean "
            f"{sums[0] / len(rows):.1f} -> {sums[3] / len(rows):.1f}); certificates hold "
            f"{sums[2]:.0f} -> {sums[5]:.0f}; time of all {sums[4] / sums[1]:.2f} x; draft and "
            f"whole body over draft {1 + middle[1] / middle[7]:.2f} -> "
            f"{1 + middle[4] / middle[7]:.2f}; fewer iterations in "
            f"{(rows[:, 3] < rows[:, 0]).sum()}; cost {rows[:, 6].min():.3f} to "
            f"{rows[:, 6].max():.3f}; a plan with its certificate over a draft "
            f"{np.median(times):.2f}, p95 {np.percentile(times, 95):.2f}",
            flush=True,
        )


if __name__ == "__main__":
    typer.run(main)
