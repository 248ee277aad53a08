"""Centroidal models, found by name; adding one is one file and one line here."""

from __future__ import annotations

from llsrbm.models.base import CentroidalModel
from llsrbm.models.llsrbm import LLSRBM, SRBM
from llsrbm.models.llsrbm_plus import LLSRBMPlus
from llsrbm.request.messages import look_up
from llsrbm.robots.robot import Robot

MODELS: dict[str, type[CentroidalModel]] = {
    model.name: model for model in (SRBM, LLSRBM, LLSRBMPlus)
}


def names() -> tuple[str, ...]:
    """The models' names."""
    return tuple(MODELS)


def check_name(name: str) -> None:
    """Raise `InputError`, naming the valid ones, for a name that is no model's."""
    look_up("model", name, MODELS)


def make_model(name: str, robot: Robot) -> CentroidalModel:
    """The model called `name`, of `robot`. Raises `InputError`: no model has that name."""
    return look_up("model", name, MODELS)(robot)  # type: ignore[call-arg]  # a robot is enough
