"""Feet on the ground: where they stand and what they push with."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from llsrbm.planning.constraints.base import Array, Bounds, Constraint, everywhere, spread
from llsrbm.planning.knots import Knots
from llsrbm.planning.layout import Layout, Role
from llsrbm.planning.stage import GRAVITY, Stage
from llsrbm.planning.task import Task
from llsrbm.trajectory.plan import Phase


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
        out[knots.flight.start] = np.abs(knots.flying_feet[0] - knots.task.start_feet).max()
        out[knots.flight.stop - 1] = np.abs(knots.flying_feet[-1] - knots.task.goal_feet).max()
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
        return spread(knots, everywhere(knots), excess)


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
        unit = task.mass * GRAVITY / layout.contacts
        top = task.limits.contact_force / unit
        return np.zeros(layout.contacts), np.full(layout.contacts, top)

    def violation(self, knots: Knots) -> Array:
        """Pull on the ground, or force beyond f_max."""
        fz = knots.force[..., 2]
        excess = np.maximum(-fz, fz - knots.task.limits.contact_force)
        return spread(knots, everywhere(knots), excess)
