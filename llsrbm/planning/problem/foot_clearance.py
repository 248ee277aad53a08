"""Between lift-off and touchdown feet clear a line above the ground, and edges."""

from functools import lru_cache

import numpy as np

from llsrbm.arrays import Array
from llsrbm.planning.problem.layout import Layout
from llsrbm.planning.problem.task import Task

# How far feet below the landing surface may come nearer to it than they stood at the start, m, in
# any case: they are there at lift-off.
ROOM = 0.005
# Its edge is in the middle between start and target (`llsrbm.motion.surroundings`). They may come
# so near to that, m: a ball's radius and as much again, and as much of a sole's corners.
APART = 0.035
FAR = 10.0  # m, no bound; finite, see `Constraint.bounds`
# Feet of a body that turns over come down from this height, m, over this share of their swing: they
# sweep over the ground, and one that meets it early stops the turn.
HIGH, COMING_DOWN = 0.05, 0.06
# How far feet are above the upper surface before they may be over the edge, m.
ABOVE = 0.02


def ground_line(start: Array, goal: Array, progress: Array) -> Array:
    """m: height that a foot must clear at a share of its swing.

    Args:
        start, goal: m, heights of where it stood and will stand.
        progress: share of the swing; all of shapes that broadcast to one.
    """
    return start + (goal - start) * ground_share(start, goal, progress)


def ground_share(start: Array, goal: Array, progress: Array) -> Array:
    """Share of the way from the start's height to the goal's, of `ground_line`.

    A landing surface above the start is cleared as high as it is from half way on, one below it is
    not sunk to before, so that no foot meets the edge of what it lands on or leaves.
    """
    s, up = np.asarray(progress), goal > start
    u = np.minimum(1.0, np.where(up, 2 * s, 2 * (1 - s)))
    step = u**2 * (3 - 2 * u)
    return np.where(up, step, 1 - step)


def clearance_line(task: Task, phase: int, progress: Array) -> Array:
    """(K, L) m: the ground line and an arch of the robot file's clearance above it.

    The arch begins and ends level, because feet leave the ground and meet it at rest. Feet that are
    under way below it come back to it until they land.

    Args:
        task: where feet stand, and the clearance.
        phase: of the schedule; progress: (K, L) share of each foot's swing, of what is left of it
            where that is under way.
    """
    start, goal = task.footholds_before(phase).feet[:, 2], task.footholds_after(phase).feet[:, 2]

    def line(s: Array) -> Array:
        arch = (4 * s * (1 - s)) ** 2 * task.limits.clearance
        if task.jump.turns:
            left = np.clip((1 - s) / COMING_DOWN, 0.0, 1.0)
            arch = np.where(s > 0.5, np.maximum(arch, HIGH * left**2 * (3 - 2 * left)), arch)
        return ground_line(start, goal, s) + arch

    height = line(task.swing_share(phase, progress))
    if task.motion is not None and phase == 0:
        below = np.maximum(line(task.motion.begun) - task.motion.heights, 0.0)
        height = height - below * (1 - progress)
    return height


@lru_cache(maxsize=2)
def edge_ranges(task: Task, layout: Layout) -> tuple[Array, Array]:
    """(N + 1, L) m each: `edge_range` of all knots."""
    progress, step = layout.swing_progress
    low, high = np.full((2, *progress.shape), np.nan)
    for phase in range(layout.phases):
        here = layout.phase == phase
        low[here], high[here] = edge_range(task, phase, progress[here], step[here])
    return low, high


def edge_range(task: Task, phase: int, progress: Array, step: Array) -> tuple[Array, Array]:
    """(K, L) m each: bounds of corners along `towards`; far where there is no edge to mind.

    Args:
        task: where feet stand.
        phase: of the schedule.
        progress, step: (K, L) share of each foot's swing, and the share an interval takes.
    """
    legs = range(len(task.schedule.legs))
    towards = task.towards(phase)
    stood, lands = task.footholds_before(phase), task.footholds_after(phase)
    start, goal = (
        np.einsum("lcj,lj->lc", place.contacts[:, :2].reshape(len(legs), -1, 2), towards)
        for place in (stood, lands)
    )
    edges = [task.edges(phase, i) for i in legs]
    gap = np.array([edge.gap[i] for i, edge in zip(legs, edges, strict=True)])
    rise = np.array([edge.rise for edge in edges])
    room = np.maximum(ROOM, gap / 2 - APART)
    surface = np.maximum(stood.feet[:, 2].max(), lands.feet[:, 2].max()) + ABOVE
    edge = towards.any(axis=1) & (rise != 0)
    up = edge & (rise > 0)
    share = task.swing_share(phase, progress)
    rising = clearance_line(task, phase, progress - step) < surface
    rising = rising & (share < 0.5 + step) & up
    sinking = clearance_line(task, phase, progress + step) < surface
    sinking = sinking & (share > 0.5 - step) & (edge & ~up)
    return (
        np.where(sinking, goal.min(axis=1) - room, -FAR),
        np.where(rising, start.max(axis=1) + room, FAR),
    )
