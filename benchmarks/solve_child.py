"""Plans on request, in whatever version of the project it is run in: a line in, a line out.

    python benchmarks/solve_child.py ROBOT INTERVALS NAME=VALUE... STEP

Each line on standard input is answered with a cold plan of the jump, and one from the plan before
that is a step of the first number away: JSON of times in s and iterations.
"""

import json
import sys
import time

import llsrbm

try:
    from llsrbm.planning.answer.planner import planner_for
except ModuleNotFoundError:  # versions before `planning.answer`
    from llsrbm.planning.solve.planner import planner_for

MODEL = "llsrbm-plus"


def main() -> None:
    robot, intervals, *motion, step = sys.argv[1:]
    numbers = {name: float(value) for name, value in (item.split("=") for item in motion)}
    first = next(iter(numbers))

    def jump(shift: float) -> llsrbm.Jump:
        moved = numbers | {first: numbers[first] + shift}
        return llsrbm.Jump(robot=robot, model=MODEL, **moved)

    planner = planner_for(robot, MODEL, intervals=int(intervals))
    wait_for_library(planner)
    near = planner.plan(jump(0.0))
    print("ready", flush=True)
    shift = 0.0
    for _ in sys.stdin:
        cold = planner.plan(jump(0.0)).report
        shift = float(step) - shift
        near = planner.plan(jump(shift), near=near)
        print(
            json.dumps(
                {
                    "cold": cold.total_time_s,
                    "cold solve": cold.solve_time_s,
                    "cold iterations": cold.iterations,
                    "near": near.report.total_time_s,
                    "near solve": near.report.solve_time_s,
                    "near iterations": near.report.iterations,
                    "cost": cold.cost,
                }
            ),
            flush=True,
        )


def wait_for_library(planner: object) -> None:
    """Until compiled functions are there, in versions that have them."""
    solver = planner.formulation.solver
    deadline = time.monotonic() + 600.0
    while getattr(solver, "_faster", None) is not None and time.monotonic() < deadline:
        solver._renew()
        time.sleep(0.5)


if __name__ == "__main__":
    main()
