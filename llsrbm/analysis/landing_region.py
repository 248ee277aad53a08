"""Landing regions of a robot in flight: places that its feet still reach in time.

In flight nothing but gravity moves the CoM, so that it is known where it will be at touchdown. The
posture there is the newest plan's: its attitude, and how the trunk lies about the CoM.
About each hip the plan's own reach (`llsrbm.robots.schema.Reach`) cuts a region out of the ground;
what a foot cannot get to in the time that is left, at the plan's fastest, is not part of it. The
region shrinks as the robot falls, until it is the place where the foot is. The shortest length of a
leg is left out, so that regions are convex.
"""

from dataclasses import dataclass

import numpy as np

from llsrbm.arrays import Array
from llsrbm.mechanics import rotation_matrices
from llsrbm.motion.plan import Plan
from llsrbm.motion.replan import followed
from llsrbm.motion.rollout import Rollout
from llsrbm.robots import Robot
from llsrbm.robots.schema import Reach

SIDES = 20
"""Corners of a region's outline, in evenly spaced directions from a point inside."""

_SEARCH = 15  # places along each axis at which a point inside is looked for


@dataclass(frozen=True, eq=False)
class Touchdown:
    """The next touchdown, as expected."""

    time: float  # s
    base_position: Array  # (3,) m
    base_quat: Array  # (4,) w, x, y, z: of the root link
    ground: Array  # (L,) m, height of the ground under each foot


def expected_touchdown(rollout: Rollout, plan: Plan, robot: Robot, time: float) -> Touchdown | None:
    """The touchdown that a robot in flight falls towards; None: it is not in flight.

    `plan`: that the simulation began with; `robot`: as it is believed to be; `time`: s.
    """
    tick = int(np.searchsorted(rollout.time, time - 1e-9).clip(0, len(rollout.time) - 1))
    landings = [float(plan.phase_start[p + 1]) for p in plan.schedule.flights]
    if rollout.contact[tick].any() or time < plan.phase_start[plan.schedule.flights[0]]:
        return None
    landing = next((end for end in landings if end > time), None)
    if landing is None:
        return None
    knot = int(np.searchsorted(plan.time, landing - 1e-9).clip(0, len(plan.time) - 1))
    quat, when, feet = plan.base_quat[knot], landing, plan.foot_position[knot]
    newest = followed(rollout.replans, time)
    if newest is not None and newest.touchdown > time:
        when = newest.touchdown
        at = int(np.searchsorted(newest.time, when - 1e-9).clip(0, len(newest.time) - 1))
        quat, feet = newest.base_quat[at], newest.foot_position[at]
    velocity = rollout.linear_momentum[tick] / rollout.disturbance.mass(robot)
    left = when - time
    com = rollout.com[tick] + left * velocity + left**2 / 2 * robot.model.gravity.linear
    planned, turned = rotation_matrices(np.stack([plan.base_quat[knot], quat]))
    arm = planned.T @ (plan.com[knot] - plan.base_position[knot])
    return Touchdown(when, com - turned @ arm, quat, feet[:, 2])


def landing_regions(
    robot: Robot, reach: Reach, speed: float, touchdown: Touchdown, feet: Array, time: float
) -> tuple[Array | None, ...]:
    """The outline of each foot's region on the ground, (SIDES, 3) m; None: it cannot land.

    `reach`: where feet may be about their hips; `speed`: largest of a foot over the ground, m/s;
    `feet`: (L, 3) m, world frame, where they are at `time`, s.
    """
    R = rotation_matrices(touchdown.base_quat[None])[0]
    hips = touchdown.base_position + robot.hips @ R.T
    radius = speed * max(0.0, touchdown.time - time)
    return tuple(
        _outline(R, mirror, hip, reach, foot, radius, float(ground), robot.foot_lift)
        for mirror, hip, foot, ground in zip(
            robot.mirrors, hips, feet, touchdown.ground, strict=True
        )
    )


def _outline(
    R: Array,
    mirror: Array,
    hip: Array,
    reach: Reach,
    foot: Array,
    radius: float,
    ground: float,
    lift: float,
) -> Array | None:
    hip = hip - [0.0, 0.0, lift]  # reach is of the feet's frames
    # Points p on the ground: each face of the reach's box says normal @ p <= bound.
    normals = np.concatenate([(mirror * R[:2]).T, -(mirror * R[:2]).T])
    beside = mirror * (R[2] * (ground - hip[2])) - (mirror * R[:2]).T @ hip[:2]
    bounds = np.concatenate([reach.upper - beside, beside - reach.lower])
    drop = reach.distance[1] ** 2 - (ground - hip[2]) ** 2
    if drop <= 0:
        return None
    discs = ((hip[:2], float(np.sqrt(drop))), (foot[:2], radius))
    inside = _inside(normals, bounds, discs)
    if inside is None:
        return None
    angle = np.linspace(0, 2 * np.pi, SIDES, endpoint=False)
    ray = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    towards, room = ray @ normals.T, bounds - normals @ inside
    with np.errstate(divide="ignore", invalid="ignore"):
        far = np.where(towards > 1e-12, room / towards, np.inf).min(axis=1)
    for centre, size in discs:
        # |inside + t ray - centre| = size, a quadratic equation in t.
        b = ray @ (inside - centre)
        gap = np.sum((inside - centre) ** 2) - size**2
        far = np.minimum(far, -b + np.sqrt(np.maximum(b * b - gap, 0.0)))
    points = inside + far[:, None] * ray
    return np.column_stack([points, np.full(SIDES, ground)])


def _inside(normals: Array, bounds: Array, discs: tuple[tuple[Array, float], ...]) -> Array | None:
    """A point well inside of all half-planes and discs; None: there is none."""
    centre, size = min(discs, key=lambda disc: disc[1])
    side = np.linspace(-size, size, _SEARCH)
    grid = centre + np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    room = [(bounds - grid @ normals.T).min(axis=1)]
    room += [size - np.linalg.norm(grid - centre, axis=1) for centre, size in discs]
    least = np.min(room, axis=0)
    best = int(least.argmax())
    return grid[best] if least[best] > 0 else None
