"""ANYmal in a world of its own, tick by tick."""

import numpy as np

from llsrbm.motion.rollout import Disturbance
from llsrbm.motion.surroundings import surroundings
from llsrbm.request.jump import Jump
from llsrbm.request.scenario import Scenario
from llsrbm.robots import load_robot
from llsrbm.robots.feet import foot_contacts
from llsrbm.simulation.world import World
from tests.app.synthetic_plan import synthetic_plan

TICK = 1 / 400
ANYMAL = load_robot("anymal")
GRAVITY = np.array([0.0, 0.0, -9.81])
JOINTS = len(ANYMAL.joint_names)
PLAN = synthetic_plan(Jump())


def world_of(plan=PLAN, scenario=None, delay=None, **disturbance):
    """`delay`: the drives', s; None: that of the robot's file."""
    around = surroundings(ANYMAL, plan, scenario or Scenario())
    return World(ANYMAL, around, Disturbance(**disturbance), TICK, delay)


def in_the_air(height=3.0):
    q = ANYMAL.posture.copy()
    q[2] += height
    return q, np.zeros(ANYMAL.model.nv)


def springs(world, goal, stiffness=300.0, damping=8.0):
    """Torques that hold a posture."""
    q, v = world.state()
    return stiffness * (goal[7:] - q[7:]) - damping * v[6:]


def lowest_points(robot, data):
    """(L, 3) m, of the feet's spheres."""
    return np.array(
        [
            data.oMf[leg.foot_frame_id].act(contact.centres[0]) - [0, 0, contact.radius]
            for leg, contact in zip(robot.legs, foot_contacts(robot), strict=True)
        ]
    )
