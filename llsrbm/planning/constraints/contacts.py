"""Feet on the ground: where they stand and what they push with."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np

from llsrbm.planning.constraints.base import Array, Bounds, Constraint, Limit, everywhere, spread
from llsrbm.planning.headings import across
from llsrbm.planning.layout import Layout, Role
from llsrbm.planning.stage import GRAVITY, Stage
from llsrbm.trajectory.plan import Phase

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


class FrictionPyramid(Constraint):
    """|f_x| <= mu f_z, |f_y| <= mu f_z (section IV-D)."""

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
        return spread(knots, everywhere(knots), excess)


class ContactForce(Constraint):
    """0 <= f_z <= f_max (section IV-D)."""

    name = "contact_force"
    unit = "N"
    limits = (
        Limit(
            "contact_force",
            "largest force of a contact",
            "N",
            "contacts may push down harder: shorter, higher and wider jumps; more torque",
            lowest=0.25,
            highest=3.0,
            place=("limits", "contact_force"),
            relative=True,
        ),
    )

    def applies(self, role: Role) -> bool:
        """In contact."""
        return role.in_contact

    def rows(self, stage: Stage) -> Any:
        """(C, 1) in m g / C."""
        return stage.force[2, :].T

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """0 and f_max."""
        unit = task.mass * GRAVITY / layout.contacts
        top = task.limits.contact_force / unit
        return np.zeros(layout.contacts), np.full(layout.contacts, top)

    def violation(self, knots: Knots) -> Array:
        """Pull on the ground, or force beyond f_max."""
        fz = knots.force[..., 2]
        excess = np.maximum(-fz, fz - knots.task.limits.contact_force)
        return spread(knots, everywhere(knots), excess)
