"""By how much the controller's model may be wrong, from what the robot file states."""

from __future__ import annotations

from dataclasses import dataclass

from llsrbm.robots.schema import RobotFile

STATED = 2.0
"""Standard deviations of what a robot file states: a value that is exceeded 1 time in 20."""


@dataclass(frozen=True)
class ModelUncertainty:
    """Standard deviations of the controller's numbers.

    Attributes:
        trunk_mass: of the trunk's mass, as a share of it.
    """

    trunk_mass: float


def model_uncertainty(file: RobotFile) -> ModelUncertainty:
    """What a robot file's [uncertainty] comes to."""
    return ModelUncertainty(trunk_mass=file.uncertainty.trunk_mass / STATED)
