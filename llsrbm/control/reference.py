"""A plan as the controller follows it: smooth, sampled finely, looked up in no time."""

from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.interpolate import make_interp_spline
from scipy.spatial.transform import Rotation

from llsrbm.arrays import Array
from llsrbm.control.swing import UnderWay, swing_motion
from llsrbm.mechanics import GRAVITY
from llsrbm.motion.grounds import foot_normals
from llsrbm.motion.plan import Plan
from llsrbm.motion.sampling import sampled
from llsrbm.request.slopes import slopes_of

_STEP = 5e-4  # s; a reference is at most half of it old
_JUST_BEFORE = 2 * _STEP  # touchdown, where the nearest sample surely is one of the flight
_AHEAD = 64  # samples, 32 ms: a plan that is made anew under way is followed for 20
_SAMPLED = (
    *("com", "com_velocity", "base_quat", "angular_momentum"),
    *("joint_position", "joint_velocity"),
)
BRAKING = 0.3  # s in which a robot that keeps some speed comes to rest after the plan's end


class Target(NamedTuple):
    """The motion wanted at one instant: L legs, C contacts, J joints; world frame, SI units."""

    com: Array  # (3,)
    com_velocity: Array  # (3,)
    com_acceleration: Array  # (3,)
    R_world_base: Array  # (3, 3)
    angular_velocity: Array  # (3,) of the base
    angular_acceleration: Array  # (3,) of the base
    angular_momentum: Array  # (3,) about the CoM
    angular_momentum_rate: Array  # (3,) about the CoM
    contact_force: Array  # (C, 3) N
    # foot_from_com, foot_velocity_from_com, foot_acceleration_from_com: (L, 3): of the lowest point
    # of each foot, relative to the CoM, world axes.
    foot_from_com: Array
    foot_velocity_from_com: Array
    foot_acceleration_from_com: Array
    foot_heading: Array  # (L, 3): heading of each foot, its rate and its acceleration
    joint_position: Array  # (J,)
    joint_velocity: Array  # (J,)
    joint_acceleration: Array  # (J,)


