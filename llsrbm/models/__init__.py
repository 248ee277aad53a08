"""Centroidal models, found by name; adding one is one file and one line here."""

from typing import Any

from llsrbm.models.base import CentroidalModel
from llsrbm.models.llsrbm import LLSRBM, SRBM
from llsrbm.models.llsrbm_plus import LLSRBMPlus
from llsrbm.request.jump import FREE, Jump
from llsrbm.request.messages import look_up
from llsrbm.robots.robot import Robot

MODELS: dict[str, type[CentroidalModel]] = {
    model.name: model for model in (SRBM, LLSRBM, LLSRBMPlus)
}
"""By name."""


def make_model(name: str, robot: Robot, *, free_arms: bool = False) -> CentroidalModel:
    """The model called `name`, of `robot`. Raises `InputError`: no model has that name.

    `free_arms`: arms that move, see `free_arms_of`.
    """
    kind: Any = look_up("model", name, MODELS)  # a robot is enough, its arms if they move
    return kind(robot, free_arms=True) if free_arms else kind(robot)


def free_arms_of(jump: Jump, robot: Robot) -> bool:
    """Whether the arms move in a jump's plans: where it asks for that, and the model can."""
    return (
        bool(robot.arms) and jump.arms == FREE and look_up("model", jump.model, MODELS).moves_arms
    )
