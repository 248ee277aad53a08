"""Contact detectors, found by name; adding one is a class and one line here."""

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from functools import cached_property
from math import sqrt
from typing import ClassVar

import numpy as np

from llsrbm.arrays import Array
from llsrbm.control.whole_body import solved
from llsrbm.mechanics import GRAVITY
from llsrbm.request.messages import look_up
from llsrbm.robots.schema import RobotFile

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
    """Detects contact in flight from the centroidal motion, every `tick`, s.

    `signal`: its last value, for plots: a contact is reported when it is above the threshold, 0
    while the detector does not listen. `uncertainty`: of the model behind the states.
    """

    name: ClassVar[str]
    threshold: float  # what `signal` is compared with; constant
    signal: float

    def __init__(self, tick: float, uncertainty: ModelUncertainty) -> None:
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


# Standard deviations. Six components of white noise exceed 8 in 1 of 1e11 tests; the worst of 450
# simulated flights with noise and a trunk mass wrong by 8 to 15 %, 10 % being stated, came to 6.0.
THRESHOLD = 8.0
LONGEST_WINDOW = 0.020  # s; contacts so soft that they need more reach the threshold soon after
BASELINE = 0.040  # s: twice that, so that its own noise matters little
# m/s and rad/s by which the means may be wrong with the right masses: what the time steps of the
# controller and of the world make of a smooth motion.
MODEL_ERROR = 0.002
# A squared second difference in 3 dimensions is 6 noise^2 times chi-squared with 3 degrees of
# freedom, whose median is 2.366.
_MEDIAN = 6 * 2.366


class ResidualDetector(Detector):
    """How far the centroidal motion has left what gravity makes of it, in standard deviations.

    In free fall v_com + g t and the angular momentum L are constant, so their means over the last k
    ticks and over a baseline just before differ by noise alone. A contact adds its impulse J to
    both,

        dv = J / m,    dw = I^-1 (r x J),

    in any direction, hence the norm of both; and an unknown number of ticks ago, hence every k up
    to a longest window (a generalised likelihood ratio test): a stiff contact shows in one tick, a
    soft one needs the mean of several. The signal is the largest of these differences in units of
    what is to be expected without contact,

        max_k |[dv_k / s_v; dw_k / s_w]|,    s^2 = noise^2 (1/k + 1/baseline) + model^2,

    with the noise of this flight, measured on the way up, and an allowance for a wrong model. The
    true masses' momenta are conserved in the air. Where the trunk is heavier than believed by
    a share e of its mass, the believed v_com and L lack e times the trunk's own momenta about the
    CoM, h and l: to first order in e,

        v_com + e h / m  and  L + e l   are conserved,

    so the legs' swing makes dv = -e dh / m and dw = -e I^-1 dl without any contact, the more the
    faster the trunk is moved against the CoM. With e known to a standard deviation only,

        model_v^2 = MODEL_ERROR^2 + std(e)^2 |dh / m|^2,
        model_w^2 = MODEL_ERROR^2 + std(e)^2 |I^-1 dl|^2

    in every direction alike, since a payload may sit anywhere on the trunk.
    """

    name = "residual"

    def __init__(self, tick: float, uncertainty: ModelUncertainty) -> None:
        self.threshold = THRESHOLD
        self._window = np.arange(1, max(1, round(LONGEST_WINDOW / tick)) + 1)
        self._baseline = max(2, round(BASELINE / tick))
        self._variance = (1 / self._window + 1 / self._baseline)[:, None]
        super().__init__(tick, uncertainty)

    def reset(self) -> None:
        super().reset()
        self._ticks = 0
        # v + g t, L, trunk's h / m and l; oldest first.
        self._recent = np.zeros((len(self._window) + self._baseline, 12))
        self._second_differences: list[tuple[float, float]] = []
        self._noise = np.zeros(2)

    def update(self, state: CentroidalState) -> bool:
        """See `Detector.update`; the signal is 0 until the detector listens."""
        recent = self._recent
        recent[:-1] = recent[1:]
        recent[-1, :3] = state.com_velocity
        recent[-1, 2] += GRAVITY * self.tick * self._ticks
        recent[-1, 3:6] = state.angular_momentum
        recent[-1, 6:9] = state.trunk_momentum[:3] / state.mass
        recent[-1, 9:] = state.trunk_momentum[3:]
        self._ticks += 1
        inverse = state.inverse_inertia
        listening = self._falling(state) and self._ticks >= len(recent)
        if not listening:
            self._measure_noise(inverse)
            return False
        if self._second_differences:
            self._noise = self._noise_so_far()
            self._second_differences.clear()
        self.signal = self._largest_difference(inverse)
        return self.signal > self.threshold

    def _measure_noise(self, inverse: Array) -> None:
        """Second differences hold noise alone: motions are smooth over three ticks."""
        if self._ticks >= 3:
            a, b, c = self._recent[-3:]
            d = c - 2 * b + a
            linear, angular = d[:3], inverse @ d[3:6]
            self._second_differences.append((linear @ linear, angular @ angular))

    def _noise_so_far(self) -> Array:
        """Standard deviation a component, m/s and rad/s.

        By the median, because feet that leave the ground late are no noise.
        """
        median = np.median(self._second_differences, axis=0)
        return np.sqrt(median / _MEDIAN)

    def _largest_difference(self, inverse: Array) -> float:
        k, before = self._window, self._baseline
        total = np.zeros((len(self._recent) + 1, 12))
        np.cumsum(self._recent, axis=0, out=total[1:])
        start = len(self._recent) - k
        late = (total[-1] - total[start]) / k[:, None]
        early = (total[start] - total[start - before]) / before
        difference = late - early
        # (windows, 4, 3) m/s, rad/s: dv, dw, and what a trunk of twice the mass adds to each.
        difference = difference.reshape(-1, 4, 3)
        difference[:, 1::2] = difference[:, 1::2] @ inverse
        squares = (difference * difference).sum(axis=2)
        model = MODEL_ERROR**2 + self.uncertainty.trunk_mass**2 * squares[:, 2:]
        variance = self._noise**2 * self._variance + model  # (windows, 2)
        return float(np.sqrt((squares[:, :2] / variance).sum(axis=1).max()))


