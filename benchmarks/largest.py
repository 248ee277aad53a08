"""The largest jumps of a robot, one component at a time, each plan begun from the one before.

    python -m benchmarks.largest --robots g1 --components twist --seeds 10000:10020
    python -m benchmarks.largest --robots talos --arms free,held --seeds 10100:10120
    python -m benchmarks.largest --robots g1 --components twist --limit flight_max=0.9
    python -m benchmarks.largest --robots g1 --components twist --without shoulder,elbow

The robot file's [task] does not bound it. A component grows by steps, which are halved where no way
leads on: following, solving from the last motion, from that motion moved as the analytic guesses
differ, and from the analytic guess; then the same under other weights, which guide the search and
bound nothing: of each `--weight` the set. Constraints that the last try violates are printed.
`--limit` may be outside of the range that requests take; `--without` takes the drives'
limits off all joints that have such a word in their names; `--wide-arms` lets arms move up to their
stops. `--seeds` simulates the largest with everything disturbed, `--at` other values on the way,
too.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Annotated, Any

import numpy as np
import typer
from scipy.spatial.transform import Rotation

import llsrbm
from benchmarks.counting import count, seeds_of
from benchmarks.jump_types import failures
from llsrbm.motion.plan import Plan
from llsrbm.ocp import solvers
from llsrbm.planning.answer.planner import planner_of
from llsrbm.planning.problem.constraints import drive_rows, drives
from llsrbm.planning.problem.limits import put_limits
from llsrbm.planning.problem.placement import make_task
from llsrbm.planning.problem.task import Task
from llsrbm.planning.problem.violations import describe_worst, excess
from llsrbm.planning.solve.formulation import FROM_CLOSE, Attempt, Formulation
from llsrbm.planning.solve.watch import Watch
from llsrbm.request.scenario import Scenario
from llsrbm.request.tuning import Tuning
from llsrbm.robots import load_robot
from llsrbm.robots.robot import Robot
from llsrbm.simulation.simulate import simulate

# Name -> component, first step and last one, in rad and m.
GROWING = {
    "twist": ("twist", math.radians(20), math.radians(2)),
    "forward": ("forward", 0.1, 0.01),
    "up": ("height", 0.1, 0.005),
}
WIDE = {"twist": (-12.0, 12.0), "forward": (-3.0, 3.0), "height": (-2.0, 2.0)}
NO_LIMIT = 20.0  # times what a drive gives, of drives without limits; rows have finite bounds
REGROWN = 1.4  # times the step, where one has led on
FURTHEST = 720.0  # deg, or m: where the search ends


def widened(robot: Robot, *, wide_arms: bool = False) -> Robot:
    """The robot with ranges that are in nobody's way."""
    changes: dict[str, Any] = {"task": robot.file.task.model_copy(update=WIDE)}
    if wide_arms and robot.file.arm_reach is not None:
        ends = np.full(len(robot.file.arm_reach.lower), 9.0)
        reach = {"lower": tuple(-ends), "upper": tuple(ends)}
        changes["arm_reach"] = robot.file.arm_reach.model_copy(update=reach)
    other = replace(robot, file=robot.file.model_copy(update=changes))
    vars(other)["fit"] = robot.fit
    return other


def ignore_drives(robot: Robot, words: list[str]) -> None:
    """Take the drives' limits off joints, for the rest of this process."""
    names = enumerate(robot.joint_names)
    free = [number for number, name in names if any(word in name for word in words)]
    bounds_of, planned = drive_rows.DriveConstraint.bounds, drive_rows.of_planned

    def bounds(self: Any, task: Task, layout: Any, knot: int) -> Any:
        legs = task.robot.leg_joint_index
        landing, beside = self._further_legs(layout.roles[knot])
        rows = [legs, legs[list(landing)], legs[list(beside)], task.free_arms]
        mine = np.isin(np.concatenate([row.ravel() for row in rows]), free)
        lower, upper = (np.array(end) for end in bounds_of(self, task, layout, knot))
        return np.where(mine, -NO_LIMIT, lower), np.where(mine, NO_LIMIT, upper)

    def of_planned(amounts: Any, knots: Any) -> Any:
        amounts = planned(amounts, knots)
        amounts[..., free] = -np.inf
        return amounts

    drive_rows.DriveConstraint.bounds = bounds  # type: ignore[method-assign]
    drive_rows.of_planned = drives.of_planned = of_planned


def ways(form: Formulation, task: Task, last: Attempt | None) -> Iterator[Callable[[], Attempt]]:
    """Solves of a task, from what was planned before."""
    watch = Watch()
    if last is not None:
        before = form.with_shifted_bounds(last).agreed_bounds
        minded = replace(task, agreed_bounds=before)
        yield lambda: form.follow(minded, last.solution, watch)
        yield lambda: form.solve(minded, last.solution.variables, watch, FROM_CLOSE)
        yield lambda: form.solve(task, form.moved(last, task), watch, solvers.FROM_GUESS)
    yield lambda: form.solve(task, form.guess(task), watch, solvers.FROM_GUESS)


