"""What a plan must respect: the paper's constraints and what a real robot needs beside them.

One small class each, found by name, that says the same thing three times over: as rows for the
solver, as their bounds in numbers, and as a check of the finished plan in NumPy, which does not use
the rows. Adding a constraint is one class and its place in `CONSTRAINTS`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from itertools import combinations
from typing import Any, ClassVar

import casadi as ca
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from llsrbm.planning.knots import Knots
from llsrbm.planning.layout import Layout, Role
from llsrbm.planning.stage import Stage
from llsrbm.planning.task import Task
from llsrbm.trajectory.plan import Phase

Array = NDArray[np.float64]
Bounds = tuple[Any, Any]

# A foot's speed may rise to 8 s (1 - s) of its limit over the flight, s = 0 ... 1: full from an
# eighth of the way on, zero at lift-off and touchdown, where the foot stands.
SPEED_RAMP = 8.0

# Share of the joint speed limit that the knee may use at an interval's midpoint. The rest is for
# the speed it gains up to the interval's end (push-off: about 10 %) and for the hip abduction,
# which moves the hip joint a little (about 10 %).
KNEE_SHARE = 0.75


class Constraint(ABC):
    """Rows lower <= rows(stage) <= upper at every stage whose role applies.

    Attributes:
        name: as in reports and files.
        unit: of `violation`.
        equality: whether lower equals upper.
    """

    name: ClassVar[str]
    unit: ClassVar[str]
    equality: ClassVar[bool] = False

    @abstractmethod
    def applies(self, role: Role) -> bool:
        """Whether stages of that role have these rows."""

    @abstractmethod
    def rows(self, stage: Stage) -> Any:
        """(n, 1) expressions."""

    @abstractmethod
    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """Lower and upper bounds of the rows, anything that broadcasts to (n,)."""

    @abstractmethod
    def violation(self, knots: Knots) -> Array:
        """(N+1,) amount of the violation at or after each knot, in `unit`; 0 when satisfied."""


def _spread(knots: Knots, where: slice, amounts: Array) -> Array:
    """(N+1,) with the largest of `amounts`, (n, ...), at the knots `where`; never negative."""
    out = np.zeros(len(knots.time))
    flat = amounts.reshape(len(amounts), -1)
    out[where] = np.maximum(flat.max(axis=1), 0.0)
    return out


def _everywhere(knots: Knots) -> slice:
    return slice(0, len(knots.time))


class MomentumBalance(Constraint):
    """I omega + h = R^T L at the midpoint of each interval (eqs. 3, 4; `llsrbm-plus`: with h)."""

    name = "momentum_balance"
    unit = "kg m2/s"
    equality = True

    def applies(self, role: Role) -> bool:
        """Over every interval."""
        return not role.terminal

    def rows(self, stage: Stage) -> Any:
        """(3, 1)."""
        return stage.balance

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """Zero."""
        return np.zeros(3), np.zeros(3)

    def violation(self, knots: Knots) -> Array:
        """|I omega + h - R^T L|."""
        R, _, _ = knots.mid
        x, xdot = knots.feet_mid
        momentum = knots.model.evaluate_momentum(x, xdot, knots.rotation_rate)
        mean = (knots.momentum[:-1] + knots.momentum[1:]) / 2
        error = momentum - np.einsum("kji,kj->ki", R, mean)
        return _spread(knots, slice(0, len(error)), np.abs(error))


class GivenContacts(Constraint):
    """p_i = p_i* at lift-off and at touchdown: the feet leave where they stood, land on target."""

    name = "given_contacts"
    unit = "m"
    equality = True

    def applies(self, role: Role) -> bool:
        """At the first knots of flight and landing."""
        return role.first and role.phase != Phase.TAKEOFF

    def rows(self, stage: Stage) -> Any:
        """(3 L, 1): p_i - p_i*."""
        r, R = stage.position, stage.R_world_base
        feet = [r + ca.mtimes(R, stage.foot_from_com(i)) for i in range(stage.layout.legs)]
        return ca.vertcat(*feet) - ca.vec(stage.standing_feet)

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """Zero."""
        return np.zeros(3 * layout.legs), np.zeros(3 * layout.legs)

    def violation(self, knots: Knots) -> Array:
        """|p_i - p_i*| at the two knots."""
        out = np.zeros(len(knots.time))
        ends = knots.flight.start, knots.flight.stop - 1
        for k, feet in zip(ends, (knots.task.start_feet, knots.task.goal_feet), strict=True):
            out[k] = np.abs(knots.foot_position[k] - feet).max()
        return out


class FrictionPyramid(Constraint):
    """|f_x| <= mu f_z, |f_y| <= mu f_z (section IV-D)."""

    name = "friction_pyramid"
    unit = "N"

    def applies(self, role: Role) -> bool:
        """In contact."""
        return role.in_contact

    def rows(self, stage: Stage) -> Any:
        """(4 C, 1), at most 0."""
        mu = stage.parameters["friction"]
        columns = []
        for fx, fy, fz in (ca.vertsplit(c) for c in ca.horzsplit(stage.force)):
            columns += [fx - mu * fz, -fx - mu * fz, fy - mu * fz, -fy - mu * fz]
        return ca.vertcat(*columns)

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """At most zero."""
        return np.full(4 * layout.contacts, -np.inf), np.zeros(4 * layout.contacts)

    def violation(self, knots: Knots) -> Array:
        """Tangential force beyond mu times the normal one."""
        f = knots.force
        mu = knots.task.limits.friction
        excess = np.abs(f[..., :2]) - mu * f[..., 2:]
        return _spread(knots, _everywhere(knots), excess)


class ContactForce(Constraint):
    """0 <= f_z <= f_max (section IV-D)."""

    name = "contact_force"
    unit = "N"

    def applies(self, role: Role) -> bool:
        """In contact."""
        return role.in_contact

    def rows(self, stage: Stage) -> Any:
        """(C, 1) in m g / C."""
        return stage.force[2, :].T

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """0 and f_max."""
        unit = task.mass * 9.81 / layout.contacts
        top = task.limits.contact_force / unit
        return np.zeros(layout.contacts), np.full(layout.contacts, top)

    def violation(self, knots: Knots) -> Array:
        """Pull on the ground, or force beyond f_max."""
        fz = knots.force[..., 2]
        excess = np.maximum(-fz, fz - knots.task.limits.contact_force)
        return _spread(knots, _everywhere(knots), excess)


class PhaseTimes(Constraint):
    """T_min <= T <= T_max for each phase (the paper bounds dt; flight collapses without it)."""

    name = "phase_times"
    unit = "s"

    def applies(self, role: Role) -> bool:
        """Where a duration is chosen: at the start, and at the end of take-off and flight."""
        starts = role.phase == Phase.TAKEOFF and role.first
        return starts or (role.last and role.phase != Phase.LANDING)

    def rows(self, stage: Stage) -> Any:
        """(1, 1) s."""
        return stage.symbols.get("next_duration", stage.symbols["duration"])

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """The robot file's [timing] of the phase that begins."""
        role = layout.roles[knot]
        name = Phase(role.phase + (0 if role.first else 1)).name.lower()
        low, high = getattr(task.timing, name)
        return np.array([low]), np.array([high])

    def violation(self, knots: Knots) -> Array:
        """Time too short or too long."""
        out = np.zeros(len(knots.time))
        for phase in Phase:
            low, high = getattr(knots.task.timing, phase.name.lower())
            T = knots.durations[phase]
            out[int(np.argmax(knots.phase == phase))] = max(low - T, T - high, 0.0)
        return out


