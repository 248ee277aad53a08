"""Sensors and state estimation: from the true state to the one `Measurement` a controller reads.

Two layers. White noise on the measured velocities belongs to the disturbance that a seed draws. The
estimator is chosen by the scenario, by name: `truth`; `drift`, a model which errs as estimators of
legged robots do that have an inertial unit, joint encoders and feet, and no camera; or `imu`, such
an estimator, which reads simulated sensors with noise of their own.
"""

import math
from abc import ABC, abstractmethod
from collections import deque
from typing import ClassVar

import numpy as np
import pinocchio as pin

from llsrbm.arrays import Array, BoolArray
from llsrbm.control.delay import Measurement
from llsrbm.estimation.state_estimator import StateEstimator
from llsrbm.motion.rollout import Disturbance
from llsrbm.request.messages import look_up
from llsrbm.request.scenario import Scenario
from llsrbm.robots import Robot
from llsrbm.simulation.readings import Instruments
from llsrbm.simulation.world import TickResult

State = tuple[Array, Array]  # q (nq,) and v (nv,), Pinocchio's conventions

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
    noisy: ClassVar[bool] = True  # whether its velocities have the disturbance's noise

    def __init__(self, robot: Robot, tick: float, seed: int) -> None:
        """Begin where the robot stands; `tick`: s between estimates, `seed` draws errors."""
        del robot, tick, seed

    @abstractmethod
    def estimate(
        self, time: float, state: State, last: TickResult | None, standing: BoolArray
    ) -> tuple[Array, Array, Array]:
        """Estimated q, v and torques (J,) at `time`, s, as a tick begins.

        `state`: true q and measured v; `last`: of the tick that ended, None at first; `standing`:
        (L,) feet that the controller believes to stand.
        """


class Truth(Estimator):
    """Knows where the robot is."""

    name, summary = "truth", "the true position and attitude"

    def estimate(
        self, time: float, state: State, last: TickResult | None, standing: BoolArray
    ) -> tuple[Array, Array, Array]:
        return *state, _torque(state, last)


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

    def __init__(self, robot: Robot, tick: float, seed: int) -> None:
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

    def estimate(
        self, time: float, state: State, last: TickResult | None, standing: BoolArray
    ) -> tuple[Array, Array, Array]:
        q, v = state
        R_true = pin.Quaternion(q[3:7]).toRotationMatrix()
        R_tilt: Array = pin.exp3(np.array([*self._tilt, 0.0]))
        turned = pin.Quaternion(pin.utils.rotate("z", self._yaw) @ R_true @ R_tilt).coeffs()
        estimated_q, estimated_v = q.copy(), v.copy()
        estimated_q[:3] += self._position
        estimated_q[3:7] = turned if turned @ q[3:7] > 0 else -turned
        estimated_v[:3] += R_true.T @ self._velocity
        self._wander(touching=last is None or bool(last.contact.any()))
        return estimated_q, estimated_v, _torque(state, last)

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


def _torque(state: State, last: TickResult | None) -> Array:
    """(J,) as applied in the tick that ended."""
    return np.zeros(len(state[1]) - 6) if last is None else last.torque


STOOD = 0.5  # s at rest before the plan begins, in which biases become known: robots stand longer


class Imu(Estimator):
    """Estimates by the sensors that a robot has, see `llsrbm.estimation` and `Instruments`.

    The robot has stood for a while as the plan begins, or has moved before with biases known from
    standing.
    """

    name = "imu"
    summary = "estimated by inertial unit, joint encoders and feet, as on a robot"
    noisy = False

    def __init__(self, robot: Robot, tick: float, seed: int) -> None:
        self._robot, self._tick = robot, tick
        self._instruments = Instruments(robot, tick, seed)
        self._estimator: StateEstimator | None = None

    def estimate(
        self, time: float, state: State, last: TickResult | None, standing: BoolArray
    ) -> tuple[Array, Array, Array]:
        if self._estimator is None:
            self._estimator = self._stood(state, standing)
        readings = self._instruments.read(time, state, last)
        return *self._estimator.update(readings, standing), readings.torque

    def _stood(self, state: State, standing: BoolArray) -> StateEstimator:
        q, v = state
        estimator, at_rest = StateEstimator(self._robot, q), np.zeros_like(v)
        for k in range(-round(STOOD / self._tick), 0):
            readings = self._instruments.read(k * self._tick, (q, at_rest))
            estimator.update(readings, standing)
        if v.any():
            self._instruments.forget()
            estimator.restart()
        return estimator


ESTIMATORS: dict[str, type[Estimator]] = {kind.name: kind for kind in (Truth, Drift, Imu)}


class Sensors:
    """Makes each tick's `Measurement`, the same for the same seed."""

    def __init__(
        self, robot: Robot, disturbance: Disturbance, scenario: Scenario, tick: float
    ) -> None:
        """The scenario's seed and estimator matter. Raises `InputError`: the estimator is
        unknown.
        """
        seed = scenario.seed or 0
        self._rng = np.random.default_rng([seed, 1])  # apart from what drew the disturbance
        self._scale = np.full(robot.model.nv, disturbance.joint_velocity_noise)
        self._scale[:6] = disturbance.base_velocity_noise
        kind = look_up("estimator", scenario.estimator, ESTIMATORS)
        self._estimator = kind(robot, tick, seed)
        late = round(self._estimator.delay / tick)
        self._under_way: deque[tuple[Array, Array, Array]] = deque(maxlen=late + 1)

    def measure(
        self, time: float, state: State, last: TickResult | None, standing: BoolArray
    ) -> Measurement:
        """The measurement `time` s after the start; earlier than its delay, the first state.

        `state`: true; `last`: of the tick that ended, None at first; `standing`: (L,) feet that the
        controller believes to stand.
        """
        if self._estimator.noisy:
            q, v = state
            state = q, v + self._scale * self._rng.standard_normal(len(v))
        self._under_way.append(self._estimator.estimate(time, state, last, standing))
        return Measurement(time, *self._under_way[0])
