"""The same jumps by several planners, in turns, and one table: `python -m benchmarks.peers`.

Times are medians of solves in turns, so that what else the machine does meets all; every motion is
judged by `judge.py`, with ANYmal's drives and a floor of friction 0.5. `docs/peers.md` is written
anew. Crocoddyl is installed into an environment of its own on the first run.
"""

import argparse
import math
import statistics
from pathlib import Path

from benchmarks.peers.judge import Verdict, judge
from benchmarks.peers.planners import PLANNERS, Answer
from llsrbm.robots import load_robot

TASKS = {"30 cm forward": (0.0, 0.3), "90° twist": (math.radians(90), 0.0)}
HEADING = (
    "planner", "converged", "time", "iterations", "arrives", "torque", "joint speed", "friction",
    "feet clear", "impact", "a robot could not do",
)  # fmt: skip
MEANINGLESS = 10.0  # times a limit: feet that step between knots, or are out of reach
DOCS = Path(__file__).parents[2] / "docs"
HEAD = """# Other planners, judged alike

Written by `make peers` (`python -m benchmarks.peers`). ANYmal, the same two jumps, solves in turns
in one run: time is that in the solver from a cold start, median, and as a multiple of the first
row's. Torque is the largest share of what a drive gives at its speed, joint speed the largest share
of its limit, friction the largest horizontal force as a share of what a floor of 0.5 holds,
clearance the lowest foot in mid-flight above where feet stand; all computed by one checker
(`benchmarks/peers/judge.py`), torques of centroidal plans by inverse dynamics of the whole body in
the postures that realise them, Crocoddyl's as it says.

- **Opti + Ipopt** is the paper's formulation with 48 intervals (`benchmarks/opti_baseline.py`). It
  knows no drives and bounds no foot's speed: feet step to where they swing from one knot to the
  next, which no joint can follow. Its friction pyramid reaches out of the cone by up to 41 %.
- **Crocoddyl** plans the whole body with a given sequence of contacts and given times, from its
  example of a jump (`createJumpingProblem`), 10 ms a knot. It has penalties in place of limits, an
  impact at touchdown, and no problem of a twist; its free end is 10 knots after touchdown. FDDP
  knows no limits; BoxFDDP and mim_solvers' CSQP bound the torques by the drives' 40 Nm, at any
  speed, and are given 100 iterations.
- **Refined** goes on from the row above it with the whole body's equations of motion, its time and
  iterations are those of both stages, its torques those of the second.
- Looked for and left out: Drake and casadi_horizon are on the package index, but nobody has written
  this jump for them here; TOWR, OCS2, acados and hippopt are not on it, and the package of
  aligator's name is another project.
"""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=5, help="solves of each, in turns")
    repeats = parser.parse_args().repeats
    robot = load_robot("anymal")
    for planner in PLANNERS:
        planner.prepare()
    parts = [HEAD.strip()]
    try:
        for title, (twist, forward) in TASKS.items():
            answers: dict[str, list[Answer]] = {planner.name: [] for planner in PLANNERS}
            for _ in range(repeats):
                for planner in PLANNERS:
                    answer = planner.plan(twist, forward)
                    if answer is not None:
                        answers[planner.name].append(answer)
            rows = _rows(robot, {name: found for name, found in answers.items() if found})
            parts += [f"## {title}", _table(rows)]
            print(f"{title}\n{_table(rows)}\n", flush=True)
    finally:
        for planner in PLANNERS:
            planner.end()
    (DOCS / "peers.md").write_text("\n\n".join(parts) + "\n", encoding="utf-8")


def _rows(robot: object, answers: dict[str, list[Answer]]) -> list[list[str]]:
    times = {name: statistics.median(a.seconds for a in found) for name, found in answers.items()}
    first = next(iter(times.values()))
    rows = []
    for name, found in answers.items():
        last = found[-1]
        verdict = judge(robot, last.motion)
        rows.append(
            [
                name,
                "yes" if all(answer.converged for answer in found) else "no",
                f"{1e3 * times[name]:.0f} ms, {times[name] / first:.1f} ×",
                f"{statistics.median(a.iterations for a in found):.0f}",
                f"{math.degrees(last.turned):.1f}°, {100 * last.moved:.1f} cm",
                *_figures(verdict),
                ", ".join(verdict.violated) or "–",
            ]
        )
    return rows


def _figures(verdict: Verdict) -> list[str]:
    return [
        "beyond its speed" if math.isinf(verdict.torque) else f"{100 * verdict.torque:.0f} %",
        f"{100 * verdict.speed:.0f} %" if verdict.speed < MEANINGLESS else "over 10 ×",
        f"{100 * verdict.friction:.0f} %",
        f"{100 * verdict.clearance:.1f} cm",
        f"{verdict.impulse:.0f} N s",
    ]


def _table(rows: list[list[str]]) -> str:
    lines = [HEADING, ["---"] * len(HEADING), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


if __name__ == "__main__":
    main()