class Reference:
    """The plan at any time; before its start and after its end it stands still.

    After a plan that ends with speed the CoM comes to rest with a constant deceleration.
    """

    def __init__(self, plan: Plan, weight: float, start: UnderWay | None = None) -> None:
        """Sample the plan; all contacts alike carry `weight`, N, of the robot after its end.

        `start`: from where it is followed, for a while perhaps: only what comes next is sampled,
        more as it is needed; None: all of it at once.
        """
        self.plan = plan
        self._weight = weight
        self._start = start
        self._first = 0 if start is None else int(np.searchsorted(plan.time, start.time - 1e-9))
        self._samples = len(np.arange(0.0, plan.duration + braking_time(plan) + 2 * _STEP, _STEP))
        self._columns: dict[int, tuple[dict[str, Array], int]] = {}  # sampled, and its row there
        self._targets: dict[int, Target] = {}
        self._late: dict[int, Target] = {}
        self._ahead = self._samples if start is None else _AHEAD
        self.at(0.0 if start is None else start.time)

    def at(self, time: float) -> Target:
        """The plan's nearest sample to a time, s since its start."""
        if time <= -_STEP:
            return self._standing
        index = min(max(round(time / _STEP), 0), self._samples - 1)
        target = self._targets.get(index)
        if target is None:
            if index not in self._columns:
                self._sample(index, min(index + self._ahead, self._samples))
                self._ahead *= 2
            columns, row = self._columns[index]
            target = Target(**{name: values[row] for name, values in columns.items()})
            self._targets[index] = target
        return target

    @cached_property
    def _standing(self) -> Target:
        """In the plan's first posture, before its start."""
        first = self.at(0.0)
        force = np.zeros_like(first.contact_force)
        force[:, 2] = self._weight / len(force)
        still = {
            name: np.zeros_like(getattr(first, name))
            for name in (
                *("com_velocity", "com_acceleration", "angular_velocity", "angular_acceleration"),
                *("angular_momentum", "angular_momentum_rate", "joint_velocity"),
                *("joint_acceleration", "foot_velocity_from_com", "foot_acceleration_from_com"),
            )
        }
        heading = first.foot_heading * [1.0, 0.0, 0.0]
        return first._replace(contact_force=force, foot_heading=heading, **still)

    @cached_property
    def slopes(self) -> bool:
        """True if feet stand on what is not level."""
        return bool(np.any(slopes_of(self.plan.jump, self.plan.schedule.places)))

    def normals(self, time: float) -> Array:
        """(L, 3) unit normals of what the feet stand on at a time, s since the plan's start."""
        index = min(max(round(time / _STEP), 0), len(self._normals) - 1)
        found: Array = self._normals[index]
        return found

    @cached_property
    def _normals(self) -> Array:
        return foot_normals(self.plan, _STEP * np.arange(self._samples, dtype=np.float64))

    def late(self, flight: int) -> Target:
        """The target in a flight after its planned touchdown: legs held as they should land."""
        if flight not in self._late:
            last = self.at(float(self.plan.phase_start[flight + 1]) - _JUST_BEFORE)
            still = np.zeros_like(last.foot_from_com)
            self._late[flight] = last._replace(
                foot_velocity_from_com=still,
                foot_acceleration_from_com=still,
                foot_heading=last.foot_heading * [1.0, 0.0, 0.0],
            )
        return self._late[flight]

    def _sample(self, first: int, end: int) -> None:
        plan, weight, knot = self.plan, self._weight, self._first
        times = np.arange(first, end) * _STEP + plan.time[0]
        motion = sampled(plan, times, _SAMPLED)
        omega, omega_rate = _angular_velocity(plan, times, knot)
        foot, heading = swing_motion(plan, times, knot, self._start)
        moving = times[:, None] < plan.time[-1]
        standing = np.zeros(plan.contact_force.shape[1:])
        standing[:, 2] = weight / len(standing)
        dt = np.diff(plan.time)[:, None]
        columns = {
            "com": motion["com"],
            "com_velocity": motion["com_velocity"] * moving,
            "com_acceleration": _without_steps(
                plan, times, np.diff(plan.com_velocity, axis=0) / dt, knot
            ),
            "R_world_base": Rotation.from_quat(motion["base_quat"], scalar_first=True).as_matrix(),
            "angular_velocity": omega * moving,
            "angular_acceleration": omega_rate * moving,
            "angular_momentum": motion["angular_momentum"] * moving,
            "angular_momentum_rate": _without_steps(
                plan, times, np.diff(plan.angular_momentum, axis=0) / dt, knot
            ),
            "contact_force": _without_steps(plan, times, plan.contact_force[:-1] - standing, knot)
            + standing,
            "foot_from_com": foot[0],
            "foot_velocity_from_com": foot[1],
            "foot_acceleration_from_com": foot[2],
            "foot_heading": heading,
            "joint_position": motion["joint_position"],
            "joint_velocity": motion["joint_velocity"] * moving,
            "joint_acceleration": _slopes(motion["joint_velocity"]) * moving,
        }
        if braking_time(plan):
            _brake(plan, times, columns, weight)
        self._columns |= {first + row: (columns, row) for row in range(end - first)}


def _slopes(samples: Array) -> Array:
    """Time derivative (K, J) of samples (K, J), `_STEP` apart."""
    if len(samples) < 2:
        return np.zeros_like(samples)
    return np.gradient(samples, _STEP, axis=0)


def braking_time(plan: Plan) -> float:
    """S from the plan's end until the reference is at rest; 0 of a plan that ends at rest."""
    return BRAKING if plan.jump.end_speed else 0.0


def com_at_rest(plan: Plan) -> Array:
    """(3,) m: where the CoM comes to rest."""
    return plan.com[-1] + braking_time(plan) / 2 * plan.com_velocity[-1]


