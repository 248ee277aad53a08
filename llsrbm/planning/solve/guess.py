"""The analytic initial guess: ballistic flights between smooth stances, feet carried along.

The body turns about the vertical with every displacement, at one rate from shortly before lift-off
to shortly after touchdown; a flip turns over in the first flight, a little of it before and after.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import casadi as ca
import numpy as np
from scipy.spatial.transform import Rotation

from llsrbm.arrays import Array
from llsrbm.mechanics import GRAVITY, turns_about_z
from llsrbm.models.base import CentroidalModel, no_lift
from llsrbm.planning.problem.foot_clearance import ground_line
from llsrbm.planning.problem.knots import Sampled, pack
from llsrbm.planning.problem.layout import Layout
from llsrbm.planning.problem.rotations import feet_seen
from llsrbm.planning.problem.task import Task

STANCE_TIME = 0.48  # s, of take-off and landing
OWN_TIME = 0.3  # of the way from shortest to longest, for phases with limits of their own
LIFT_OFF_RISE = 0.03  # m above standing height at lift-off and touchdown
LOADS = (0.1, 2.5)  # least and largest load, times the robot's weight
LANDING_LOAD = 1.5  # of feet that meet the ground, likewise
STANCE_SHARE = 0.3  # share of the stance phases in the travel at flight speed
FLIP_FLIGHT = 0.55  # s, flight time of a whole turn
FLIP_SHARE = 0.1  # of a whole turn that is made before lift-off, and as much after touchdown
TUCK = 0.3  # share by which the legs are shortened in mid-flip


def analytic_guess(task: Task, layout: Layout, model: CentroidalModel) -> Array:
    """All variables, in the layout's order and units.

    Args:
        task: where from and where to.
        layout: what to fill.
        model: for the feet in their hip frames.
    """
    path = _Path(task)
    at = zip(layout.phase.tolist(), layout.progress.tolist(), strict=True)
    knots = [path.body(phase, s) for phase, s in at]
    feet = _feet(task, layout, model, path, knots)
    # xdot of the interval before each knot; at lift-off that of the first interval.
    rate = np.zeros_like(feet)
    for leg, lift, touch in layout.swings:
        dt = [path.times[layout.phase[k]] / layout.roles[k].intervals for k in range(lift, touch)]
        rates = np.diff(feet[lift : touch + 1, leg], axis=0) / np.array(dt)[:, None]
        rate[lift, leg] = rates[0]
        rate[lift + 1 : touch + 1, leg] = rates
    first_flight = int(layout.first_knots[task.schedule.flights[0]])
    x = ca.DM(feet[first_flight].T)
    arms = None
    if model.arms is not None:
        angles = ca.SX(ca.DM(model.arms.at_rest))
        arms = model.arms.carried(angles, 0 * angles, no_lift)
    lift_off = np.array(ca.DM(model.inertia(x, model.base_offset(x, arms), arms)))
    return pack(
        layout,
        Sampled(
            durations=path.times,
            position=np.array([body.position for body in knots]),
            velocity=np.array([body.velocity for body in knots]),
            quat=np.array([body.quat for body in knots]),
            momentum=np.array(
                [body.R @ (np.diag(lift_off) * body.rotation_rate) / task.mass for body in knots]
            ),
            rotation_rate=np.array([body.rotation_rate for body in knots]),
            feet=feet,
            feet_velocity=rate,
            **arms_still(task, layout),
            force=_carrying(layout, knots),
            landing_force=_upwards(layout, np.full(layout.legs, LANDING_LOAD)),
            shift=np.zeros(2),
        ),
    )


def arms_still(task: Task, layout: Layout) -> dict[str, Array]:
    """Free arms as they hang, of a motion at all knots."""
    angles = task.robot.arm_angles[: layout.arm_joints]
    still = np.zeros((layout.knots, layout.arm_joints))
    return {"arms": still + angles, "arms_velocity": still}


def _carrying(layout: Layout, knots: list[_Body]) -> Array:
    """(N+1, L, c, 3) vertical forces that carry the body, shared alike by feet that stand."""
    forces = []
    for body, role in zip(knots, layout.roles, strict=True):
        load = np.clip(body.acceleration[2] / GRAVITY + 1, *LOADS)
        load = load * layout.legs / max(len(role.standing), 1)
        forces.append(_upwards(layout, np.full(layout.legs, load)))
    return np.array(forces)


def _upwards(layout: Layout, loads: Array) -> Array:
    """(L, c, 3) forces of loads (L,) a contact."""
    return np.tile(loads[:, None, None] * [0.0, 0.0, 1.0], (1, layout.corners, 1))


@dataclass(frozen=True, eq=False)
class _Body:
    """CoM (3,) m, m/s, m/s2; turn (yaw, pitch, roll) rad and its rates, rad/s."""

    position: Array
    velocity: Array
    acceleration: Array
    turn: Array
    turn_rate: Array

    @cached_property
    def quat(self) -> Array:
        """(4,) w, x, y, z of Rz(yaw) Ry(pitch) Rx(roll), continuous through whole turns."""
        q = np.array([1.0, 0.0, 0.0, 0.0])
        for angle, axis in zip(self.turn, (3, 2, 1), strict=True):
            half = np.zeros(4)
            half[0], half[axis] = np.cos(angle / 2), np.sin(angle / 2)
            w, x, y, z = q
            product = np.array([[w, -x, -y, -z], [x, w, -z, y], [y, z, w, -x], [z, -y, x, w]])
            q = product @ half
        return q

    @cached_property
    def R(self) -> Array:
        """(3, 3) R_world_base."""
        return Rotation.from_quat(self.quat, scalar_first=True).as_matrix()

    @cached_property
    def rotation_rate(self) -> Array:
        """(3,) rad/s, base axes."""
        _, pitch, roll = self.turn
        yaw_rate, pitch_rate, roll_rate = self.turn_rate
        up = np.array([-np.sin(pitch), np.sin(roll) * np.cos(pitch), np.cos(roll) * np.cos(pitch)])
        rate: Array = (
            yaw_rate * up
            + pitch_rate * np.array([0.0, np.cos(roll), -np.sin(roll)])
            + [roll_rate, 0.0, 0.0]
        )
        return rate


@dataclass(frozen=True, eq=False)
class _Flight:
    """Body at lift-off and touchdown of one flight."""

    lift_off: _Body
    touchdown: _Body


class _Path:
    """The body's path over the schedule: flights, and stances from one to the next.

    Attributes:
        times: (P,) s, of the phases.
    """

    def __init__(self, task: Task) -> None:
        self._task = task
        phases = list(task.schedule)
        self.times = np.array([_time(task, p) for p in range(len(phases))])
        for p in task.schedule.flights:
            self.times[p] = np.clip(self._flight_time(phases[p].place), *task.times(p))
        # Runs of phases between flights, and where each phase begins in its run.
        edges = [-1, *task.schedule.flights, len(phases)]
        self._run_of = np.zeros(len(phases), dtype=np.int64)
        self._start_in_run = np.zeros(len(phases))
        self._run_times = []
        for run, (before, after) in enumerate(pairwise(edges)):
            inside = range(before + 1, after)
            self._run_of[list(inside)] = run
            elapsed = np.cumsum([0.0, *self.times[list(inside)]])
            self._start_in_run[list(inside)] = elapsed[:-1]
            self._run_times.append(float(elapsed[-1]))
        self._flights = [self._flight(i, p) for i, p in enumerate(task.schedule.flights)]

    def com(self, place: int) -> Array:
        """CoM of the robot that stands in a place, (3,) m."""
        task, here = self._task, self._task.places[place]
        return here.origin + turns_about_z(here.heading) @ task.start_position

    def _flight_time(self, place: int) -> float:
        """By twist, distance and height of the displacement after a place."""
        before, after = self._task.places[place], self._task.places[place + 1]
        if self._task.jump.turns and place == 0:
            return FLIP_FLIGHT
        shift = self.com(place + 1) - self.com(place)
        return (
            0.28
            + 0.2 * abs(after.heading - before.heading) / np.pi
            + 0.15 * float(np.hypot(*shift[:2]))
            + 0.3 * max(shift[2], 0.0)
        )

    def _flight(self, index: int, phase: int) -> _Flight:
        task, T = self._task, float(self.times[phase])
        before, after = self._run_times[index], self._run_times[index + 1]
        place = task.schedule[phase].place
        start, goal = task.places[place], task.places[place + 1]
        shift = self.com(place + 1) - self.com(place)
        travel_time = T + STANCE_SHARE * (before + after)
        v_lift = np.append(shift[:2] / travel_time, shift[2] / T + 0.5 * GRAVITY * T)
        fall = np.array([0.0, 0.0, GRAVITY])
        rise = np.append(v_lift[:2] * before * STANCE_SHARE, LIFT_OFF_RISE)
        r_lift = self.com(place) + rise
        yaw_rate = (goal.heading - start.heading) / travel_time
        over = np.array([0.0, task.jump.pitch, task.jump.roll]) * (index == 0)
        over_rate = (1 - 2 * FLIP_SHARE) * over / T
        turn = FLIP_SHARE * over + [start.heading + yaw_rate * before * STANCE_SHARE, 0.0, 0.0]
        if index > 0:
            turn[1:] += task.jump.pitch, task.jump.roll
        rate = over_rate + np.array([yaw_rate, 0.0, 0.0])
        return _Flight(
            _Body(r_lift, v_lift, -fall, turn, rate),
            _Body(
                r_lift + v_lift * T - fall * T**2 / 2,
                v_lift - fall * T,
                -fall,
                turn + rate * T,
                rate,
            ),
        )

    def body(self, phase: int, progress: float) -> _Body:
        """At a share of a phase."""
        t = progress * self.times[phase]
        if phase in self._task.schedule.flights:
            flight = self._flights[self._task.schedule.flights.index(phase)]
            lift, fall = flight.lift_off, np.array([0.0, 0.0, GRAVITY])
            return _Body(
                lift.position + lift.velocity * t - fall * t**2 / 2,
                lift.velocity - fall * t,
                -fall,
                lift.turn + lift.turn_rate * t,
                lift.turn_rate,
            )
        run = int(self._run_of[phase])
        start = self._flights[run - 1].touchdown if run else self._start
        end = self._flights[run].lift_off if run < len(self._flights) else self._end
        T, t = self._run_times[run], t + self._start_in_run[phase]
        r, v, a = _hermite(start.position, start.velocity, end.position, end.velocity, T, t)
        turn, turn_rate, _ = _hermite(start.turn, start.turn_rate, end.turn, end.turn_rate, T, t)
        return _Body(r, v, a, turn, turn_rate)

    @property
    def _start(self) -> _Body:
        task, none = self._task, np.zeros(3)
        turn = np.array([0.0, *task.lean(0)])
        return _Body(task.start_position, task.start_velocity, none, turn, none)

    @property
    def _end(self) -> _Body:
        task, none = self._task, np.zeros(3)
        pitch, roll = task.lean(-1)
        turn = np.array([task.places[-1].heading, task.jump.pitch + pitch, task.jump.roll + roll])
        return _Body(task.goal_position, task.goal_velocity, none, turn, none)


def _time(task: Task, phase: int) -> float:
    """Duration of a phase on the ground, s."""
    low, high = task.times(phase)
    if isinstance(task.schedule[phase].time, str):
        return float(np.clip(STANCE_TIME, low, high))
    return low + OWN_TIME * (high - low)


def _feet(
    task: Task, layout: Layout, model: CentroidalModel, path: _Path, knots: list[_Body]
) -> Array:
    """(N+1, L, d) m, rad: x of feet in the air, lift-off and touchdown among it; else zeros."""
    feet = np.zeros((layout.knots, layout.legs, layout.foot_coordinates))
    for leg, lift, touch in layout.swings:
        # The knot of touchdown is the next phase's first; its body is where the flight ends.
        swing = slice(lift, touch + 1)
        phase = int(layout.phase[lift])
        feet[swing, leg] = _flying_foot(task, model, path, phase, leg, knots[swing])
    return feet


def _flying_foot(
    task: Task, model: CentroidalModel, path: _Path, phase: int, leg: int, bodies: list[_Body]
) -> Array:
    """(K, d) m, rad: x of a foot at the knots of the swing that begins with a phase."""
    s = np.arange(len(bodies)) / (len(bodies) - 1)
    stood, lands = task.footholds_before(phase), task.footholds_after(phase)
    a, b = task.schedule[phase].place, int(task.schedule.places_after[phase, leg])
    start, goal = task.places[a], task.places[b]
    shift = path.com(b) - path.com(a)
    turned = turns_about_z(s * (goal.heading - start.heading))
    carried = np.einsum("kij,lj->kli", turned, stood.feet - start.origin) + start.origin
    carried[..., :2] += s[:, None, None] * shift[:2]
    if task.jump.stones:
        carried[..., :2] += s[:, None, None] * (lands.feet - carried[-1])[:, :2]
    arch = (4 * s * (1 - s)) ** 2 * task.limits.clearance * 1.3
    line = ground_line(stood.feet[:, 2], lands.feet[:, 2], s[:, None])
    carried[..., 2] = line + arch[:, None]
    heading = (1 - s[:, None]) * stood.yaw + s[:, None] * lands.yaw
    # A body that turns over carries its legs along as an upright one would.
    turns = task.jump.turns
    R = np.array([turns_about_z(body.turn[0]) if turns else body.R for body in bodies])
    position = np.array([body.position for body in bodies])
    x = _seen(model, R, position, carried, heading)[:, leg]
    place = x[:, :3]
    if turns:
        place = place * np.stack(
            [np.ones_like(s), np.ones_like(s), 1 - TUCK * np.sin(np.pi * s)], 1
        )
    place = np.clip(place, task.reach.lower, task.reach.upper)
    length = np.linalg.norm(place, axis=1, keepdims=True)
    place = place * np.clip(length, *task.reach.distance) / length
    return np.concatenate([place, np.clip(x[:, 3:], *task.foot.yaw)], axis=1)


def _seen(model: CentroidalModel, R: Array, position: Array, feet: Array, heading: Array) -> Array:
    """x (K, L, d) of feet (K, L, 3) m with headings (K, L) rad, from R (K, 3, 3) and r (K, 3)."""
    still, rest = ca.DM.zeros(3), ca.DM.zeros(3, model.legs)
    arms = () if model.arms is None else (model.arms.at_rest, 0 * model.arms.at_rest)
    x, _ = feet_seen(model)(
        np.hstack(list(R)),
        position.T,
        still,
        still,
        feet.reshape(-1, 3).T,
        rest,
        heading.T,
        ca.DM.zeros(model.legs),
        *arms,
    )
    return np.array(x).T.reshape(*feet.shape[:2], -1)


def _hermite(
    p0: Array, v0: Array, p1: Array, v1: Array, T: float, t: float
) -> tuple[Array, Array, Array]:
    """Place, velocity and acceleration at t of T, s, between two places with their velocities."""
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
