"""Makes the plans that tabs begin with on a first start: `python -m benchmarks.initial_plans`.

To be run after a change of a robot file or of the planner that changes the examples' plans, and
after one of the plan file's schema; `tests/app/tab/start/test_initial_plan.py` fails until it is.
"""

import typer

import llsrbm
from app.tab.start.initial_plan import example, shipped_file
from llsrbm.robots import names


def main() -> None:
    """Make the plan of every robot's example."""
    for robot in names():
        plan = llsrbm.plan(example(robot))
        path = shipped_file(robot)
        path.parent.mkdir(exist_ok=True)
        plan.save(path)
        worst = max(violation.amount for violation in plan.violations.values())
        print(
            f"{path.name:12s} {path.stat().st_size / 1024:4.0f} KB, {plan.effort.iterations} "
            f"iterations, largest violation {worst:.1e}, certified: {plan.certified}"
        )


if __name__ == "__main__":
    typer.run(main)