class Reach(Constraint):
    """l_min <= |x_i| <= l_max from the hip, and a box about it in the hip's mirrored axes.

    The paper bounds the distance from the CoM (section IV-C), which excludes ANYmal's own default
    posture; what a leg reaches is centred at its hip.
    """

    name = "reach"
    unit = "m"

    def applies(self, role: Role) -> bool:
        """Wherever the posture is free."""
        return not role.terminal and not (role.phase == Phase.TAKEOFF and role.first)

    def rows(self, stage: Stage) -> Any:
        """(4 L, 1): |x_i|^2 and x_i."""
        columns = []
        for x in ca.horzsplit(stage.feet_in_hip):
            columns += [ca.sumsqr(x), x]
        return ca.vertcat(*columns)

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """The robot file's [reach]."""
        reach = task.reach
        lower = [reach.distance[0] ** 2, *reach.lower]
        upper = [reach.distance[1] ** 2, *reach.upper]
        return np.tile(lower, layout.legs), np.tile(upper, layout.legs)

    def violation(self, knots: Knots) -> Array:
        """Metres beyond the distance or the box."""
        reach, x = knots.task.reach, knots.feet_in_hip[1:-1]
        distance = np.linalg.norm(x, axis=-1, keepdims=True)
        beyond = np.concatenate(
            [
                reach.distance[0] - distance,
                distance - reach.distance[1],
                np.array(reach.lower) - x,
                x - np.array(reach.upper),
            ],
            axis=-1,
        )
        return _spread(knots, slice(1, len(knots.time) - 1), beyond)


