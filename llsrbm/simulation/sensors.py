"""Sensors and state estimation: from the true state to the one `Measurement` a controller reads.

Two layers. White noise on the measured velocities belongs to the disturbance that a seed draws. The
estimator is chosen by the scenario, by name: `truth`, or `drift`, which errs as estimators of
legged robots do that have an inertial unit, joint encoders and feet, and no camera.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections import deque
from typing import ClassVar

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from llsrbm.control.delay import Measurement
from llsrbm.motion.rollout import Disturbance
from llsrbm.request.messages import look_up
from llsrbm.request.scenario import Scenario
from llsrbm.robots import Robot
from llsrbm.simulation.world import TickResult

Array = NDArray[np.float64]

# What `drift` errs by. Published closed loops of quadrupeds that walk end off by 0.1 to 2 % of the
# way (a Go2: 2.2 m in 120 m, arXiv:2602.17393); a jump is harder on feet and inertial unit.
VELOCITY_ERROR = 0.03  # m/s an axis: a foot that slips or rolls while it is taken to stand still
POSITION_DRIFT = 0.01  # m/s^0.5 horizontally while feet touch: 2 % of the way of a jump of 0.5 m
TILT_ERROR = math.radians(0.5)  # roll and pitch, which gravity keeps bounded
TILT_TIME = 0.5  # s over which a tilt's error changes, a filter's time constant
YAW_DRIFT = math.radians(0.3)  # rad/s^0.5; nothing bounds it. A gyro's scale error adds as much
DELAY = 0.0025  # s; one period of an estimator that runs at 400 Hz


class Estimator(ABC):
    """Turns true states into estimates, tick by tick."""

    name: ClassVar[str]  # under which it is found
    summary: ClassVar[str]  # one line
    delay: ClassVar[float] = 0.0  # s by which a whole measurement comes late

    def __init__(self, tick: float, seed: int) -> None:
        """Begin where the robot stands; `tick`: s between estimates, `seed` draws errors."""
        del tick, seed

    @abstractmethod
    def estimate(self, q: Array, v: Array, *, touching: bool) -> tuple[Array, Array]:
        """The estimate of true q (nq,) and measured v (nv,), Pinocchio's, as a tick begins.

        `touching`: whether a foot touched anything in the tick that ended.
        """


class Truth(Estimator):
    """Knows where the robot is."""

    name, summary = "truth", "the true position and attitude"

    def estimate(self, q: Array, v: Array, *, touching: bool) -> tuple[Array, Array]:
        del touching
        return q, v


class Drift(Estimator):
    """Errs as an estimator from inertial unit, encoders and feet does.

    The velocity's error wanders while feet touch and correct it, and stays as it is in flight. The
    position's error is its sum: it drifts horizontally and without bound, in height in flight
    alone, after which the feet know the ground in the same drifted world. Roll and pitch err within
    bounds, yaw drifts. Joint positions are exact, and the angular velocity has the disturbance's
    noise alone.
    """

    name = "drift"
    summary = "position and yaw drift, velocity and tilt err, as those of legged robots do"
    delay = DELAY

    def __init__(self, tick: float, seed: int) -> None:
        self._rng = np.random.default_rng([seed, 3])  # apart from disturbance, noise and pushes
        self._tick = tick
        # An error of the velocity that is forgotten after this time drifts as stated once summed.
        memory = (POSITION_DRIFT / VELOCITY_ERROR) ** 2 / 2
        self._velocity_keeps = math.exp(-tick / memory)
        self._tilt_keeps = math.exp(-tick / TILT_TIME)
        self._velocity = VELOCITY_ERROR * self._rng.standard_normal(3)
        self._tilt = TILT_ERROR * self._rng.standard_normal(2)
        self._yaw = 0.0  # the world is where it stood at first
        self._position = np.zeros(3)

    def estimate(self, q: Array, v: Array, *, touching: bool) -> tuple[Array, Array]:
        R_true = pin.Quaternion(q[3:7]).toRotationMatrix()
        R_tilt: Array = pin.exp3(np.array([*self._tilt, 0.0]))
        turned = pin.Quaternion(pin.utils.rotate("z", self._yaw) @ R_true @ R_tilt).coeffs()
        estimated_q, estimated_v = q.copy(), v.copy()
        estimated_q[:3] += self._position
        estimated_q[3:7] = turned if turned @ q[3:7] > 0 else -turned
        estimated_v[:3] += R_true.T @ self._velocity
        self._wander(touching=touching)
        return estimated_q, estimated_v

    def _wander(self, *, touching: bool) -> None:
        moved = self._tick * self._velocity
        if touching:
            moved[2] = 0.0
            self._velocity = _wandered(
                self._velocity, self._velocity_keeps, VELOCITY_ERROR, self._rng
            )
        self._position = self._position + moved
        self._tilt = _wandered(self._tilt, self._tilt_keeps, TILT_ERROR, self._rng)
        self._yaw += YAW_DRIFT * math.sqrt(self._tick) * self._rng.standard_normal()


def _wandered(error: Array, keeps: float, size: float, rng: np.random.Generator) -> Array:
    """An error a tick later: a stationary Gauss-Markov process of standard deviation `size`."""
    fresh: Array = rng.standard_normal(len(error))
    return keeps * error + math.sqrt(1 - keeps**2) * size * fresh


ESTIMATORS: dict[str, type[Estimator]] = {kind.name: kind for kind in (Truth, Drift)}


def check_estimator(name: str) -> None:
    """Raise `InputError`, naming the valid ones, for a name that is no estimator's."""
    look_up("estimator", name, ESTIMATORS)


class Sensors:
    """Makes each tick's `Measurement`, the same for the same seed."""

    def __init__(
        self, robot: Robot, disturbance: Disturbance, scenario: Scenario, tick: float
    ) -> None:
        """Of a scenario the seed and the estimator matter. Raises `InputError`: the estimator is
        unknown.
        """
        seed = scenario.seed or 0
        self._rng = np.random.default_rng([seed, 1])  # apart from what drew the disturbance
        self._scale = np.full(robot.model.nv, disturbance.joint_velocity_noise)
        self._scale[:6] = disturbance.base_velocity_noise
        check_estimator(scenario.estimator)
        self._estimator = ESTIMATORS[scenario.estimator](tick, seed)
        late = round(self._estimator.delay / tick)
        self._under_way: deque[tuple[Array, Array, Array]] = deque(maxlen=late + 1)

    def measure(
        self, time: float, state: tuple[Array, Array], last: TickResult | None
    ) -> Measurement:
        """The measurement `time` s after the start; earlier than its delay, the first state.

        `state`: true q (nq,) and v (nv,), Pinocchio's; `last`: of the tick that ended, None at
        first.
        """
        q, v = state
        v = v + self._scale * self._rng.standard_normal(len(v))
        touching = last is None or bool(last.contact.any())
        torque = np.zeros(len(v) - 6) if last is None else last.torque
        self._under_way.append((*self._estimator.estimate(q, v, touching=touching), torque))
        return Measurement(time, *self._under_way[0])