def attempted(
    form: Formulation, jump: llsrbm.Jump, tunings: list[Tuning], last: Attempt | None
) -> Attempt:
    """The first attempt that is solved, or else that which violates least.

    The weights of the last one come first.
    """
    tried = []
    for tuning in sorted(tunings, key=lambda own: last is None or own is not last.task.tuning):
        task = put_limits(make_task(jump, form.robot, tuning.weights), tuning.limits)
        task = replace(task, tuning=tuning)
        for solve in ways(form, task, last):
            tried.append(form.reconciled(solve(), Watch()))
            if tried[-1].solved:
                return tried[-1]
    return min(tried, key=lambda attempt: excess(attempt.violations))


def grown(
    form: Formulation,
    jump: llsrbm.Jump,
    kind: str,
    tunings: list[Tuning],
    at: list[float],
) -> tuple[dict[float, Attempt], str]:
    """Value -> attempt of the values in `at` and the largest that is planned; and what ends it.

    `at`: values on the way, in the component's own unit.
    """
    name, first, finest = GROWING[kind]
    step, value, last, kept, why = first, 0.0, None, dict[float, Attempt](), ""
    while step > 0.99 * finest:
        ahead = [v for v in at if value + 1e-9 < v < value + step - 1e-9]
        aim = min(ahead, default=value + step)
        attempt = attempted(form, replace(jump, **{name: aim}), tunings, last)
        if attempt.solved:
            value, last, step = aim, attempt, min(REGROWN * step, first)
            print(f"  {shown(kind, aim)}", flush=True)
            if any(abs(aim - v) < 1e-9 for v in at):
                kept[aim] = attempt
        else:
            why = f"{shown(kind, aim)}: {describe_worst(attempt.violations, attempt.knots)}"
            step = (aim - value) / 2
        if value > FURTHEST:
            break
    if last is not None:
        kept[value] = last
    return kept, why


def shown(kind: str, value: float) -> str:
    return f"{math.degrees(value):.0f} deg" if kind == "twist" else f"{value:.3f} m"


def figures(attempt: Attempt, plan: Plan) -> str:
    """Durations, and what turns a twist."""
    knots, phases = attempt.knots, ", ".join(f"{d:.2f}" for d in attempt.knots.durations)
    flight = knots.flights[0]
    air = slice(flight.start, flight.stop + 1)
    yaw = np.unwrap(Rotation.from_quat(plan.base_quat, scalar_first=True).as_euler("ZYX")[:, 0])
    before, after = np.degrees([yaw[flight.start], yaw[-1] - yaw[flight.stop]])
    vertical = plan.inertia[air, 2, 2]
    return (
        f"phases {phases} s; Lz {plan.angular_momentum[flight.start, 2]:.2f} kg m2/s, Izz in "
        f"flight {vertical.max():.2f} to {vertical.min():.2f} kg m2; turned on the ground "
        f"{before:.0f} deg before and {after:.0f} after flight"
    )


def main(
    robots: Annotated[str, typer.Option(help="Names, with commas.")] = "g1",
    components: str = "forward,up,twist",
    arms: Annotated[str, typer.Option(help="free, held or both.")] = "free",
    limit: Annotated[list[str] | None, typer.Option(help="NAME=VALUE, SI units.")] = None,
    weight: Annotated[list[str] | None, typer.Option(help="Sets of NAME=VALUE.")] = None,
    without: Annotated[str, typer.Option(help="Words in names of joints.")] = "",
    wide_arms: Annotated[bool, typer.Option("--wide-arms")] = False,
    at: Annotated[str, typer.Option(help="Further values to simulate; deg, m.")] = "",
    seeds: Annotated[str, typer.Option(help="First:last+1 of simulations.")] = "",
) -> None:
    limits = given(limit or [])
    tunings = [Tuning(given(words.split(",")), limits) for words in weight or []]
    tunings = tunings or [Tuning({}, limits)]
    for robot in robots.split(","):
        if without:
            ignore_drives(load_robot(robot), without.split(","))
        for held in arms.split(","):
            jump = llsrbm.Jump(robot=robot, arms=held)
            own = planner_of(jump).formulation
            form = replace(own, robot=widened(own.robot, wide_arms=wide_arms))
            for kind in components.split(","):
                values = [float(v) for v in at.split(",") if v]
                if kind == "twist":
                    values = [math.radians(v) for v in values]
                kept, why = grown(form, jump, kind, tunings, values)
                for value, attempt in kept.items():
                    plan = form.plan(attempt, 1, 0.0, 0.0)
                    text = f"{robot} arms {held} {kind}: {shown(kind, value)}; "
                    print(text + figures(attempt, plan), flush=True)
                    if seeds:
                        print("  " + landed(plan, form.robot, seeds_of(seeds)), flush=True)
                print(f"  ends at {why}", flush=True)


def given(words: list[str]) -> dict[str, float]:
    return {name: float(value) for name, value in (word.split("=") for word in words)}


def landed(plan: Plan, robot: Robot, seeds: range) -> str:
    """How many seeds are strict, and why the others are not."""
    made = [simulate(plan, robot, Scenario(seed=seed)).outcome for seed in seeds]
    counts = count(made)
    return f"of {counts.requests}: {counts.strict} strict, {counts.stand} land; {failures(made)}"


if __name__ == "__main__":
    typer.run(main)
