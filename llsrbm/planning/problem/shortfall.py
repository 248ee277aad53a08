"""How much of a request is done: numbers of the rows in which less of it may be.

From the first knot at which a foot swings, shares of the robot's ranges by which the request is
given up are states with zero dynamics, chosen as controls in the interval before. Less is done,
never more. Where the feet land, where the motion ends and what feet clear follow from them
(`stage_places`). A task says what a whole range that is given up costs: the cost is their sum, so
that nothing is given up that can be done, and of several components as few as will do. Where it
says nothing, the shares change nothing: then all of the request is done.
"""

import math

import numpy as np

from llsrbm.arrays import Array
from llsrbm.planning.problem.foot_clearance import FAR, edge_ranges, ground_share
from llsrbm.planning.problem.layout import Layout
from llsrbm.planning.problem.stones import offsets
from llsrbm.planning.problem.task import Task
from llsrbm.request.jump import COMPONENTS, Jump


def distance(task: Task, jump: Jump) -> float:
    """Distance of a jump from a task's request: components as shares of the robot's ranges."""
    requested, own = task.requested or task.jump, task.robot.file.task
    shares = (
        (getattr(requested, name) - getattr(jump, name)) / ((high - low) or 1.0)
        for name, (low, high) in ((name, getattr(own, name)) for name in COMPONENTS)
    )
    return math.hypot(*shares)


def shortfall_sizes(layout: Layout) -> dict[str, int]:
    """Name -> number of scalars of the parameters that say what may be given up."""
    n = len(COMPONENTS)
    each = n * layout.displacements
    sizes = {"asked": n, "reference": n, "scale": n, "penalty": 1, "fixed": each, "follows": each}
    return sizes | {"stones": 3 * layout.legs}


def shortfall_parameters(layout: Layout, task: Task) -> dict[str, Array]:
    """Name -> value of the parameters that say what may be given up.

    `asked`: the request's components. `reference`: those of the jump that the task's other numbers
    are of. `scale`: what a component changes by when a whole range is given up, 0 where it may not
    be. `penalty`: of that. `fixed`, `follows`: of each displacement what the jump type says, and 1
    where the request does. `stones`: how far each foot lands beside its default in the last place.
    """
    own = task.robot.file.task
    jump = task.requested or task.jump if task.penalty else task.jump
    whole = np.array([getattr(jump, name) for name in COMPONENTS])
    ranges = np.array([high - low for low, high in (getattr(own, name) for name in COMPONENTS)])
    rows = task.displacement or (None,) * layout.displacements
    given = [[getattr(row, name, None) for name in COMPONENTS] for row in rows]
    return {
        "asked": whole,
        "reference": np.array([getattr(task.jump, name) for name in COMPONENTS]),
        "scale": np.sign(whole) * np.where(ranges > 0, ranges, 1.0) * bool(task.penalty),
        "penalty": np.array([task.penalty]),
        "fixed": np.array([[value or 0.0 for value in row] for row in given]),
        "follows": np.array([[float(value is None) for value in row] for row in given]),
        "stones": offsets(task.jump.stones, task.robot),
    }


def swing_numbers(layout: Layout, task: Task) -> Array:
    """(N, 3 L) of each interval: how what feet clear moves with what is given up.

    Of each leg the share of the landing surface's rise that its foot clears, and whether an edge
    bounds it from above, before the foot is up, and from below, on its way down.
    """
    share = np.zeros((layout.total, layout.legs))
    progress = layout.swing_progress[0][:-1]
    for phase in range(layout.phases):
        here = layout.phase[:-1] == phase
        start, goal = (
            task.footholds_before(phase).feet[:, 2],
            task.footholds_after(phase).feet[:, 2],
        )
        share[here] = ground_share(start, goal, task.swing_share(phase, progress[here]))
    low, high = edge_ranges(task, layout)
    numbers = [np.nan_to_num(share), high[:-1] < FAR, low[:-1] > -FAR]
    return np.concatenate(numbers, axis=1).astype(float)