def ground_line(task: Task, progress: Array) -> Array:
    """(K, L) m: height that feet must clear at `progress` (K,) of the flight.

    From the start to the target; a landing surface above the start is cleared as high as it is
    from half way on, so that no foot meets the edge of the box. The rise begins smoothly, as a
    foot's speed does (`SPEED_RAMP`).
    """
    s = np.asarray(progress)[:, None]
    start, goal = task.start_feet[:, 2], task.goal_feet[:, 2]
    straight = start * (1 - s) + goal * s
    u = np.minimum(1.0, 2 * s)
    early = start + (goal - start) * u**2 * (3 - 2 * u)
    return np.where(goal > start, early, straight)


class Clearance(Constraint):
    """p_z,i >= ground line + 4 s (1 - s) clearance over the flight."""

    name = "clearance"
    unit = "m"

    def applies(self, role: Role) -> bool:
        """Between lift-off and touchdown."""
        return role.phase == Phase.FLIGHT and not role.first

    def rows(self, stage: Stage) -> Any:
        """(L, 1) m."""
        up_base = stage.lift(stage.R_world_base[2, :].T)
        heights = [
            stage.position[2] + ca.dot(up_base, stage.foot_from_com(i))
            for i in range(stage.layout.legs)
        ]
        return ca.vertcat(*heights)

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """At least the line."""
        return self._line(task, layout.progress[knot : knot + 1])[0], np.full(layout.legs, np.inf)

    def violation(self, knots: Knots) -> Array:
        """Metres below the line."""
        inner = slice(knots.flight.start + 1, knots.flight.stop - 1)
        span = knots.flight.stop - knots.flight.start - 1
        line = self._line(knots.task, np.arange(1, span) / span)
        return _spread(knots, inner, line - knots.foot_position[inner][..., 2])

    @staticmethod
    def _line(task: Task, s: Array) -> Array:
        arch = 4 * s * (1 - s) * task.limits.clearance
        return ground_line(task, s) + arch[:, None]


class FeetApart(Constraint):
    """Any two feet stay apart seen from above the base."""

    name = "feet_apart"
    unit = "m"

    def applies(self, role: Role) -> bool:
        """Between lift-off and touchdown."""
        return role.phase == Phase.FLIGHT and not role.first

    def rows(self, stage: Stage) -> Any:
        """(L (L - 1) / 2, 1): squared distances, m2."""
        model = stage.model
        feet = [
            (ca.DM(h) + ca.DM(M) * x)[:2]
            for h, M, x in zip(
                model.hips, model.mirrors, ca.horzsplit(stage.feet_in_hip), strict=True
            )
        ]
        return ca.vertcat(*(ca.sumsqr(a - b) for a, b in combinations(feet, 2)))

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """At least the square of the distance."""
        pairs = layout.legs * (layout.legs - 1) // 2
        return np.full(pairs, task.limits.feet_apart**2), np.full(pairs, np.inf)

    def violation(self, knots: Knots) -> Array:
        """Metres too close."""
        inner = slice(knots.flight.start + 1, knots.flight.stop - 1)
        model = knots.model
        feet = (model.hips + model.mirrors * knots.feet_in_hip[inner])[..., :2]
        gaps = [
            np.linalg.norm(feet[:, i] - feet[:, j], axis=-1)
            for i, j in combinations(range(model.legs), 2)
        ]
        return _spread(knots, inner, knots.task.limits.feet_apart - np.stack(gaps, axis=1))


class FootSpeed(Constraint):
    """The feet's speed in the world along each base axis, rising from and falling to rest."""

    name = "foot_speed"
    unit = "m/s"

    def applies(self, role: Role) -> bool:
        """In flight."""
        return role.phase == Phase.FLIGHT

    def rows(self, stage: Stage) -> Any:
        """(3 L, 1) m/s."""
        return ca.vec(stage.foot_velocity_base)

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """Plus and minus the ramped limit at the interval's midpoint."""
        middle = layout.progress[knot] + 0.5 / layout.intervals.flight
        top = np.full(3 * layout.legs, self._limit(task, middle))
        return -top, top

    def violation(self, knots: Knots) -> Array:
        """Speed beyond the limit."""
        velocity = knots.foot_velocity_base
        middle = (np.arange(len(velocity)) + 0.5) / len(velocity)
        limit = np.array([self._limit(knots.task, s) for s in middle])
        where = slice(knots.flight.start, knots.flight.stop - 1)
        return _spread(knots, where, np.abs(velocity) - limit[:, None, None])

    @staticmethod
    def _limit(task: Task, s: float) -> float:
        return task.limits.foot_speed * min(1.0, SPEED_RAMP * s * (1 - s))


class FootSpeedInBase(Constraint):
    """|xdot_i| along each axis in flight: keeps the swing executable by the joints."""

    name = "foot_speed_in_base"
    unit = "m/s"

    def applies(self, role: Role) -> bool:
        """In flight."""
        return role.phase == Phase.FLIGHT

    def rows(self, stage: Stage) -> Any:
        """(3 L, 1) m/s."""
        return stage.symbols["feet_rate"]

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """Plus and minus the limit."""
        top = np.tile(task.limits.foot_speed_in_base, layout.legs)
        return -top, top

    def violation(self, knots: Knots) -> Array:
        """Speed beyond the limit."""
        excess = np.abs(knots.flight_feet_rate) - np.array(knots.task.limits.foot_speed_in_base)
        return _spread(knots, slice(knots.flight.start, knots.flight.stop - 1), excess)


