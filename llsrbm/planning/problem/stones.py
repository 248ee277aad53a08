"""Landing places of single feet, as the stones of a request move them: in numbers, and checked."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from llsrbm.arrays import Array
from llsrbm.errors import InputError
from llsrbm.mechanics import rotation_matrices
from llsrbm.planning.problem.task import Task
from llsrbm.request.jump import Jump
from llsrbm.request.messages import choices
from llsrbm.request.slopes import leaning
from llsrbm.request.stones import FARTHEST, Stone
from llsrbm.robots.robot import Robot
from llsrbm.robots.schema import Reach

_HALVINGS = 12  # of the way to where a foot shall land: to less than a millimetre of a metre
# Shares of the plane nearest to the feet that a body follows; the legs do the rest. Of pairs and
# single feet 6 to 24 cm up, and of four feet at random within 10 cm, the legs of six quadrupeds
# reach most by these: a body that leans all the way has its legs aslant below it.
RISE = 0.65
LEAN = 0.4
_SLACK = 1e-6  # m, of a robot's own posture that lies on a bound


def offsets(stones: Sequence[Stone], robot: Robot) -> Array:
    """(L, 3) m: how far each foot lands beside its default, axes of the robot that lands. Raises
    `InputError`: a stone of a leg that the robot does not have.
    """
    aside = np.zeros((len(robot.legs), 3))
    names = robot.leg_names
    for leg, *place in stones:
        if leg not in names:
            raise InputError(f'stones: {robot.name} has no leg "{leg}"; {choices(leg, names)}')
        aside[names.index(leg)] = place
    return aside


def body_over(stones: Sequence[Stone], robot: Robot) -> tuple[Array, Array]:
    """How a body stands over feet that are moved.

    On points it follows their heights, part of the way to the plane nearest them. On soles it
    stands upright at its own height above their middle, or it would topple over.

    Returns:
        (3,) m by which it is elsewhere, and (2,) the gradient of what it is level to, ahead and to
        the left, axes of the robot that lands. Raises `InputError`: see `offsets`.
    """
    aside = offsets(stones, robot)
    if not robot.file.foot.is_point:
        return aside.mean(axis=0) * [1.0, 1.0, 0.0], np.zeros(2)
    if not aside[:, 2].any():
        return np.zeros(3), np.zeros(2)
    places = np.column_stack([np.ones(len(aside)), (robot.feet + aside)[:, :2]])
    rise, *tilt = np.linalg.lstsq(places, aside[:, 2])[0]
    return np.array([0.0, 0.0, RISE * float(rise)]), LEAN * np.array(tilt)


def check_stones(task: Task) -> None:
    """Check that legs reach where their feet shall land, with the robot as it stands in the end.
    Raises `InputError`: one does not, or two feet would be too near each other.
    """
    why = _why_not(task.jump.stones, task.robot, task.reach, task.limits.feet_apart)
    if why:
        raise InputError(f"stones: {why}")


def within_reach(jump: Jump, stone: Stone, robot: Robot) -> Jump:
    """The jump with that foot's landing place, or as far on the way there as the leg reaches.

    Whole millimetres. The other feet's stones stay.
    """
    others = [each for each in jump.stones if each.leg != stone.leg]
    whole = min(1.0, FARTHEST / max(*map(abs, stone[1:]), FARTHEST))

    def at(share: float) -> Jump:
        place = [round(share * whole * each, 3) for each in stone[1:]]
        return replace(jump, stones=(*others, Stone(stone.leg, *place)))

    def stands(one: Jump) -> bool:
        file = robot.file
        return not _why_not(one.stones, robot, file.reach, file.limits.feet_apart)

    if stands(at(1.0)) or not stands(at(0.0)):
        return at(1.0)
    low, high = 0.0, 1.0
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if stands(at(middle)) else (low, middle)
    return at(low)


def _why_not(stones: Sequence[Stone], robot: Robot, reach: Reach, apart: float) -> str:
    """Why feet cannot stand there, in words; "": they can."""
    aside = offsets(stones, robot)
    lift = np.array([0.0, 0.0, robot.foot_lift])
    usual = robot.mirrors * (robot.feet + lift - robot.base_position - robot.hips)
    shift, tilt = body_over(stones, robot)
    from_com = robot.feet + lift + aside - robot.com - shift
    seen = from_com @ rotation_matrices(leaning(tilt))  # from world to base
    lands = robot.mirrors * (seen + robot.com - robot.base_position - robot.hips)
    # A robot's own posture may be out of what its file has legs reach.
    low, high = np.minimum(usual, reach.lower) - _SLACK, np.maximum(usual, reach.upper) + _SLACK
    lengths = np.linalg.norm(usual, axis=1)
    shortest = np.minimum(lengths, reach.distance[0]) - _SLACK
    longest = np.maximum(lengths, reach.distance[1]) + _SLACK
    for leg in np.flatnonzero(aside.any(axis=1) | tilt.any()):
        length = float(np.linalg.norm(lands[leg]))
        inside = (low[leg] <= lands[leg]).all() and (lands[leg] <= high[leg]).all()
        if not inside or not shortest[leg] <= length <= longest[leg]:
            x, y, z = lands[leg]
            ends = [f"{a:g} to {b:g}" for a, b in zip(reach.lower, reach.upper, strict=True)]
            return (
                f"{robot.leg_names[leg]} would stand {length:.3f} m from its hip, ({x:.3f}, "
                f"{y:.3f}, {z:.3f}) m in its leg's frame; expected {reach.distance[0]:g} to "
                f"{reach.distance[1]:g} m, and ({', '.join(ends)}) m, as far as legs of "
                f"{robot.name} reach"
            )
    feet = robot.feet[:, :2] + aside[:, :2]
    for i, j in combinations(range(len(feet)), 2):
        between = float(np.linalg.norm(feet[i] - feet[j]))
        usually = float(np.linalg.norm(robot.feet[i, :2] - robot.feet[j, :2]))
        if aside[[i, j]].any() and between < min(apart, usually) - _SLACK:
            return (
                f"{robot.leg_names[i]} and {robot.leg_names[j]} would stand {between:.3f} m apart; "
                f"expected at least {apart:g} m"
            )
    return ""