def _brake(plan: Plan, times: Array, columns: dict[str, Array], weight: float) -> None:
    """Fill in, in place, how the motion comes to rest after the plan's end."""
    since = np.clip(times - plan.time[-1], 0.0, BRAKING)[:, None]
    velocity = plan.com_velocity[-1]
    acceleration = -velocity / BRAKING
    now = (times >= plan.time[-1]) & (times < plan.time[-1] + BRAKING)
    columns["com"] = columns["com"] + since * velocity + since**2 / 2 * acceleration
    columns["com_velocity"][now] = velocity + since[now] * acceleration
    columns["com_acceleration"][now] = acceleration
    forces = columns["contact_force"]
    forces[now] += weight / GRAVITY * acceleration / forces.shape[1]
    for name in ("angular_velocity", "angular_momentum"):
        end = getattr(plan, name)[-1]
        columns[name][now] = end * (1 - since[now] / BRAKING)
    columns["angular_acceleration"][now] = -plan.angular_velocity[-1] / BRAKING
    columns["angular_momentum_rate"][now] = -plan.angular_momentum[-1] / BRAKING


def _without_steps(plan: Plan, times: Array, values: Array, knot: int) -> Array:
    """Values (N, ...) that are constant over each of the plan's intervals, at K times, (K, ...).

    Straight between the middles of intervals of one phase from a knot on, so that torques have no
    steps, and zero from the plan's end on. Only phases begin and end with steps.
    """
    begun = np.arange(len(plan.time) - 1) >= knot
    middle = (plan.time[1:] + plan.time[:-1]) / 2
    smooth = np.zeros((len(times), *values.shape[1:]))
    last = len(plan.schedule) - 1
    for phase in range(len(plan.schedule)):
        inside = (plan.phase[:-1] == phase) & begun
        if not inside.any():
            continue
        start, end = plan.phase_start[phase], plan.phase_start[phase + 1]
        now = (times >= start) & (times < end)
        at, value = middle[inside], values[inside]
        if phase == last:
            at = np.append(at, end)
            value = np.concatenate([value, np.zeros((1, *value.shape[1:]))])
        if len(at) == 1:
            smooth[now] = value
            continue
        curve = make_interp_spline(at, value, k=1)
        smooth[now] = curve(np.clip(times[now], at[0], at[-1]))
    return smooth


def _angular_velocity(plan: Plan, times: Array, knot: int) -> tuple[Array, Array]:
    """The base's angular velocity and acceleration, (K, 3), from the turns between knots.

    Straight between the middles of intervals of one phase, held from the last middle to the phase's
    edge: a line across lift-off would need ground forces for the flight's rotation before the feet
    have left, at the price of angular momentum. Where the plan starts or ends at rest, so does it,
    and at a knot at which it begins under way it is what the plan says.
    """
    attitude = Rotation.from_quat(plan.base_quat, scalar_first=True)
    dt = np.diff(plan.time)
    turn = (attitude[1:] * attitude[:-1].inv()).as_rotvec() / dt[:, None]
    middle = (plan.time[1:] + plan.time[:-1]) / 2
    omega, rate = np.zeros((2, len(times), 3))
    first = plan.angular_velocity[knot] if plan.jump.speed or knot else np.zeros(3)
    begun = np.arange(len(dt)) >= knot
    final = plan.angular_velocity[-1] if plan.jump.end_speed else np.zeros(3)
    for phase in range(len(plan.schedule)):
        inside = (plan.phase[:-1] == phase) & begun
        if not inside.any():
            continue
        at, value = middle[inside], turn[inside]
        if phase == plan.phase[knot]:
            at, value = np.append(plan.time[knot], at), np.vstack([first, value])
        if phase == len(plan.schedule) - 1:
            at, value = np.append(at, plan.time[-1]), np.vstack([value, final])
        now = (times >= plan.phase_start[phase]) & (times < plan.phase_start[phase + 1])
        if len(at) == 1:
            omega[now] = value
            continue
        piece = np.clip(np.searchsorted(at, times[now], side="right") - 1, 0, len(at) - 2)
        share = np.clip((times[now] - at[piece]) / np.diff(at)[piece], 0.0, 1.0)[:, None]
        slope = np.diff(value, axis=0) / np.diff(at)[:, None]
        omega[now] = (1 - share) * value[piece] + share * value[piece + 1]
        rate[now] = slope[piece] * ((times[now] >= at[0]) & (times[now] <= at[-1]))[:, None]
    return omega, rate
