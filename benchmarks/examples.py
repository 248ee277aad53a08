"""Plan and simulate every example design and print how it went: `python benchmarks/examples.py`.

Optional arguments are the names of the examples to run.
"""

import math
import sys

import llsrbm
from llsrbm.analysis.wording import worst_violation
from llsrbm.request.design import Design, examples

COLUMNS = (
    "| example | plan | iterations | solve | duration | simulated | strict | yaw at touchdown "
    "- plan | feet | tilt at the end | torque |"
)


def row(name: str, design: Design) -> str:
    tuning, scenario = design.tuning, design.scenario
    try:
        plan = llsrbm.plan(design.jump, weights=tuning.weights, limits=tuning.limits)
    except llsrbm.NotConverged as error:
        return f"| {name} | failed: {error} |"
    rollout = llsrbm.simulate(plan, scenario)
    effort, outcome = plan.effort, rollout.outcome
    cells = (
        name,
        f"{plan.report.status}, {worst_violation(plan)}",
        f"{effort.iterations}",
        f"{1e3 * effort.solve_time_s:.0f} ms",
        f"{plan.duration:.2f} s",
        outcome.status + (f" ({outcome.reason})" if outcome.reason else ""),
        "yes" if outcome.strict else "no",
        f"{math.degrees(outcome.yaw_error_at_touchdown or math.nan):+.1f}°",
        f"{1e3 * outcome.foot_error:.0f} mm",
        f"{math.degrees(outcome.final_tilt):.1f}°",
        f"{100 * outcome.peak_torque_ratio:.0f} %",
    )
    return "| " + " | ".join(cells) + " |"


def main(names: list[str]) -> None:
    print(COLUMNS)
    print("|" + "---|" * (COLUMNS.count("|") - 1))
    for name, design in examples().items():
        if not names or name in names:
            print(row(name, design), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
