"""Feedback of take-offs of bodies that turn over: towards where, and how far turned, they land.

Two feet in a line give two forces for three things, speeds forward and upward and the turn. Held to
all three of the plan at once, they hold the turn, and an error in speed grows as that of a pendulum
upside down does: eightfold in a push of 0.2 s. The landing place counts, so an early error may
cost momentum that is won back. With errors e = (dc, dv of the CoM, horizontal; dtheta of the base;
dL) of the plan, and changes df of the contact forces that leave their vertical sum as it is,

    dc' = dv,  dv' = sum df / m,  dtheta' = I^-1 (dL + L x dtheta),  dL' = F x dc + sum r x df,

with the plan's force F, arms r, inertia I and angular momentum L. A flight of time T from lift-off
lands dc + T dv away, and as far turned as dtheta' adds up to: a body that turns about its middle
axis of inertia, as in a flip, falls away from that axis, a degree of roll at lift-off being several
at touchdown. The gains K of df = K e that make the sum of the squares of those, of df and of e on
the way least, are found backwards from lift-off.
"""

import numpy as np
import pinocchio as pin

from llsrbm.arrays import Array
from llsrbm.control.reference import Target
from llsrbm.control.whole_body import WholeBody
from llsrbm.mechanics import GRAVITY
from llsrbm.motion.plan import Plan
from llsrbm.motion.sampling import sampled

# What costs as much as each other, at landing ...
PLACE = 0.02  # m
TURN = 0.05  # rad
# ... and over this long on the way, s: the errors, and of a contact's force that share of its own
# vertical force and of the weight. Tuned on Go2's front and back flips, seeds 12600 to 12739.
HELD = 0.1
AWAY, SPEED, TILT, TURNING = 0.1, 0.5, 0.1, 1.0  # m, m/s, rad, rad/s
FORCE, LEAST = 0.3, 0.02
STEP = 2e-3  # s, of flights
_UNLOADED = 1e-3  # N; contacts with no more do not push

_C, _V, _A, _L = slice(0, 2), slice(2, 4), slice(4, 7), slice(7, 10)  # places in e


