"""A plan's forces and feet through the model's continuous equations: an integrator of its own.

    rdot = v,  v' = sum f / m + g,  L' = sum (c_j - r) x f_j,  q' = q (0, omega) / 2,
    I(x) omega + h(x, xdot) + correction = R^T L

Feet that stand rest in the world, so that their x and xdot follow from r, v, R and omega; xdot is
affine in omega, and so is the left side. Of feet that swing x runs linearly between the plan's
knots, also where others stand. The correction, constant over an interval, is what the model was
found to lack (`Task.correction`); most plans have none. Forces act at the contact points. How
standing soles turn against the base is found by differences.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from tests.llsrbm.models.postures import evaluate_momentum, feet_of, feet_rate_of

GRAVITY = np.array([0.0, 0.0, -9.81])
PROBES = np.vstack([np.zeros(3), np.eye(3)])


@dataclass
class State:
    position: np.ndarray
    velocity: np.ndarray
    quat: np.ndarray
    momentum: np.ndarray

    def plus(self, rate: State, dt: float) -> State:
        return State(
            self.position + dt * rate.position,
            self.velocity + dt * rate.velocity,
            self.quat + dt * rate.quat,
            self.momentum + dt * rate.momentum,
        )


def replay(plan, model, step: float = 1e-3, correction=None) -> list[State]:
    """The state at every knot, from the plan's first knot on; correction: (N, 3) kg m2/s."""
    if correction is None:
        correction = np.zeros((len(plan.time) - 1, 3))
    state = State(plan.com[0], plan.com_velocity[0], plan.base_quat[0], plan.angular_momentum[0])
    states = [state]
    for k, (start, end) in enumerate(zip(plan.time[:-1], plan.time[1:], strict=True)):
        count = int(np.ceil((end - start) / step))
        dt = (end - start) / count
        for i in range(count):
            t = i * dt

            def rate(s, t):
                return _rate(plan, model, k, t / (end - start), s, correction[k])  # noqa: B023

            k1 = rate(state, t)
            k2 = rate(state.plus(k1, dt / 2), t + dt / 2)
            k3 = rate(state.plus(k2, dt / 2), t + dt / 2)
            k4 = rate(state.plus(k3, dt), t + dt)
            for weight, slope in ((1, k1), (2, k2), (2, k3), (1, k4)):
                state = state.plus(slope, weight * dt / 6)
        states.append(state)
    return states


def _rate(plan, model, k, share, s, correction):
    force = plan.contact_force[k]
    R = Rotation.from_quat(s.quat, scalar_first=True).as_matrix()
    standing = plan.contact[k]
    before, after = plan.foot_in_hip[k], plan.foot_in_hip[k + 1]
    given = before + share * (after - before)
    rate = np.repeat([(after - before) / (plan.time[k + 1] - plan.time[k])], 4, axis=0)
    if standing.any():
        beta, turning = _seen(plan, model, k, R, s)
        given[standing], rate[:, standing] = beta[standing], turning[:, standing]
    x = feet_of(model, given[None], standing)
    xdot = feet_rate_of(model, rate, standing)
    left = evaluate_momentum(model, np.repeat(x, 4, axis=0), xdot, PROBES)
    turning = s.momentum @ R - correction - left[0]
    omega = np.linalg.solve((left[1:] - left[0]).T, turning)
    w, v = s.quat[0], s.quat[1:]
    return State(
        position=s.velocity,
        velocity=force.sum(axis=0) / model.mass + GRAVITY,
        quat=np.append(-v @ omega, w * omega + np.cross(v, omega)) / 2,
        momentum=np.cross(_over(plan, plan.contact_point, k) - s.position, force).sum(axis=0),
    )


def _over(plan, places, k):
    """Where feet (K, n, 3) stand over an interval: they roll on, but where some leave or land."""
    changes = (plan.contact[k] != plan.contact[max(k - 1, 0)]).any()
    return places[k] if changes else (places[k] + places[k + 1]) / 2


def _seen(plan, model, k, R, s):
    """Standing feet from the CoM, (L, d), and their rates, (4, L, d), at the `PROBES`."""
    lift = np.array([0, 0, model.foot_lift])
    beta = (_over(plan, plan.foot_position, k) + lift - s.position) @ R
    rate = -s.velocity @ R - np.cross(PROBES[:, None], beta)
    if model.coordinates == 3:
        return beta, rate
    step = 1e-6
    ends = [
        [_yaws(R @ Rotation.from_rotvec(h * w).as_matrix(), plan, k) for w in PROBES]
        for h in (-step, step)
    ]
    turn = np.subtract(*ends[::-1]) / (2 * step)
    return (
        np.concatenate([beta, _yaws(R, plan, k)[:, None]], axis=-1),
        np.concatenate([rate, turn[..., None]], axis=-1),
    )


def _yaws(R, plan, k):
    """Turns about the base's z that put its x above where the soles look, (L,) rad."""
    ahead = Rotation.from_quat(plan.foot_quat[k], scalar_first=True).as_matrix()[:, :, 0]
    # Of the plane of base x and y, the direction that is above `ahead`: up cross (ahead cross z).
    aside = np.cross([0.0, 0.0, 1.0], ahead)
    seen = np.cross(aside, R[:, 2]) @ R
    return np.arctan2(seen[:, 1], seen[:, 0])


def angle_between(a, b) -> float:
    """Degrees between two attitudes, quaternions w, x, y, z."""
    one, two = (Rotation.from_quat(q, scalar_first=True) for q in (a, b))
    return float(np.degrees((one.inv() * two).magnitude()))
