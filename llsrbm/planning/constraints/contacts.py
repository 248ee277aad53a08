"""Feet on the ground: where they stand and what they push with."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np

from llsrbm.motion.plan import Phase
from llsrbm.planning.constraints.base import Array, Bounds, Constraint, Limit, everywhere, spread
from llsrbm.planning.headings import across
from llsrbm.planning.layout import Layout, Role
from llsrbm.planning.stage import Stage
from llsrbm.robots.friction import INSCRIBED

if TYPE_CHECKING:
    from llsrbm.planning.knots import Knots
    from llsrbm.planning.task import Task


class GivenContacts(Constraint):
    """p_i = p_i* at lift-off and at touchdown: the feet leave where they stood, land on target.

    Soles look where they stood, or shall stand: n . R (cos phi, sin phi, 0) = 0 with n across it.
    """

    name = "given_contacts"
    unit = "m, rad"
    equality = True

    def applies(self, role: Role) -> bool:
        """At the first knots of flight and landing."""
        return role.first and role.phase != Phase.TAKEOFF

    def rows(self, stage: Stage) -> Any:
        """(d L, 1): p_i - p_i*, then the sines of what the headings miss."""
        r, R, legs = stage.position, stage.R_world_base, range(stage.layout.legs)
        feet = [r + ca.mtimes(R, stage.foot_from_com(i)) for i in legs]
        yaws = [stage.relative_yaw(i) for i in legs] if stage.layout.foot_coordinates > 3 else []
        misses = [
            ca.dot(across(R, psi)[:2], ca.vertcat(ca.cos(phi), ca.sin(phi)))
            for psi, phi in zip(ca.vertsplit(stage.standing_yaw), yaws, strict=False)
        ]
        return ca.vertcat(ca.vertcat(*feet) - ca.vec(stage.standing_feet), *misses)

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """Zero."""
        return (np.zeros(layout.foot_coordinates * layout.legs),) * 2

    def violation(self, knots: Knots) -> Array:
        """|p_i - p_i*| and what the headings miss, at the two knots."""
        out, task = np.zeros(len(knots.time)), knots.task
        for k, feet, yaw in (
            (0, task.start_feet, task.start_yaw),
            (-1, task.goal_feet, task.goal_yaw),
        ):
            place = np.abs(knots.flying_feet[k] - feet).max()
            heading = np.abs(np.sin(knots.flying_headings[k] - yaw)).max()
            out[knots.flight][k] = max(place, heading)
        return out


class FeetAtRest(Constraint):
    """The feet leave the ground and meet it at rest, also in how soles turn."""

    name = "feet_at_rest"
    unit = "m/s, rad/s"
    equality = True

    def applies(self, role: Role) -> bool:
        """At the first knots of flight and landing."""
        return role.first and role.phase != Phase.TAKEOFF

    def rows(self, stage: Stage) -> Any:
        """(d L, 1) velocities in base axes, then turning rates."""
        return ca.vertcat(ca.vec(stage.foot_velocity_at_knot), stage.foot_turn_at_knot)

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """Zero."""
        return (np.zeros(layout.foot_coordinates * layout.legs),) * 2

    def violation(self, knots: Knots) -> Array:
        """The largest speed along an axis, at the two knots."""
        out = np.zeros(len(knots.time))
        out[knots.flight][[0, -1]] = np.abs(knots.foot_velocity_at_rest).max(axis=(1, 2))
        return out


class FrictionPyramid(Constraint):
    """|f_x|, |f_y| <= mu / sqrt(2) f_z: the pyramid (section IV-D) inside the cone of friction mu.

    The paper's, with mu itself, reaches out of the cone by 41 % at its edges, where the ground does
    not hold. The cone as such, one curved row a contact, makes five times the iterations: forces
    fade to nothing at lift-off, which is its tip.
    """

    name = "friction_pyramid"
    unit = "N"
    limits = (
        Limit(
            "friction",
            "coefficient of friction",
            "1",
            "feet may push sideways harder for the load they carry",
            lowest=0.1,
            highest=1.5,
            place=("limits", "friction"),
        ),
    )

    def applies(self, role: Role) -> bool:
        """In contact."""
        return role.in_contact

    def rows(self, stage: Stage) -> Any:
        """(4 C, 1), at most 0."""
        mu = stage.parameters["friction"] * INSCRIBED
        columns = []
        for fx, fy, fz in (ca.vertsplit(c) for c in ca.horzsplit(stage.force)):
            columns += [fx - mu * fz, -fx - mu * fz, fy - mu * fz, -fy - mu * fz]
        return ca.vertcat(*columns)

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """At most zero."""
        return np.full(4 * layout.contacts, -np.inf), np.zeros(4 * layout.contacts)

    def violation(self, knots: Knots) -> Array:
        """Tangential force, along its larger component, beyond the pyramid's share."""
        f = knots.force
        excess = np.abs(f[..., :2]) - INSCRIBED * knots.task.limits.friction * f[..., 2:]
        return spread(knots, everywhere(knots), excess)