class TakeOff:
    """Feedback of a plan's take-offs, by the controller's ticks."""

    def __init__(self, plan: Plan, mass: float, tick: float) -> None:
        """Find the gains; `mass`: kg of the robot; `tick`: s of the controller."""
        self._mass, self._tick = mass, tick
        # Tick -> horizontal acceleration of the CoM (2, 10) and rate of momentum (3, 10), of e.
        self._gains: dict[int, tuple[Array, Array]] = {}
        for flight in plan.schedule.flights:
            self._find(plan, flight)

    def corrected(self, target: Target, body: WholeBody, time: float) -> Target:
        """A target that the body is at already, with the rates that lead where it should land.

        `target`: the plan's at `time`, s. Heights are tracked as ever; before and after a take-off
        so is everything.
        """
        gains = self._gains.get(round(time / self._tick))
        if gains is None:
            return target
        error = np.concatenate(
            [
                (body.com - target.com)[:2],
                (body.com_velocity - target.com_velocity)[:2],
                pin.log3(body.R_world_base @ target.R_world_base.T),
                body.angular_momentum - target.angular_momentum,
            ]
        )
        acceleration, momentum_rate = (gain @ error for gain in gains)
        return target._replace(
            com=np.append(body.com[:2], target.com[2]),
            com_velocity=np.append(body.com_velocity[:2], target.com_velocity[2]),
            com_acceleration=target.com_acceleration + np.append(acceleration, 0.0),
            angular_momentum=np.array(body.angular_momentum),
            angular_momentum_rate=target.angular_momentum_rate + momentum_rate,
        )

    def _find(self, plan: Plan, flight: int) -> None:
        """The gains of the phases that stand before a flight, one of the schedule's phases."""
        first = flight
        while first > 0 and not plan.schedule[first - 1].is_flight:
            first -= 1
        begin, end = plan.phase_start[[first, flight]]
        dt = self._tick
        ticks = np.arange(round(begin / dt), int(end / dt))
        names = ("com", "contact_point", "contact_force", "inertia", "angular_momentum")
        at = sampled(plan, (ticks + 0.5) * dt, names)
        value = self._landing(plan, flight)
        for k in reversed(range(len(ticks))):
            force, inertia = at["contact_force"][k], at["inertia"][k]
            loaded = force[:, 2] > _UNLOADED
            arms = at["contact_point"][k, loaded] - at["com"][k]
            rates, pushes = self._rates(arms, force.sum(axis=0))
            rates[_A, _A], rates[_A, _L] = _turning(inertia, at["angular_momentum"][k])
            A, B = np.eye(len(rates)) + dt * rates, dt * pushes
            R = self._force_costs(force[loaded]) * dt / HELD
            Q = self._error_costs(inertia) * dt / HELD
            K = -np.linalg.solve(R + B.T @ value @ B, B.T @ value @ A)
            closed = A + B @ K
            value = Q + K.T @ R @ K + closed.T @ value @ closed
            steered = rates + pushes @ K
            self._gains[int(ticks[k])] = steered[_V], steered[_L]

    def _rates(self, arms: Array, force: Array) -> tuple[Array, Array]:
        """e' = rates e + pushes df: (10, 10), (10, 3 C), of C contacts that push; no turning."""
        contacts = len(arms)
        rates, pushes = np.zeros((10, 10)), np.zeros((10, contacts, 3))
        rates[_C, _V] = np.eye(2)
        rates[_L, _C] = pin.skew(force)[:, :2]
        pushes[_V] = np.eye(2, 3)[:, None] / self._mass
        pushes[_L] = np.stack([pin.skew(arm) for arm in arms], axis=1)
        pushes[..., 2] -= pushes[..., 2].mean(axis=1, keepdims=True)  # their sum stays
        return rates, pushes.reshape(10, -1)

    def _force_costs(self, force: Array) -> Array:
        """(3 C, 3 C) 1/N2 of changes to forces (C, 3)."""
        scale = FORCE * force[:, 2] + LEAST * self._mass * GRAVITY
        return np.diag(scale.repeat(3) ** -2)

    @staticmethod
    def _error_costs(inertia: Array) -> Array:
        """(10, 10) of errors on the way."""
        Q = np.diag(np.repeat([AWAY, SPEED, TILT, 1.0], [2, 2, 3, 3]) ** -2.0)
        turning = np.linalg.inv(inertia) / TURNING
        Q[_L, _L] = turning.T @ turning
        return Q

    @staticmethod
    def _landing(plan: Plan, flight: int) -> Array:
        """(10, 10) of errors at lift-off, by where and how it lands with them."""
        begin, end = plan.phase_start[[flight, flight + 1]]
        place, turn = np.zeros((2, 10)), np.zeros((3, 10))
        place[:, _C], place[:, _V] = np.eye(2), (end - begin) * np.eye(2)
        turn[:, _A], turn[:, _L] = turn_in_flight(plan, flight)
        rows = np.vstack([place / PLACE, turn / TURN])
        return rows.T @ rows


def turn_in_flight(plan: Plan, flight: int) -> tuple[Array, Array]:
    """How far off the base is turned at the end of a flight, by errors as it begins.

    Legs and arms move as planned beside the base.

    Args:
        plan: what is flown.
        flight: that phase of its schedule.

    Returns:
        (3, 3) by the base's turn, rad, and (3, 3) rad / (kg m2/s) by the angular momentum; world
        frame.
    """
    begin, end = plan.phase_start[[flight, flight + 1]]
    steps = max(1, round((end - begin) / STEP))
    dt = (end - begin) / steps
    at = sampled(plan, begin + (np.arange(steps) + 0.5) * dt, ("inertia", "angular_momentum"))
    by_turn, by_momentum = np.eye(3), np.zeros((3, 3))
    for inertia, momentum in zip(at["inertia"], at["angular_momentum"], strict=True):
        turning, driven = _turning(inertia, momentum)
        half = np.eye(3) + dt / 2 * turning  # to second order in dt
        by_turn = by_turn + dt * turning @ half @ by_turn
        by_momentum = by_momentum + dt * half @ (driven + turning @ by_momentum)
    return by_turn, by_momentum


def _turning(inertia: Array, momentum: Array) -> tuple[Array, Array]:
    """dtheta' by dtheta and by dL: (3, 3) 1/s, (3, 3) 1/(kg m2)."""
    inverse = np.asarray(np.linalg.inv(inertia), dtype=np.float64)
    return inverse @ pin.skew(momentum), inverse
