"""Feet that swing, between the plan's knots."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline, make_interp_spline

from llsrbm.arrays import Array
from llsrbm.mechanics import yaw
from llsrbm.motion.plan import Plan

FootPath = Callable[[Array, int], Array]
"""Places (K, L, 3) at K times, or one of their derivatives by its order."""


@dataclass(frozen=True, eq=False)
class UnderWay:
    """Where a plan that was made under way begins: at one of its knots."""

    time: float  # s on the plan's clock
    foot_velocity_from_com: Array  # (L, 3) m/s, world axes
    foot_yaw_rate: Array  # (L,) rad/s


def swing_motion(
    plan: Plan, times: Array, knot: int, start: UnderWay | None
) -> tuple[tuple[Array, Array, Array], Array]:
    """Feet that swing: position relative to the CoM and two derivatives, (K, L, 3) each; headings.

    Cubic splines through the knots of each swing, from which feet leave and at which they meet the
    ground at rest; of a swing that is under way at `knot`, from there on as fast as its foot is.
    Outside of its swings the nearest end of one is held of a foot.
    """
    legs = plan.foot_position.shape[1]
    motion = np.zeros((3, len(times), legs, 3))
    heading = np.zeros((len(times), legs, 3))
    for swings, feet in _feet_by_swings(plan).items():
        ends = plan.time[np.array(swings)]
        between = (ends[:-1, 1] + ends[1:, 0]) / 2
        nearest = np.searchsorted(between, times, side="right")
        for k, (first, last) in enumerate(swings):
            rates = [np.tile(-plan.com_velocity[j], (len(feet), 1)) for j in (first, last)]
            turns = np.zeros((2, len(feet)))
            if start is not None and first < knot < last:
                first = knot
                rates[0], turns[0] = start.foot_velocity_from_com[feet], start.foot_yaw_rate[feet]
            knots, now = slice(first, last + 1), np.flatnonzero(nearest == k)
            relative = plan.foot_position[knots, feet] - plan.com[knots, None]
            under_way = start is not None and first == knot
            place = (_evenly_driven if under_way else _clamped)(plan.time[knots], relative, *rates)
            headings = np.stack([yaw(plan.foot_quat[knots, i]) for i in feet], axis=1)
            turn = CubicSpline(plan.time[knots], headings, bc_type=tuple((1, r) for r in turns))
            inside = np.clip(times[now], plan.time[first], plan.time[last])
            # A sample may be a fraction of a step before the knot where a plan begins under way.
            moving = ((inside == times[now]) | (under_way & (times[now] < inside)))[:, None]
            rows, columns = now[:, None], np.array(feet)
            for order in range(3):
                factor = moving if order else np.ones_like(moving)
                motion[order, rows, columns] = place(inside, order) * factor[:, :, None]
                heading[rows, columns, order] = turn(inside, order) * factor
    return (motion[0], motion[1], motion[2]), heading


def _clamped(time: Array, place: Array, first: Array, last: Array) -> FootPath:
    """A cubic spline through places (K, L, 3), of which ends have velocities (L, 3)."""
    return CubicSpline(time, place, bc_type=((1, first), (1, last)))


def _evenly_driven(time: Array, place: Array, first: Array, last: Array) -> FootPath:
    """Places (K, L, 3) at K knots as a motion whose accelerations are those of the plan.

    Velocities are straight from the first (L, 3) through those of the intervals, at their middles,
    to the last, as the planner has it when it bounds torques; a spline through the same knots takes
    twice the acceleration. The rest of the way to the last place comes in smoothly over all knots.
    """
    start, end = float(time[0]), float(time[-1])
    span = end - start
    middle = (time[1:] + time[:-1]) / 2
    mean = np.diff(place, axis=0) / np.diff(time)[:, None, None]
    rate = make_interp_spline(
        np.concatenate([[start], middle, [end]]), np.vstack([first[None], mean, last[None]]), k=1
    )
    way = rate.antiderivative()
    missing = place[-1] - place[0] - (way(end) - way(start))

    def motion(times: Array, order: int) -> Array:
        u = ((times - start) / span)[:, None, None]
        if order == 0:
            found = place[0] + way(times) - way(start) + u**2 * (3 - 2 * u) * missing
        elif order == 1:
            found = rate(times) + 6 * u * (1 - u) / span * missing
        else:
            found = rate(times, 1) + (6 - 12 * u) / span**2 * missing
        return np.asarray(found)

    return motion


def _feet_by_swings(plan: Plan) -> dict[tuple[tuple[int, int], ...], list[int]]:
    """Swings, as first and last knots, -> the feet that swing so."""
    groups: dict[tuple[tuple[int, int], ...], list[int]] = {}
    for foot, stands in enumerate(plan.contact.T):
        changes = np.flatnonzero(np.diff(stands)) + 1
        swings = tuple((int(a), int(b)) for a, b in changes.reshape(-1, 2))
        groups.setdefault(swings, []).append(foot)
    return groups
