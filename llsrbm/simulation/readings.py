"""A robot's own sensors in the simulation: `Readings` from the true state, tick by tick.

The inertial unit is a MEMS one as legged robots and drones carry; the numbers are those of the data
sheet of Bosch's BMI088, which is built for robots that vibrate, unless something else is said.
Units sample faster than controllers read them, so what is read is the mean over the tick: of the
acceleration, the change of the true velocity. That keeps an impact's whole impulse, where the
acceleration at one instant of it would be any number, and comes half a tick late, as real units'
low-pass filters do.

The unit's attitude is by a filter of its own, on the same gyroscope and accelerometer: gravity
bounds the tilt's error while the robot is nearly at rest, nothing bounds the yaw's.
"""

import math

import numpy as np
import pinocchio as pin

from llsrbm.arrays import Array
from llsrbm.control.readings import Readings
from llsrbm.mechanics import GRAVITY, cross
from llsrbm.robots import Robot
from llsrbm.simulation.world import TickResult

# Gyroscope. A density over the root of the tick is the noise of what is read.
GYRO_NOISE = math.radians(0.014)  # rad/s/Hz^0.5
GYRO_RANGE = math.radians(2000.0)  # rad/s
GYRO_BIAS = math.radians(0.3)  # rad/s an axis: the data sheet has 1 at most
GYRO_WALK = math.radians(0.003)  # rad/s^1.5: 0.02 deg/s a minute, of units that warm up
GYRO_SCALE = 0.003  # share, an axis: the data sheet has 1 % at most
# Accelerometer.
ACCELERATION_NOISE = 0.0019  # m/s2/Hz^0.5: 0.19 mg
ACCELERATION_RANGE = 24 * GRAVITY  # m/s2; what an impact makes beyond is lost
ACCELERATION_BIAS = 0.05  # m/s2 an axis: 5 of the data sheet's 20 mg are left by calibration
ACCELERATION_WALK = 3e-4  # m/s2.5
ACCELERATION_SCALE = 0.003  # share, an axis

# The unit's own filter. Makers do not tell; these are the usual ones of complementary filters.
FILTER_TIME = 2.0  # s in which gravity pulls the tilt
FILTER_TRUSTS = 0.1  # share of gravity by which an acceleration may differ to count as gravity

# Joints, rad and rad/s (m and m/s where they slide), and torques.
ENCODER_STEP = math.tau / 2**14  # 14 bits at the joint
JOINT_ZERO = 0.002  # by which a joint's zero is off: a jig's 0.1 deg
SPEED_NOISE = 0.02  # as the disturbance has it: filtered differences of encoders
TORQUE_SCALE = 0.03  # share a joint: torques are currents times a constant
TORQUE_NOISE = 0.005  # of the joint's limit: ripple and friction

# Feet that feel: air bags and bars, which tell little more than whether there is load.
FOOT_FORCE_STEP = 5.0  # N
FOOT_FORCE_SCALE = 0.2  # share a foot


