"""Feet on the ground: where they stand and what they push with."""

from typing import Any

import casadi as ca
import numpy as np

from llsrbm.arrays import Array
from llsrbm.mechanics import GRAVITY, INSCRIBED
from llsrbm.planning.problem.constraints.base import Bounds, Constraint
from llsrbm.planning.problem.layout import Layout
from llsrbm.planning.problem.limit_table import limits_called
from llsrbm.planning.problem.roles import Role
from llsrbm.planning.problem.rotations import across, on_surface
from llsrbm.planning.problem.stage import Stage
from llsrbm.planning.problem.task import Task


class GivenContacts(Constraint):
    """p_i = p_i* at lift-off and at touchdown: the feet leave where they stood, land on target.

    Soles look where they stood, or shall stand: n . R (cos phi, sin phi, 0) = 0 with n across it.
    """

    name = "given_contacts"
    unit = "m, rad"
    equality = True

    def applies(self, role: Role) -> bool:
        """Where feet have just left the ground, or met it."""
        return bool(role.leaving or role.landing)

    def rows(self, stage: Stage) -> Any:
        """(d n, 1) of n feet: p_i - p_i*, then the sines of what the headings miss."""
        R, legs = stage.R_world_base, stage.edge_legs
        feet = [stage.foot_place(i) for i in legs]
        places = [stage.standing_feet[:, i] for i in legs]
        misses = []
        if stage.layout.foot_coordinates > 3:
            for i in legs:
                phi, psi = stage.relative_yaw(i), stage.standing_yaw[i]
                seen = ca.vertcat(ca.cos(phi), ca.sin(phi))
                misses.append(ca.dot(across(R, psi)[:2], seen))
        return ca.vertcat(ca.vertcat(*feet) - ca.vertcat(*places), *misses)

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        return (_edge_rows(layout, knot),) * 2


class FeetAtRest(Constraint):
    """The feet leave the ground and meet it at rest, also in how soles turn."""

    name = "feet_at_rest"
    unit = "m/s, rad/s"
    equality = True

    def applies(self, role: Role) -> bool:
        """Where feet have just left the ground, or met it."""
        return bool(role.leaving or role.landing)

    def rows(self, stage: Stage) -> Any:
        """(d n, 1) of n feet: velocities in base axes, then turning rates."""
        return ca.vertcat(ca.vec(stage.foot_velocity_at_knot), stage.foot_turn_at_knot)

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        return (_edge_rows(layout, knot),) * 2


class FrictionPyramid(Constraint):
    """|f_x|, |f_y| <= mu / sqrt(2) f_z: the pyramid (section IV-D) inside the cone of friction mu,
    in axes of the surface on which a foot stands.

    The paper's, with mu itself, reaches out of the cone by 41 % at its edges, where the ground does
    not hold. The cone as such, one curved row a contact, makes five times the iterations: forces
    fade to nothing at lift-off, which is its tip.
    """

    name = "friction_pyramid"
    unit = "N"
    limits = limits_called("friction")

    def applies(self, role: Role) -> bool:
        """In contact."""
        return role.in_contact

    def rows(self, stage: Stage) -> Any:
        """(4 standing contacts, 1), at most 0."""
        mu = stage.parameters["friction"] * INSCRIBED
        columns = []
        legs = np.array(stage.points) // stage.layout.corners
        for leg, force in zip(legs, ca.horzsplit(stage.force), strict=True):
            fx, fy, fz = ca.vertsplit(on_surface(stage.tilt[:, int(leg)]).T @ force)
            columns += [fx - mu * fz, -fx - mu * fz, fy - mu * fz, -fy - mu * fz]
        return ca.vertcat(*columns)

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """At most zero."""
        rows = 4 * layout.corners * len(layout.roles[knot].standing)
        return np.full(rows, -np.inf), np.zeros(rows)

    def measured(self, rows: Array, task: Task) -> Array:
        """N."""
        return rows * (task.mass * GRAVITY / (len(task.corners) * len(task.schedule.legs)))


def _edge_rows(layout: Layout, knot: int) -> Array:
    """Zeros, one for each coordinate of the feet that have just left or met the ground."""
    role = layout.roles[knot]
    return np.zeros(layout.foot_coordinates * len({*role.leaving, *role.landing}))
