"""Solves jumps over a robot's whole range, for later ones to begin from (`llsrbm robot learn`)."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats.qmc import Halton

from llsrbm.analysis.summaries import planned_peak_load
from llsrbm.certificate import certified, stated
from llsrbm.errors import InputError, NotConverged
from llsrbm.files.atomic import check_place
from llsrbm.motion.plan import Plan
from llsrbm.planning.answer.planner import planner_of
from llsrbm.planning.problem.placement import make_task
from llsrbm.planning.problem.violations import worst_of
from llsrbm.planning.solve.watch import Watch
from llsrbm.planning.whole_body.learned import NEIGHBOURS, Learned, Refused, Solved
from llsrbm.planning.whole_body.learned_file import places, read, write
from llsrbm.planning.whole_body.refine import Refiner, refiner_of
from llsrbm.request.jump import COMPONENTS, Jump
from llsrbm.robots.robot import Robot

JUMPS = 120  # of a table; of 76 three to ten iterations are left of some twenty
SAVED_EVERY = 10  # jumps
NOT_PLANNED = "not planned"  # what stops a jump where no constraint or check is named
# Most people ask for one or two components: of the second of two jumps only these are left.
_LEFT = [set(names) for count in (1, 2) for names in combinations(COMPONENTS, count)]


def learn(
    robot: Robot,
    count: int = JUMPS,
    out: Path | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> tuple[Path, Learned]:
    """Solve jumps and keep those whose certificate holds, with what stops the others; goes on from
    what a file has.

    Args:
        robot: whose jumps of the default type.
        count: requests, from which the file's own are left out.
        out: the file; None: the robot's in the cache.
        progress: told how many requests were looked at, and of how many.

    Returns:
        The file, and its table.

    Raises:
        InputError: fewer jumps were found than a table needs, or the file cannot be written.
    """
    if out is not None:
        check_place(out)
    refiner = _refiner(robot)
    path = out or places(robot, refiner.grid)[1]
    table = read(path, robot, refiner.grid)
    solved = [] if table is None else table.solved(robot)
    refused = [] if table is None else table.outcomes.refusals(robot)
    known = {each.jump for each in solved} | {each.jump for each in refused}
    for number, jump in enumerate(requests(robot, count), 1):
        if jump not in known:
            match _looked_at(jump, refiner):
                case Solved() as found:
                    solved.append(found)
                case Refused() as found:
                    refused.append(found)
        if progress is not None:
            progress(number, count)
        enough = len(solved) >= NEIGHBOURS
        if enough and (number % SAVED_EVERY == 0 or number == count):
            table = Learned.of(solved, refused, robot)
            path.parent.mkdir(parents=True, exist_ok=True)
            write(path, table, robot, refiner.grid)
    if table is None:
        raise InputError(
            f"{robot.name}: certificates of {len(solved)} of {count} jumps hold; expected at least "
            f"{NEIGHBOURS} for a table: more jumps, or ranges that the robot can do"
        )
    return path, table


def requests(robot: Robot, count: int) -> Iterator[Jump]:
    """Jumps all over a robot's range, the same every time."""
    ranges = np.array([getattr(robot.file.task, name) for name in COMPONENTS])
    shares = Halton(len(COMPONENTS), scramble=False).random(count // 2 + 2)[1:]
    values = ranges[:, 0] + shares * np.ptp(ranges, axis=1)
    plain = Jump(robot=str(robot.path))
    for number in range(count):
        components: dict[str, Any] = dict(
            zip(COMPONENTS, values[number // 2].tolist(), strict=True)
        )
        if number % 2:
            left = _LEFT[number // 2 % len(_LEFT)]
            components |= {name: 0.0 for name in COMPONENTS if name not in left}
        yield replace(plain, **components)


def _refiner(robot: Robot) -> Refiner:
    """The refiner of jumps of the default type, its solver compiled where that can be."""
    plain = Jump(robot=str(robot.path))
    refiner = refiner_of(planner_of(plain).plan(plain), robot)
    refiner.solver.settle()
    return refiner


def _looked_at(jump: Jump, refiner: Refiner) -> Solved | Refused:
    """From jumps nearby that are solved by now, as alike ones give better guesses; else a draft."""
    robot = refiner.robot
    plan = refiner.learned(make_task(jump, robot), Watch())
    plan = plan and certified(plan, robot)
    if plan is None or not plan.certified:
        try:
            draft = planner_of(jump).plan(jump, patient=False, explains=False)
        except NotConverged as error:
            return Refused(jump, worst_of(error.plan.violations) or NOT_PLANNED)
        plan = certified(refiner.refine(draft, learned=False), robot)
    if not plan.certified:
        return Refused(jump, _broken(plan))
    load, solution = planned_peak_load(plan), refiner.solution
    assert load is not None
    assert solution is not None
    return Solved(jump, solution, plan.airborne, load.ratio)


def _broken(plan: Plan) -> str:
    """The first check of a plan that does not hold."""
    certificate = stated(plan)
    broken = () if certificate is None else certificate.broken
    return broken[0].name if broken else NOT_PLANNED