class Instruments:
    """The sensors of one robot, the same for the same `seed`; `tick`: s between readings.

    `foot_force`: whether the robot's feet feel anything; `joint_zero`: (J,) rad or m by which each
    encoder shows too much.
    """

    def __init__(self, robot: Robot, tick: float, seed: int, *, foot_force: bool = False) -> None:
        self._tick = tick
        self._rng = rng = np.random.default_rng([seed, 4])  # apart from all else a seed draws
        joints, legs = len(robot.joint_names), len(robot.legs)
        self._gyro_bias = GYRO_BIAS * rng.standard_normal(3)
        self._gyro_scale = 1 + GYRO_SCALE * rng.standard_normal(3)
        self._acceleration_bias = ACCELERATION_BIAS * rng.standard_normal(3)
        self._acceleration_scale = 1 + ACCELERATION_SCALE * rng.standard_normal(3)
        self.joint_zero = JOINT_ZERO * rng.standard_normal(joints)
        self._torque_scale = 1 + TORQUE_SCALE * rng.standard_normal(joints)
        self._torque_noise = TORQUE_NOISE * robot.torque_limit
        self._foot_scale = 1 + FOOT_FORCE_SCALE * rng.standard_normal(legs)
        self._feels = foot_force
        self._filter = AttitudeFilter(tick)
        self._before: tuple[Array, Array] | None = None

    def forget(self) -> None:
        """The robot was put elsewhere: the next state is not where this one led to."""
        self._before = None

    def read(
        self, time: float, state: tuple[Array, Array], last: TickResult | None = None
    ) -> Readings:
        """The readings at `time`, s, as a tick begins.

        `state`: true q (nq,) and v (nv,), Pinocchio's; `last`: of the tick that ended; None: no
        joint pushed and no foot felt anything.
        """
        q, v = state
        rng, joints = self._rng, len(self.joint_zero)
        gyro, acceleration = self._inertial(q, v)
        torque = np.zeros(joints) if last is None else last.torque
        drift = self._torque_noise * rng.standard_normal(joints)
        return Readings(
            time=time,
            quat=self._filter.update(gyro, acceleration, _quat(q)),
            gyro=gyro,
            acceleration=acceleration,
            q=ENCODER_STEP * np.round((q[7:] + self.joint_zero) / ENCODER_STEP),
            dq=v[6:] + SPEED_NOISE * rng.standard_normal(joints),
            torque=self._torque_scale * torque + drift,
            foot_force=self._foot_force(last) if self._feels else None,
        )

    def _inertial(self, q: Array, v: Array) -> tuple[Array, Array]:
        """Gyroscope and accelerometer, (3,) each, base frame: means over the tick that ended."""
        R = pin.Quaternion(q[3:7]).toRotationMatrix()
        if self._before is None:
            rate, force = v[3:6], GRAVITY * R[2]
        else:
            R_before, velocity_before = self._before
            turn = pin.log3(R_before.T @ R)
            rate = turn / self._tick
            gained = (R @ v[:3] - velocity_before) / self._tick
            gained[2] += GRAVITY
            force = (R_before @ pin.exp3(turn / 2)).T @ gained
        self._before = R, R @ v[:3]
        noise = self._rng.standard_normal((4, 3))
        per_tick, walked = 1 / math.sqrt(self._tick), math.sqrt(self._tick)
        self._gyro_bias = self._gyro_bias + GYRO_WALK * walked * noise[0]
        self._acceleration_bias = self._acceleration_bias + ACCELERATION_WALK * walked * noise[1]
        gyro = self._gyro_scale * rate + self._gyro_bias + GYRO_NOISE * per_tick * noise[2]
        acceleration = (
            self._acceleration_scale * force
            + self._acceleration_bias
            + ACCELERATION_NOISE * per_tick * noise[3]
        )
        return (
            np.clip(gyro, -GYRO_RANGE, GYRO_RANGE),
            np.clip(acceleration, -ACCELERATION_RANGE, ACCELERATION_RANGE),
        )

    def _foot_force(self, last: TickResult | None) -> Array:
        """(L,) N: size of the force on each foot."""
        if last is None:
            return np.zeros(len(self._foot_scale))
        force = self._foot_scale * np.linalg.norm(last.contact_force, axis=1)
        return np.asarray(FOOT_FORCE_STEP * np.round(force / FOOT_FORCE_STEP))


class AttitudeFilter:
    """A complementary filter: the gyroscope is integrated, and gravity pulls the tilt.

    It has settled when it is first asked, the yaw true then.
    """

    def __init__(self, tick: float) -> None:
        self._tick = tick
        self._R: Array | None = None

    def update(self, gyro: Array, acceleration: Array, quat: Array) -> Array:
        """The attitude (4,) w, x, y, z a tick later; `quat`: the true one, for the first."""
        size = float(np.linalg.norm(acceleration))
        up = acceleration / size if size > 0 else np.array([0.0, 0.0, 1.0])
        if self._R is None:
            w, x, y, z = quat
            R = pin.Quaternion(w, x, y, z).toRotationMatrix()
            self._R = R @ pin.Quaternion.FromTwoVectors(up, R[2]).toRotationMatrix()
        else:
            if abs(size - GRAVITY) < FILTER_TRUSTS * GRAVITY:
                gyro = gyro + cross(up, self._R[2]) / FILTER_TIME
            self._R = self._R @ pin.exp3(gyro * self._tick)
        x, y, z, w = pin.Quaternion(self._R).normalized().coeffs()
        return np.array([w, x, y, z])


def _quat(q: Array) -> Array:
    """(4,) w, x, y, z of Pinocchio's q."""
    return q[[6, 3, 4, 5]]
