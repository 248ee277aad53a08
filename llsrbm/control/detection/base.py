"""Contact detectors: the centroidal motion that they see, and their interface."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from functools import cached_property
from math import sqrt
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from llsrbm.control.whole_body import solved
from llsrbm.robots.schema import RobotFile

Array = NDArray[np.float64]

# Detectors listen once the CoM has sunk faster than this: before, feet that leave the ground late
# look like contacts, and no landing is softer (it is the speed of a fall of 5 mm).
ARMED_BELOW = -0.3  # m/s
_IDENTITY = np.eye(3)


STATED = 2.0
"""Standard deviations of what a robot file states: a value that is exceeded 1 time in 20."""


@dataclass(frozen=True)
class ModelUncertainty:
    """Standard deviations of the controller's numbers."""

    trunk_mass: float  # of the trunk's mass, as a share of it


def model_uncertainty(file: RobotFile) -> ModelUncertainty:
    """Standard deviations of a robot file's [uncertainty]."""
    return ModelUncertainty(trunk_mass=file.uncertainty.trunk_mass / STATED)


@dataclass(frozen=True, eq=False)
class CentroidalState:
    """The measured motion of the whole robot in one control tick; world frame."""

    mass: float  # kg
    com_velocity: Array  # (3,) m/s
    angular_momentum: Array  # (3,) kg m2/s about the CoM
    inertia: Array  # (3, 3) kg m2 of the whole robot about its CoM
    # (6,) kg m/s, kg m2/s: linear and angular, about the CoM, of the trunk in its motion relative
    # to the CoM. A trunk heavier by a share e than believed has e times this more of both
    # (`WholeBody.trunk_momentum`).
    trunk_momentum: Array = field(default_factory=lambda: np.zeros(6))

    @cached_property
    def average_angular_velocity(self) -> Array:
        """(3,) rad/s: I^-1 L."""
        return solved(self.inertia, self.angular_momentum)

    @cached_property
    def inverse_inertia(self) -> Array:
        """(3, 3) 1/(kg m2): I^-1."""
        return solved(self.inertia, _IDENTITY)

    @property
    def average_spatial_velocity_norm(self) -> float:
        """‖v_G‖, m/s and rad/s in one norm, as in the paper."""
        w, v = self.average_angular_velocity, self.com_velocity
        return sqrt(w.dot(w) + v.dot(v))


class Detector(ABC):
    """Detects contact in flight from the centroidal motion.

    Attributes:
        signal: its last value, for plots: a contact is reported when it is above the threshold,
            0 while the detector does not listen.
        tick: s between updates.
        uncertainty: of the model behind the states; a detector may make nothing of it.
    """

    name: ClassVar[str]
    summary: ClassVar[str]
    threshold: float  # what `signal` is compared with; constant
    signal: float

    def __init__(self, tick: float, uncertainty: ModelUncertainty) -> None:
        """Begin with `reset`.

        Args:
            tick: s between updates.
            uncertainty: of the model behind the states.
        """
        self.tick = tick
        self.uncertainty = uncertainty
        self.reset()

    def reset(self) -> None:
        """Forget the past: the next state is the first of a flight."""
        self.signal = 0.0
        self._has_fallen = False

    @abstractmethod
    def update(self, state: CentroidalState) -> bool:
        """Take in the state of one control tick of the flight; True: there is contact."""

    def _falling(self, state: CentroidalState) -> bool:
        """True if it is time to listen, from now on: a contact slows the fall before it is seen."""
        self._has_fallen |= float(state.com_velocity[2]) < ARMED_BELOW
        return self._has_fallen