# m/s2 and rad/s2 in one norm. Free fall raises ‖v_G‖ by 9.81 at most and lowers it on the way up;
# measured with noise of 0.01 it falls by up to 7 in each of two ticks without contact.
NORM_THRESHOLD = -8.0
NORM_WINDOW = 0.005  # s: two ticks at 400 Hz; impacts on hard ground are over in three


class NormDetector(Detector):
    """Contact when all numerical derivatives of ‖v_G‖ in a window are below a threshold.

    Blind to impacts in which the norm rises: a robot that lands with its CoM behind its feet
    pitches faster than it loses speed. It missed 54 of 300 simulated landings with noise.
    """

    name = "norm"

    def __init__(self, tick: float, uncertainty: ModelUncertainty) -> None:
        self.threshold = -NORM_THRESHOLD
        self._window = max(1, round(NORM_WINDOW / tick))
        super().__init__(tick, uncertainty)

    def reset(self) -> None:
        super().reset()
        self._norms: list[float] = []

    def update(self, state: CentroidalState) -> bool:
        """See `Detector.update`; the signal is minus the greatest derivative in the window."""
        self._norms.append(state.average_spatial_velocity_norm)
        del self._norms[: -self._window - 1]
        if not self._falling(state) or len(self._norms) <= self._window:
            return False
        self.signal = -float(np.diff(self._norms).max()) / self.tick
        return self.signal > self.threshold


DETECTORS: dict[str, type[Detector]] = {
    detector.name: detector for detector in (ResidualDetector, NormDetector)
}
"""By name, the default first."""


def make_detector(name: str, tick: float, uncertainty: ModelUncertainty) -> Detector:
    """The detector called `name`. `tick`: s between its updates; `uncertainty`: of the model that
    the centroidal states are computed with. Raises `InputError`: no detector has that name.
    """
    return look_up("detector", name, DETECTORS)(tick, uncertainty)