class KneeSpeed(Constraint):
    """The knee's speed, from how fast the foot comes nearer to the hip or moves away.

    A leg of thigh a and shank b that is l long folds with l ldot = a b sin(theta) thetadot and
    a^2 b^2 sin^2(theta) = a^2 b^2 - ((a^2 + b^2 - l^2) / 2)^2, so that |thetadot| <= limit reads

        (x . xdot)^2 / limit^2 + ((a^2 + b^2 - |x|^2) / 2)^2 <= a^2 b^2,

    a polynomial, also where the leg is nearly straight. The knee is the fastest joint of a jump,
    and fastest at the end of the push-off and at the start of the landing: within the stance phases
    the rows, which are expensive there, are written for these two intervals alone. Legs that do
    not fold at a knee are left free.
    """

    name = "knee_speed"
    unit = "rad/s"

    def applies(self, role: Role) -> bool:
        """In flight, in the last interval before it and in the first one after it."""
        if role.phase == Phase.TAKEOFF:
            return role.last
        return role.phase == Phase.FLIGHT or role.first

    def rows(self, stage: Stage) -> Any:
        """(L, 1), left over right hand side."""
        x, xdot, _, _ = stage.feet_mid
        joint_speed, a, b = (stage.parameters[n] for n in ("joint_speed", "thigh", "shank"))
        limit = KNEE_SHARE * joint_speed
        columns = [
            (
                (ca.dot(x[:, i], xdot[:, i]) / limit) ** 2
                + ((a**2 + b**2 - ca.sumsqr(x[:, i])) / 2) ** 2
            )
            / (a * b) ** 2
            for i in range(stage.layout.legs)
        ]
        return ca.vertcat(*columns)

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """At most 1, if the leg has a knee."""
        top = np.inf if task.knee is None else 1.0
        return np.full(layout.legs, -np.inf), np.full(layout.legs, top)

    def violation(self, knots: Knots) -> Array:
        """Speed beyond the limit at the intervals' midpoints."""
        knee = knots.task.knee
        if knee is None:
            return np.zeros(len(knots.time))
        a, b = knee
        x, xdot = knots.feet_mid
        closing = np.abs(np.sum(x * xdot, axis=-1))
        lever = np.sqrt(
            np.maximum((a * b) ** 2 - ((a**2 + b**2 - np.sum(x * x, axis=-1)) / 2) ** 2, 1e-12)
        )
        excess = closing / lever - KNEE_SHARE * knots.task.limits.joint_speed
        where = slice(knots.flight.start - 1, knots.flight.stop)
        return _spread(knots, where, excess[where])


class FinalState(Constraint):
    """x[N] = x_fin: at rest at the target, CoM and attitude."""

    name = "final_state"
    unit = "m, rad, m/s, m2/s"
    equality = True

    def applies(self, role: Role) -> bool:
        """At the end."""
        return role.terminal

    def rows(self, stage: Stage) -> Any:
        """(12, 1): position, vector part of the attitude error, velocity, L / m."""
        w, xyz = stage.parameters["goal_quat"][0], stage.parameters["goal_quat"][1:]
        q = stage.quat
        turn = w * q[1:] - q[0] * xyz - ca.cross(xyz, q[1:])
        return ca.vertcat(
            stage.position - stage.parameters["goal_position"],
            turn,
            stage.velocity,
            stage.momentum,
        )

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """Zero."""
        return np.zeros(12), np.zeros(12)

    def violation(self, knots: Knots) -> Array:
        """The largest of the errors."""
        task = knots.task
        goal = Rotation.from_quat(task.goal_quat, scalar_first=True)
        turn = (goal.inv() * Rotation.from_matrix(knots.R_world_base[-1])).magnitude()
        errors = (
            knots.position[-1] - task.goal_position,
            knots.velocity[-1],
            knots.momentum[-1] / task.mass,
            turn,
        )
        out = np.zeros(len(knots.time))
        out[-1] = max(float(np.abs(e).max()) for e in errors)
        return out


CONSTRAINTS: tuple[Constraint, ...] = (
    MomentumBalance(),
    GivenContacts(),
    FrictionPyramid(),
    ContactForce(),
    PhaseTimes(),
    Reach(),
    Clearance(),
    FeetApart(),
    FootSpeed(),
    FootSpeedInBase(),
    KneeSpeed(),
    FinalState(),
)
