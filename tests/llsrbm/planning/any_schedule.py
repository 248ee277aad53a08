"""Tasks of any schedule, placed in the world by hand: the same displacement with every flight."""

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from llsrbm.planning.problem.placement import make_task
from llsrbm.planning.problem.task import Footholds, Task, contact_points
from llsrbm.request.jump import Jump
from llsrbm.request.schedule import Schedule
from llsrbm.robots.robot import Robot


def task_of(schedule: Schedule, robot: Robot, shift=(0.1, 0.0, 0.0), twist: float = 0.0) -> Task:
    """Each landing `shift` m (world axes) and `twist` rad after the place before."""
    plain = make_task(Jump(robot=robot.name), robot)
    first = plain.places[0]
    turning = robot.foot_coordinates > 3
    places = []
    for place in range(schedule.places + 1):
        heading, origin = place * twist, place * np.asarray(shift, dtype=float)
        feet = Rotation.from_euler("z", heading).apply(robot.feet) + origin
        yaw = first.yaw + heading * turning
        contacts = contact_points(feet, yaw, np.array(robot.corners))
        places.append(Footholds(feet, yaw, contacts, np.zeros((len(feet), 2)), heading, origin))
    turn = Rotation.from_euler("z", places[-1].heading)
    half = places[-1].heading / 2
    return replace(
        plain,
        schedule=schedule,
        places=tuple(places),
        goal_position=turn.apply(robot.com) + places[-1].origin,
        goal_quat=np.array([np.cos(half), 0.0, 0.0, np.sin(half)]),
    )
