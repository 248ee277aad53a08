"""Pictures of made-up plans and simulations, made once."""

from dataclasses import replace
from functools import lru_cache

import numpy as np

from app.motion.baked import bake_plan, bake_rollout
from app.picture.overlays import AT_FIRST
from app.picture.picture import Picture
from llsrbm.motion.surroundings import surroundings
from llsrbm.request.jump import Jump
from llsrbm.request.scenario import Scenario
from llsrbm.robots import load_robot
from tests.app.synthetic_plan import synthetic_plan
from tests.llsrbm.synthetic_rollout import synthetic_rollout


def planned(robot="anymal", twist=0.7, forward=0.2, height=0.0):
    """A plan that pushes harder to one side, so that nothing is in the middle by chance."""
    return _planned(robot, twist, forward, height)


@lru_cache(maxsize=8)
def _planned(robot, twist, forward, height):
    jump = Jump(robot=robot, model="llsrbm-plus", twist=twist, forward=forward, height=height)
    plan = synthetic_plan(jump)
    force = plan.contact_force.copy()
    force *= np.linspace(0.5, 1.5, force.shape[1])[:, None]
    force[..., 0] += 0.2 * force[..., 2]
    return bake_plan(replace(plan, contact_force=force), load_robot(robot))


@lru_cache(maxsize=4)
def simulated(robot="anymal"):
    return bake_rollout(synthetic_rollout(planned(robot).plan)).frames


def picture(robot="anymal", layers=AT_FIRST, *, simulation=False, **asked):
    """Of a plan, or of its simulation."""
    motion = planned(robot, **asked)
    around = surroundings(load_robot(robot), motion.plan, Scenario())
    return Picture(
        robot=load_robot(robot),
        planned=motion,
        simulated=simulated(robot) if simulation else None,
        blocks=around.blocks,
        layers=frozenset(layers),
        target=motion.plan.jump,
    )
