"""A planned motion and a simulation of it, with numbers that are known."""

import pytest

from app.motion.baked import bake_plan
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot
from tests.app.plots.lines import TWIST
from tests.app.synthetic_plan import synthetic_plan
from tests.llsrbm.synthetic_rollout import synthetic_rollout


@pytest.fixture(scope="module")
def robot():
    return load_robot("anymal")


@pytest.fixture(scope="module")
def planned(robot):
    return bake_plan(synthetic_plan(Jump(twist=TWIST)), robot)


@pytest.fixture(scope="module")
def rollout(planned):
    return synthetic_rollout(planned.plan)
