"""Centroidal models, found by name; adding one is one file and one line here."""

from __future__ import annotations

from llsrbm.errors import InputError
from llsrbm.models.base import CentroidalModel
from llsrbm.models.llsrbm import LLSRBM
from llsrbm.models.llsrbm_plus import LLSRBMPlus
from llsrbm.models.srbm import SRBM
from llsrbm.robots.robot import Robot

_MODELS: dict[str, type[CentroidalModel]] = {
    model.name: model for model in (SRBM, LLSRBM, LLSRBMPlus)
}


def names() -> tuple[str, ...]:
    """The models' names."""
    return tuple(_MODELS)


def describe() -> dict[str, str]:
    """Name -> one line."""
    return {name: model.summary for name, model in _MODELS.items()}


def check_name(name: str) -> None:
    """Raise `InputError`, naming the valid ones, for a name that is no model's."""
    if name not in _MODELS:
        raise InputError(f"unknown model {name!r}; the models are {', '.join(_MODELS)}")


def make_model(name: str, robot: Robot) -> CentroidalModel:
    """The model called `name`, of `robot`.

    Raises:
        InputError: no model has that name.
    """
    check_name(name)
    return _MODELS[name](robot)  # type: ignore[call-arg]  # every model is made from a robot alone
