"""The analytic initial guess: a ballistic hop, a slerp about the vertical, feet carried along."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from llsrbm.models.base import CentroidalModel
from llsrbm.motion.plan import Phase
from llsrbm.planning.constraints.swing import ground_line
from llsrbm.planning.knots import feet_in_stance
from llsrbm.planning.layout import Layout
from llsrbm.planning.stage import GRAVITY
from llsrbm.planning.task import Task

Array = NDArray[np.float64]

STANCE_TIME = 0.48  # s, of take-off and landing
LIFT_OFF_RISE = 0.03  # m above standing height at lift-off and touchdown
LOADS = (0.1, 2.5)  # least and largest load, times the robot's weight
STANCE_SHARE = 0.3  # share of the stance phases in the travel at flight speed


def _hermite(p0: Array, v0: Array, p1: Array, v1: Array, T: float, t: float) -> tuple[Array, ...]:
    s = t / T
    position = (
        (2 * s**3 - 3 * s**2 + 1) * p0
        + (s**3 - 2 * s**2 + s) * T * v0
        + (3 * s**2 - 2 * s**3) * p1
        + (s**3 - s**2) * T * v1
    )
    velocity = (
        (6 * s**2 - 6 * s) * (p0 - p1) / T + (3 * s**2 - 4 * s + 1) * v0 + (3 * s**2 - 2 * s) * v1
    )
    acceleration = (12 * s - 6) * (p0 - p1) / T**2 + (6 * s - 4) * v0 / T + (6 * s - 2) * v1 / T
    return position, velocity, acceleration


def _about_vertical(angle: float) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def analytic_guess(
    task: Task, layout: Layout, model: CentroidalModel, flight_time: float | None = None
) -> Array:
    """All variables, in the layout's order and units.

    Args:
        task: where from and where to.
        layout: what to fill.
        model: for the feet in their hip frames.
        flight_time: s; None chooses by twist, distance and height.
    """
    twist = task.jump.twist
    shift = task.goal_position - task.start_position
    if flight_time is None:
        flight_time = (
            0.28
            + 0.2 * abs(twist) / np.pi
            + 0.15 * float(np.hypot(*shift[:2]))
            + 0.3 * max(shift[2], 0.0)
        )
    T = np.array([STANCE_TIME, float(np.clip(flight_time, *task.timing.flight)), STANCE_TIME])
    for phase in Phase:
        T[phase] = np.clip(T[phase], *getattr(task.timing, phase.name.lower()))
    travel_time = T[1] + STANCE_SHARE * (T[0] + T[2])
    v_lift = np.append(shift[:2] / travel_time, shift[2] / T[1] + 0.5 * GRAVITY * T[1])
    v_land = v_lift - [0.0, 0.0, GRAVITY * T[1]]
    turn_rate = twist / travel_time
    r_lift = task.start_position + np.append(v_lift[:2] * T[0] * STANCE_SHARE, LIFT_OFF_RISE)
    r_land = r_lift + v_lift * T[1] - [0.0, 0.0, 0.5 * GRAVITY * T[1] ** 2]
    yaw_lift = turn_rate * T[0] * STANCE_SHARE
    rest = np.zeros(3)

    def body(phase: Phase, s: float) -> tuple[Array, Array, Array, float, float]:
        t = s * T[phase]
        if phase == Phase.FLIGHT:
            fall = np.array([0.0, 0.0, GRAVITY])
            position = r_lift + v_lift * t - fall * t**2 / 2
            return position, v_lift - fall * t, -fall, yaw_lift + turn_rate * t, turn_rate
        if phase == Phase.TAKEOFF:
            linear = _hermite(task.start_position, rest, r_lift, v_lift, T[0], t)
            yaw = _hermite(rest[:1], rest[:1], rest[:1] + yaw_lift, rest[:1] + turn_rate, T[0], t)
        else:
            linear = _hermite(r_land, v_land, task.goal_position, rest, T[2], t)
            start = rest[:1] + yaw_lift + turn_rate * T[1]
            yaw = _hermite(start, rest[:1] + turn_rate, rest[:1] + twist, rest[:1], T[2], t)
        position, velocity, acceleration = linear
        return position, velocity, acceleration, float(yaw[0][0]), float(yaw[1][0])

    def flying_feet(s: float) -> Array:
        carried = task.start_feet @ _about_vertical(twist * s).T
        carried[:, :2] += s * shift[:2]
        arch = (4 * s * (1 - s)) ** 2 * task.limits.clearance * 1.3
        carried[:, 2] = ground_line(task, np.array([s]))[0] + arch
        return carried

    def in_hips(s: float) -> Array:
        position, _, _, yaw, _ = body(Phase.FLIGHT, s)
        R = _about_vertical(yaw)[None]
        headings = (1 - s) * task.start_yaw + s * task.goal_yaw
        x = feet_in_stance(model, R, position[None], flying_feet(s)[None], headings[None])[0]
        place = np.clip(x[:, :3], task.reach.lower, task.reach.upper)
        length = np.linalg.norm(place, axis=1, keepdims=True)
        place = place * np.clip(length, *task.reach.distance) / length
        return np.hstack([place, np.clip(x[:, 3:], *task.foot.yaw)])

    steps = layout.intervals.flight
    feet = np.array([in_hips(k / steps) for k in range(steps + 1)])
    rates = np.diff(feet, axis=0) * steps / T[1]
    feet_velocity = np.concatenate([rates[:1], rates])
    feet_step = np.diff(feet_velocity, axis=0)
    inertia_zz = model.evaluate(feet[:1])[1][0, 2, 2]
    w = np.zeros(layout.size_total)
    for k, role in enumerate(layout.roles):
        s = layout.progress[k]
        position, velocity, acceleration, yaw, yaw_rate = body(role.phase, s)
        load = np.clip(acceleration[2] / GRAVITY + 1, *LOADS)
        flight_knot = k - layout.intervals.takeoff
        in_flight = role.phase == Phase.FLIGHT
        values = {
            "position": position,
            "velocity": velocity,
            "quat": [np.cos(yaw / 2), 0, 0, np.sin(yaw / 2)],
            "momentum": [0, 0, inertia_zz * yaw_rate / task.mass],
            "rotation_rate": [0, 0, yaw_rate],
            "duration": T[role.phase],
            "next_duration": T[min(role.phase + 1, 2)],
            "force": np.tile([0, 0, load], layout.contacts),
            "force_step": np.zeros(3 * layout.contacts),
            "next_force": np.tile([0, 0, 1.5], layout.contacts),
            "next_feet": feet[0].ravel(),
            "next_feet_velocity": feet_velocity[0].ravel(),
            "feet_velocity": feet_velocity[-1].ravel(),
            "feet": feet[flight_knot if in_flight else -1].ravel(),
        }
        if in_flight:
            values["feet_velocity"] = feet_velocity[flight_knot].ravel()
            values["feet_step"] = feet_step[flight_knot].ravel()
            values["feet_stop"] = np.zeros(feet[0].size)
        for name, place in layout.variables(k).items():
            w[place] = values[name]
    return w
