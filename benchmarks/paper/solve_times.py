"""Solve times: the paper's table beside this machine's, as ratios."""

import math
import statistics
from collections.abc import Callable
from pathlib import Path

import llsrbm
from benchmarks.paper.drawing import TITLE
from benchmarks.paper.result import AGREES, NOT, PARTLY, Result, Table
from benchmarks.solve_child import wait_for_library
from llsrbm.ocp.horizon import Solution
from llsrbm.ocp.solvers import FROM_GUESS
from llsrbm.planning.answer.planner import planner_for
from llsrbm.planning.problem.placement import make_task

REPEATS = 9
TASKS = {
    "quadruped, forward": ("anymal", {"forward": 0.3}),
    "quadruped, twist": ("anymal", {"twist": math.radians(90)}),
    "biped, forward": ("slider", {"forward": 0.2}),
    "biped, twist": ("slider", {"twist": math.radians(90)}),
}
PAPER = {"srbm": (1.50, 2.45, 6.33, 5.44), "llsrbm": (1.53, 2.56, 9.54, 7.37)}  # s
PAPERS_MEAN = 33.6  # %, what LL-SRBM costs more


def result(_folder: Path) -> Result:
    models = ("srbm", "llsrbm", "llsrbm-plus")
    here: dict[str, list[float]] = {model: [] for model in models}
    for robot, motion in TASKS.values():
        solves = {m: _solve(llsrbm.Jump(robot=robot, model=m, **motion)) for m in models}
        times: dict[str, list[float]] = {model: [] for model in models}
        for _ in range(REPEATS):  # in turns: what else the machine does meets all
            for model, solve in solves.items():
                times[model].append(solve().solve_time_s)
        for model in models:
            here[model].append(statistics.median(times[model]))
    more = {
        model: [here[model][k] / here["srbm"][k] for k in range(len(TASKS))] for model in models
    }
    mean = 100 * (statistics.mean(more["llsrbm"]) - 1)
    paper = [b / a for a, b in zip(PAPER["srbm"], PAPER["llsrbm"], strict=True)]
    papers_mean = 100 * (statistics.mean(paper) - 1)
    rows = [["paper, LL-SRBM / SRBM", *(f"{ratio:.2f} ×" for ratio in paper)]]
    rows += [
        [f"here, {TITLE[m]} / SRBM", *(f"{ratio:.2f} ×" for ratio in more[m])] for m in models[1:]
    ]
    rows += [[f"paper, {TITLE[m]}", *(f"{t:.2f} s" for t in PAPER[m])] for m in models[:2]]
    rows += [[f"here, {TITLE[m]}", *(f"{1e3 * t:.0f} ms" for t in here[m])] for m in models]
    alike = PAPERS_MEAN / 2 < mean < 2 * PAPERS_MEAN
    reason = (
        f"LL-SRBM costs {mean:.0f} % more than SRBM on the average of the four tasks, LL-SRBM+ "
        f"{100 * (statistics.mean(more['llsrbm-plus']) - 1):.0f} %. The paper's own table makes "
        f"{papers_mean:.0f} %, not {PAPERS_MEAN} %, as a mean of its ratios; the sums of its "
        f"columns make {100 * (sum(PAPER['llsrbm']) / sum(PAPER['srbm']) - 1):.1f} %. Everything "
        "here keeps to the drives, which the paper's plans do not, with SRBM too; absolute times "
        "are another solver's on another machine."
    )
    return Result(
        "Solve times",
        f"LL-SRBM increases the computation time by {PAPERS_MEAN} % on average.",
        [Table(("", *TASKS), rows)],
        [],
        AGREES if alike else PARTLY if mean < PAPERS_MEAN else NOT,
        reason,
    )


def _solve(jump: llsrbm.Jump) -> Callable[[], Solution]:
    """One solve from the analytic guess, as the paper times it: no table, no correction."""
    planner = planner_for(jump.robot, jump.model)
    wait_for_library(planner)
    formulation = planner.formulation
    task = make_task(jump, planner.robot)
    problem, guess = formulation.problem(task), formulation.guess(task)
    return lambda: formulation.solver.solve(problem, guess, options=FROM_GUESS)
