"""The cost of not knowing the drives: plans and controllers with and without rotors and friction.

    python -m benchmarks.known_drives --robot go2 --requests 24 --seed 40

Random requests over the robot's range, those of `benchmarks.range`, everything disturbed. Whatever
plan and controller believe, the robot that is simulated has the drives of its file, unless a row
says otherwise. Columns: strict landings, landings, plans; medians of the largest tilt, and of the
torque's RMS error over the take-off as a share of its limit.
"""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import typer

import llsrbm
import llsrbm.simulation.simulate as simulation
from benchmarks.range import COMPONENTS, requests, torque_rms
from llsrbm.motion.plan import Plan
from llsrbm.planning.answer.planner import planner_of
from llsrbm.robots import load_robot
from llsrbm.robots.drives.variants import ideal
from llsrbm.robots.robot import Robot
from llsrbm.simulation.disturbance import draw_disturbance
from llsrbm.simulation.world import World


class Row(NamedTuple):
    """The drives that each is made for: "true" ones, "ideal" ones, or "no friction"."""

    plan: str
    controller: str
    simulated: str = "true"
    friction: float | None = None  # that is simulated, of the file's; None: drawn


ROWS = (
    Row("ideal", "ideal", "ideal"),
    Row("ideal", "ideal"),
    Row("ideal", "true"),
    Row("true", "ideal"),
    Row("true", "no friction"),
    Row("true", "true"),
    Row("true", "true", friction=0.5),
    Row("true", "true", friction=2.0),
)


def believed(robot: Robot, kind: str) -> Robot:
    """The robot as a row has it."""
    if kind == "ideal":
        return ideal(robot)
    if kind == "true":
        return robot
    drives = robot.file.drives.model_copy(update={"friction": 0.0, "damping": 0.0, "joints": {}})
    return replace(robot, file=robot.file.model_copy(update={"drives": drives}))


def planned(robot: Robot, kind: str, count: int, seed: int) -> list[tuple[int, Plan]]:
    """Plans of the requests, with the seeds of their disturbances."""
    plans = []
    for request in requests(robot.name, count, seed):
        motion = {name: request[name] for name in COMPONENTS if name in request}
        jump = llsrbm.Jump(robot=robot.name, **motion)
        try:
            plan = planner_of(jump, robot=believed(robot, kind)).plan(jump, explains=False)
        except llsrbm.NotConverged:
            continue
        plans.append((request["seed"], plan))
    return plans


def figures(robot: Robot, row: Row, plans: list[tuple[int, Plan]]) -> str:
    """A row of the table."""
    there, knows = believed(robot, row.simulated), believed(robot, row.controller)

    def world(_: Robot, *rest: Any) -> World:
        return World(there, *rest)

    def drawn(_: Robot, scenario: llsrbm.Scenario) -> Any:
        found = draw_disturbance(there, scenario)
        factor = found.joint_friction_factor if row.friction is None else row.friction
        return replace(found, joint_friction_factor=factor)

    vars(simulation).update(World=world, draw_disturbance=drawn)
    outcomes, errors = [], []
    for seed, plan in plans:
        rollout = simulation.simulate(plan, knows, llsrbm.Scenario(seed=seed))
        outcomes.append(rollout.outcome)
        errors.append(torque_rms(plan, rollout))
    strict = sum(outcome.strict for outcome in outcomes)
    land = sum(outcome.status == "landed" for outcome in outcomes)
    tilt = np.degrees(np.median([outcome.peak_tilt for outcome in outcomes]))
    friction = "" if row.friction is None else f", friction {row.friction:g} ×"
    return (
        f"| {row.plan} | {row.controller} | {row.simulated}{friction} | {strict} ({land}) of "
        f"{len(plans)} | {tilt:.1f}° | {100 * np.median(errors):.1f} % |"
    )


def main(robot: str = "go2", count: int = typer.Option(24, "--requests"), seed: int = 40) -> None:
    """Print the table."""
    there = load_robot(robot)
    plans = {kind: planned(there, kind, count, seed) for kind in ("ideal", "true")}
    print("| plan knows | controller knows | simulated | strict (land) | tilt | torque |")
    print("|---" * 6 + "|")
    for row in ROWS:
        print(figures(there, row, plans[row.plan]), flush=True)


if __name__ == "__main__":
    typer.run(main)
