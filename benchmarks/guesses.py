"""The gain by the planner's first guesses: unseen jumps, each planned without and with them.

    python -m benchmarks.guesses [--jumps 200] [--seed 900] [--robots anymal,go2,slider]

Requests are those of `benchmarks.range`: half of them ask for one component, half for all four.
Both plans of a jump are made one after the other in one process, in turns which is first;
iterations and times are of all attempts together. Jumps that only one way plans are counted and not
compared. Cost and CoM are compared with the plan made without guesses: knot by knot, m.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
import typer

import llsrbm
from benchmarks.range import COMPONENTS, requests
from llsrbm.planning.answer.planner import NEARBY, Planner, planner_of

SAME_COST = 1e-3  # relative
QUANTILES = (50, 95, 100)


@dataclass
class Counter:
    """Iterations of all solves since `count` was set to 0."""

    count: int = 0

    def watch(self, planner: Planner) -> None:
        solver = planner.formulation.solver
        solve, follow = solver.solve, solver.follow

        def counted(run: Any) -> Any:
            def running(*args: Any, **options: Any) -> Any:
                solution = run(*args, **options)
                self.count += solution.iterations
                return solution

            return running

        solver.solve, solver.follow = counted(solve), counted(follow)


def planned(planner: Planner, jump: llsrbm.Jump, counter: Counter, *, guesses: bool) -> Any:
    """The plan and its iterations, or None."""
    counter.count = 0
    try:
        plan = planner.plan(jump, guesses=guesses, patient=False)
    except llsrbm.NotConverged:
        return None
    return plan, counter.count


def compare(robot: str, jumps: int, seed: int) -> None:
    planner, counter = planner_of(llsrbm.Jump(robot=robot)), Counter()
    planner.formulation.solver.settle()
    counter.watch(planner)
    planned(planner, llsrbm.Jump(robot=robot), counter, guesses=True)  # reads the table
    pairs, lost, won = [], 0, 0
    for number, request in enumerate(requests(robot, jumps, seed)):
        jump = llsrbm.Jump(robot=robot, **{n: request[n] for n in COMPONENTS if n in request})
        found = {}
        for guesses in (number % 2 == 0, number % 2 == 1):
            found[guesses] = planned(planner, jump, counter, guesses=guesses)
        lost += found[True] is None and found[False] is not None
        won += found[False] is None and found[True] is not None
        if found[True] is not None and found[False] is not None:
            pairs.append((found[False], found[True]))
    cold, warm = ([pair[k] for pair in pairs] for k in (0, 1))
    used = [plan.report.guess == NEARBY for plan, _ in warm]
    print(f"\n{robot}: {len(pairs)} of {jumps} jumps planned both ways; {won} only with guesses, "
          f"{lost} only without; {100 * np.mean(used):.0f} % from solutions nearby")  # fmt: skip
    for name, of in (
        ("iterations", lambda made: made[1]),
        ("solve, ms", lambda made: 1e3 * made[0].report.solve_time_s),
        ("in all, ms", lambda made: 1e3 * made[0].report.total_time_s),
    ):
        before, after = (np.array([of(made) for made in plans]) for plans in (cold, warm))
        print(
            f"  {name:11s} mean {before.mean():6.1f} -> {after.mean():6.1f}, median "
            f"{np.median(before):6.1f} -> {np.median(after):6.1f}, p95 "
            f"{np.percentile(before, 95):6.1f} -> {np.percentile(after, 95):6.1f}; "
            f"{before.sum() / after.sum():.2f} x"
        )
    nearby = [iterations for (_, iterations), own in zip(warm, used, strict=True) if own]
    print(f"  iterations from solutions nearby: mean {np.mean(nearby):.1f}")
    ratio = np.array([b.report.cost / a.report.cost - 1 for (a, _), (b, _) in pairs])
    apart = np.array([np.abs(a.com - b.com).max() for (a, _), (b, _) in pairs])
    same = np.abs(ratio) <= SAME_COST
    quantiles = ", ".join(f"{1e3 * q:.2f}" for q in np.percentile(apart[same], QUANTILES))
    print(
        f"  cost worse by more than 0.1 %: {(ratio > SAME_COST).sum()} (at worst "
        f"{100 * ratio.max():+.3f} %), better: {(ratio < -SAME_COST).sum()} (at best "
        f"{100 * ratio.min():+.2f} %); the other {same.sum()}: CoM apart {quantiles} mm "
        f"(median, p95, largest)",
        flush=True,
    )


def main(
    jumps: int = 200,
    seed: int = 900,
    robots: Annotated[str, typer.Option(help="Names, with commas.")] = "anymal,go2,slider",
) -> None:
    for robot in robots.split(","):
        compare(robot, jumps, seed)


if __name__ == "__main__":
    typer.run(main)
