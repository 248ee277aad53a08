"""How strong a robot's drives would have to be for its flips, and what ends it there.

    python -m benchmarks.turning --robots anymal,solo12,a1 --turns front,back

A robot without [turning] gets Go2's table in proportion to its legs. The first plan is that of
drives `STRONG` times as strong, begun from Go1's plan of the same turn (`benchmarks.similar`). Then
the drives get weaker by steps that are halved where no way leads on: solving from the last motion
under the robot's own limits, then under others. Torque and speed, with the line between them, are
scaled together or alone; plans use the file's shares. Printed are the weakest drives of which a
plan is found, the joints at their limits there, and what the last try violates: no proof.
"""

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Annotated

import numpy as np
import typer

import llsrbm
from benchmarks.similar import like_go2, similar
from llsrbm.planning.answer.planner import Planner
from llsrbm.planning.problem.constraints import drives
from llsrbm.planning.problem.constraints.drive_needs import when_in
from llsrbm.planning.problem.placement import make_task
from llsrbm.planning.problem.task import Task
from llsrbm.planning.problem.violations import describe_worst, excess
from llsrbm.planning.solve.formulation import FROM_CLOSE, FROM_FLIP_GUESS, Attempt, Formulation
from llsrbm.planning.solve.jump_layout import layout_of
from llsrbm.planning.solve.watch import Watch
from llsrbm.robots import load_robot
from llsrbm.robots.robot import Robot

TURNS = {"front": math.tau, "back": -math.tau}
SOURCE = "go1"  # flips both ways from the analytic guess, with drives as they are
# Times the robot's drives: the first plan, the first step, the last one, and the end of the search.
STRONG, STEP, FINEST, LEAST = 6.0, 0.6, 0.94, 0.4
NEAR = 0.8  # steps from which on other limits and weights are tried, too
STEPPED = replace(FROM_CLOSE, iterations=80)
LONGER_PUSH = (0.06, 0.7)  # s; 0.4 at most of the type's
AT_LIMIT = 0.97  # share of a bound from which on a joint is at its limit
# Name -> whether torque, and speed, get weaker.
SCALED = {"both": (True, True), "torque": (True, False), "speed": (False, True)}


def others(task: Task) -> Iterator[Task]:
    """The task, and with other limits and weights: deeper tuck and crouch, a longer push, in less
    time, with knees nearer the ground, legs that swing more evenly.
    """
    reach = task.reach.model_copy(update={"standing": 0.35})
    near, far = reach.distance
    deeper = replace(task, reach=reach.model_copy(update={"distance": (0.8 * near, 1.02 * far)}))
    times = {"push": LONGER_PUSH}
    phases = tuple(replace(p, time=times.get(p.name, p.time)) for p in task.schedule)
    longer = replace(deeper, schedule=replace(task.schedule, phases=phases))
    low = longer.limits.model_copy(update={"knee_margin": 0.02})
    yield from (task, deeper)
    yield replace(longer, limits=low, weights=task.weights | {"time": 6.0})
    effort = 20 * task.weights["swing_effort"]
    yield replace(longer, limits=low, weights=task.weights | {"swing_effort": effort})


def formulation(robot: Robot, turn: str) -> tuple[Formulation, Task]:
    """Formulation and task of a robot's flip."""
    table = robot.file.turning or like_go2(robot)
    robot = replace(robot, file=robot.file.model_copy(update={"turning": table}))
    jump = llsrbm.Jump(robot=robot.name, type="flip", pitch=TURNS[turn])
    robot = robot.turning
    form = Planner(robot, jump.model, layout=layout_of(jump, robot)).formulation
    return form, make_task(jump, robot)


def with_drives(task: Task, torque: float, speed: float) -> Task:
    """The task with so many times the drives' torque and speed."""
    return replace(task, drive_strength=torque, battery=speed)


def weaker(
    form: Formulation, tasks: list[Task], torque: float, speed: float, last: Attempt
) -> Attempt:
    """The first attempt that is solved, from the last motion; or that which violates least."""
    tried = []
    for other in tasks:
        task = replace(with_drives(other, torque, speed), correction=last.task.correction)
        task = replace(task, rolled=last.task.rolled)
        attempt = form.solve(task, last.solution.variables, Watch(), STEPPED)
        tried.append(form.reconciled(attempt, Watch()))
        if tried[-1].solved:
            return tried[-1]
    return min(tried, key=lambda attempt: excess(attempt.violations))


def weakest(
    form: Formulation, base: Task, first: Attempt, which: str
) -> tuple[float, Attempt, str]:
    """Times the drives of the weakest that do, the attempt with them, and what ends the search."""
    k, step, last, ends = STRONG, STEP, first, "not looked for further"
    while step < FINEST and k * step > LEAST:
        torque, speed = (k * step if scaled else STRONG for scaled in SCALED[which])
        tasks = [*others(base)] if step > NEAR else [base]
        attempt = weaker(form, tasks, torque, speed, last)
        if attempt.solved:
            k, last = k * step, attempt
        else:
            ends, step = describe_worst(attempt.violations), math.sqrt(step)
        typer.echo(f"{form.robot.name} {which} {torque:.2f} {speed:.2f} {attempt.solved}", err=True)
    return k, last, ends


def at_limits(attempt: Attempt) -> str:
    """Joints at the limits of their drives, each once, and when they first are."""
    knots, found = attempt.knots, dict[str, str]()
    for rows in drives.DRIVES:
        shares = np.abs(rows.checked_shares(knots)) / rows.tops(attempt.task)[:, None]
        for interval, _, joint in np.argwhere(np.nan_to_num(shares) > AT_LIMIT):
            name = f"{rows.name} {knots.task.robot.joint_names[joint]}"
            found.setdefault(name, when_in(knots.loads, int(interval)))
    return ", ".join(f"{name} {when}" for name, when in found.items())


def main(
    robots: str = "anymal,anymal_c,solo12",
    turns: str = "front,back",
    scaled: Annotated[str, typer.Option(help="both, torque, speed.")] = "both,torque,speed",
) -> None:
    print("| robot | turn | scaled | smallest | phases | at their limits | violated next |")
    print("|---|---|---|---|---|---|---|", flush=True)
    for turn in turns.split(","):
        form, task = formulation(load_robot(SOURCE), turn)
        strong = with_drives(task, STRONG, STRONG)
        source = form.reconciled(
            form.solve(strong, form.guess(strong), Watch(), FROM_FLIP_GUESS), Watch()
        )
        for name in robots.split(","):
            form, task = formulation(load_robot(name), turn)
            strong = with_drives(task, STRONG, STRONG)
            guess = similar(source, form, strong)
            first = form.reconciled(form.solve(strong, guess, Watch(), FROM_FLIP_GUESS), Watch())
            first = first if first.solved else weaker(form, [task], STRONG, STRONG, first)
            if not first.solved:
                why = describe_worst(first.violations)
                print(f"| {name} | {turn} | | none up to {STRONG:g} | | | {why} |", flush=True)
                continue
            for which in scaled.split(","):
                k, last, ends = weakest(form, task, first, which)
                phases = ", ".join(f"{d:.2f}" for d in last.knots.durations)
                cells = f"{k:.2f} | {phases} s | {at_limits(last)} | {ends} |"
                print(f"| {name} | {turn} | {which} | {cells}", flush=True)


if __name__ == "__main__":
    typer.run(main)
