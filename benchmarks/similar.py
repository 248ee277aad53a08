"""Another robot's flips, by dynamic similarity: its table, and its motion as a guess.

Lengths go with the legs' length, times with its root, forces with the weight.
"""

import math

import numpy as np
from numpy.typing import NDArray

from llsrbm.mechanics import GRAVITY
from llsrbm.planning.problem.knots import Sampled, pack
from llsrbm.planning.problem.task import Task
from llsrbm.planning.solve.formulation import Attempt, Formulation
from llsrbm.planning.solve.guess import LANDING_LOAD, arms_still
from llsrbm.robots.robot import Robot
from llsrbm.robots.schema import Reach, Timing, Turning

Array = NDArray[np.float64]

ROOM = 1e-3  # s that durations keep from their limits


def standing_feet(robot: Robot) -> Array:
    """(L, 3) m: feet of the default posture in their mirrored hip frames."""
    seen: Array = (robot.feet - (robot.base_position + robot.hips)) * robot.mirrors
    return seen


def like_go2(robot: Robot) -> Turning:
    """[turning] of Go2, in proportion to a robot's legs: shares of 0.426 m."""
    length = robot.file.reach.distance[1] / 0.915
    side = float(standing_feet(robot)[:, 1].mean())
    reach = Reach(
        distance=(0.305 * length, 0.935 * length),
        lower=(-0.70 * length, side - 0.14 * length, -0.935 * length),
        upper=(0.70 * length, side + 0.235 * length, -0.235 * length),
        standing=0.5,
        about_standing=0.3,
    )
    timing = Timing(takeoff=(0.3, 0.8), flight=(0.3, 0.7), landing=(0.4, 1.0))
    return Turning(axes=("pitch",), reach=reach, timing=timing)


def similar(of: Attempt, form: Formulation, task: Task) -> Array:
    """All variables of a task, from the motion of a robot with as many legs and the same feet in
    the same phases.
    """
    knots, layout, one, other = of.knots, form.layout, of.task.robot, form.robot
    size = other.file.reach.distance[1] / one.file.reach.distance[1]
    ends = np.array([task.times(phase) for phase in range(len(knots.durations))])
    low, high = ends.T
    times = np.clip(math.sqrt(size) * knots.durations, low + ROOM, high - ROOM)
    slower = (times / knots.durations)[np.minimum(knots.phase, len(times) - 1), None]
    outward = [standing_feet(robot).mean(axis=0) * [0.0, 1.0, 0.0] for robot in (one, other)]
    ahead = np.ones_like(one.mirrors)
    ahead[:, 0] = one.mirrors[:, 0] * other.mirrors[:, 0]
    feet = (knots.feet_in_hip - outward[0]) * ahead * size + outward[1]
    feet = np.clip(feet, task.reach.lower, task.reach.upper)
    length = np.linalg.norm(feet, axis=-1, keepdims=True)
    feet = feet * np.clip(length, *task.reach.distance) / length
    rate = np.zeros_like(feet)
    for leg, lift, touch in layout.swings:
        dt = [times[layout.phase[k]] / layout.roles[k].intervals for k in range(lift, touch)]
        rate[lift + 1 : touch + 1, leg] = (
            np.diff(feet[lift : touch + 1, leg], axis=0) / np.array(dt)[:, None]
        )
        rate[lift, leg] = rate[lift + 1, leg]
    turning = np.vstack([knots.rotation_rate, knots.rotation_rate[-1:]])
    load = knots.force * layout.contacts / (of.task.mass * GRAVITY)
    return pack(
        layout,
        Sampled(
            durations=times,
            position=task.start_position + size * (knots.position - of.task.start_position),
            velocity=knots.velocity * size / slower,
            quat=knots.quat,
            momentum=knots.momentum / of.task.mass * size**2 / slower,
            rotation_rate=turning / slower,
            feet=feet,
            feet_velocity=rate,
            **arms_still(task, layout),
            force=load.reshape(layout.knots, layout.legs, -1, 3),
            landing_force=np.tile([0.0, 0.0, LANDING_LOAD], (layout.legs, 1, 1)),
            shift=np.zeros(2),
        ),
    )
