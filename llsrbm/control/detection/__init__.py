"""Contact detectors, found by name; adding one is one file and one line here."""

from __future__ import annotations

from llsrbm.control.detection.base import (
    CentroidalState,
    Detector,
    ModelUncertainty,
    model_uncertainty,
)
from llsrbm.control.detection.norm import NormDetector
from llsrbm.control.detection.residual import ResidualDetector
from llsrbm.request.messages import look_up

__all__ = [
    "CentroidalState",
    "Detector",
    "ModelUncertainty",
    "check_name",
    "make_detector",
    "model_uncertainty",
    "names",
]

_DETECTORS: dict[str, type[Detector]] = {
    detector.name: detector for detector in (ResidualDetector, NormDetector)
}


def names() -> tuple[str, ...]:
    """The detectors' names, the default first."""
    return tuple(_DETECTORS)


def check_name(name: str) -> None:
    """Raise `InputError`, naming the valid ones, for a name that is no detector's."""
    look_up("detector", name, _DETECTORS)


def make_detector(name: str, tick: float, uncertainty: ModelUncertainty) -> Detector:
    """The detector called `name`.

    Args:
        tick: s between its updates.
        uncertainty: of the model that the centroidal states are computed with.

    Raises:
        InputError: no detector has that name.
    """
    return look_up("detector", name, _DETECTORS)(tick, uncertainty)
