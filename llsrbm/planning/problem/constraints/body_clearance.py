"""Trunk, knees and feet pass over what lies between start and landing, and keep off the ground."""

from typing import Any

import casadi as ca
import numpy as np
import pinocchio as pin

from llsrbm.arrays import Array
from llsrbm.body.trunk_and_knees import knee_joint, trunk_box
from llsrbm.planning.problem.clearance_profile import (
    SHINS,
    foot_radius,
    profile,
    sides,
    trunk_points,
)
from llsrbm.planning.problem.constraints.base import Bounds, Constraint, spread
from llsrbm.planning.problem.knots import Knots
from llsrbm.planning.problem.layout import Layout
from llsrbm.planning.problem.limit_table import limits_called
from llsrbm.planning.problem.roles import Role
from llsrbm.planning.problem.stage import Stage
from llsrbm.planning.problem.task import Task

# What of the margin the check gives away, m: feet cut the corners of ramps between knots, and the
# model puts hips and knees a few millimetres off.
ALLOWANCE = 0.03
# The same for models that are there for comparison: they put the hips a centimetre or two off.
COMPARED_ALLOWANCE = 0.05
# Flips have no rows for it. So far, m, the box that encloses the trunk may be in the ground: Go2's
# front flips off 40 cm, 6 mm, land, and off 45 cm, 18 mm, their nose hits the box they stand on.
ENCLOSED = 0.01
_BETWEEN = 4  # parts of an interval that are looked at; bodies move up to 5 cm in one
_ALONG = 13  # places along the trunk that are looked at, 5 cm apart or less
_DOWN = (0.2, 0.4, 0.6, 0.8)  # places from knee to foot that are looked at


class BodyClearance(Constraint):
    """z >= profile(x) + margin, of points of the whole body over the smooth profile.

    The points are the corners of three cross-sections of the trunk's box and the knees, wherever
    they are, two points of each shin, and feet in the air; these two keep the margin over the
    obstacle alone, because feet come from the ground. Feet move up to 10 cm in an interval, so
    theirs are met in its middle, too. The check knows no profile: the whole body in the postures
    that realise the plan, by Pinocchio, must not come near the obstacle itself, nor trunk and knees
    near the ground.
    """

    name = "body_clearance"
    unit = "m"
    limits = limits_called("body_margin")

    def concerns(self, task: Task) -> bool:
        """True if there is something to clear."""
        return task.clears

    def checked(self, task: Task) -> bool:
        return task.clears or (bool(task.jump.turns) and task.agrees)

    def applies(self, role: Role) -> bool:
        """At all knots but the first and the last, whose postures are given."""
        return role.clears

    def rows(self, stage: Stage) -> Any:
        """(points, 1) m above the profile: the trunk's, knees, shins, feet, and these half way."""
        of, model = stage.parameters, stage.model
        edges, heights, room = of["obstacle"], of["obstacle_heights"], of["obstacle_room"]
        margin = of["body_margin"]
        # For shins and feet, which keep the margin over the obstacle alone.
        raised = ca.vertcat(heights[0], heights[1] + margin, heights[2])
        ahead, up = (stage.lift(stage.R_world_base[i, :].T) for i in (0, 2))

        def above(point: Any, heights: Any, room: Any) -> Any:
            """Height of a point seen from the CoM, (3, 1) m, base axes."""
            x, z = stage.position[0] + ca.dot(ahead, point), stage.position[2] + ca.dot(up, point)
            return z - profile(x, edges, heights, room)

        def above_between(point: Any) -> Any:
            """The same of a foot at the interval's midpoint."""
            R, r = stage.R_world_base_mid, stage.position_mid
            x, z = (r[i] + ca.dot(R[i, :].T, point) for i in (0, 2))
            return z - model.foot_lift - profile(x, edges, raised, room[2])

        rows = [
            above(stage.offset + ca.vertcat(*point), heights, room[0]) - margin
            for point in trunk_points(of["trunk"])
        ]
        for i, leg in enumerate(model.drives.legs):
            knee = leg.knee(stage.feet_in_hip[:, i])
            if knee is not None:
                seen = stage.offset + ca.DM(model.hips[i]) + stage.lift(knee)
                rows.append(above(seen, heights, room[1]) - margin)
                down = stage.foot_from_com(i) - seen
                rows += [above(seen + share * down, raised, room[1]) for share in SHINS]
        rows += [
            above(stage.foot_from_com(i), raised, room[2]) - model.foot_lift
            for i in stage.role.flying
        ]
        place, _, offset, _ = stage.feet_mid
        rows += [
            above_between(model.foot_from_com(i, place[:, i], offset)) for i in stage.role.swinging
        ]
        return ca.vertcat(*rows)

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """At least nothing."""
        knees = 0 if knee_joint(task.robot) is None else layout.legs
        trunk = len(trunk_points(trunk_box(task.robot).ravel()))
        role = layout.roles[knot]
        rows = trunk + (1 + len(SHINS)) * knees + len(role.flying) + len(role.swinging)
        return np.zeros(rows), np.full(rows, np.inf)

    def violation(self, knots: Knots) -> Array:
        """Metres too low, of what is checked, at knots and between them."""
        task = knots.task
        if not self.checked(task):
            return np.zeros(len(knots.time))
        allowance = ALLOWANCE if knots.model.is_true else COMPARED_ALLOWANCE
        margin = max(task.body_margin - allowance, 0.0) if task.clears else -ENCLOSED
        trunk, knees, shins = body_points(knots)
        body = np.concatenate([trunk, knees], axis=1)
        legs = np.concatenate([body, shins], axis=1)
        feet = _distance(task, knots.contact_point, foot_radius(task))
        kept = np.concatenate([_distance(task, legs, 0.0), -_depth(knots, body), feet], axis=1)
        amounts = margin - kept
        amounts[[0, -1]] = 0.0  # the postures there are given
        return spread(knots, amounts)


def body_points(knots: Knots) -> tuple[Array, Array, Array]:
    """Places along the trunk's edges (N+1, n, 3) m, of knees (N+1, k, 3) m, and along shins.

    By Pinocchio, in the postures that realise the plan; world frame.
    """
    robot, postures = knots.task.robot, knots.postures
    box, joint = trunk_box(robot), knee_joint(robot)
    along = np.linspace(box[0, 0], box[1, 0], _ALONG)
    corners = np.array([(x, y, z) for x in along for y in box[:, 1] for z in box[:, 2]])
    data = robot.model.createData()
    trunk, knees, shins = [], [], []
    for k, angles in enumerate(postures.joint_position):
        base = np.concatenate([postures.base_position[k], np.roll(knots.quat[k], -1)])
        pin.framesForwardKinematics(robot.model, data, np.concatenate([base, angles]))
        placement = data.oMi[1]
        trunk.append(corners @ placement.rotation.T + placement.translation)
        knee, foot = np.zeros((2, 0, 3))
        if joint is not None:
            knee = np.array([data.oMi[leg.joint_ids[joint]].translation for leg in robot.legs])
            foot = np.array([data.oMf[leg.foot_frame_id].translation for leg in robot.legs])
        knees.append(knee)
        shins.append(np.concatenate([knee + share * (foot - knee) for share in _DOWN]))
    return np.array(trunk), np.array(knees), np.array(shins)


def _depth(knots: Knots, points: Array) -> Array:
    """(N+1, n) m: how far points (N+1, n, 3) are below the ground."""
    task = knots.task
    before, beyond = sides(task)
    obstacle = task.obstacle
    middle = np.inf if obstacle is None else (obstacle.near + obstacle.far) / 2
    up = np.array([_step_up(task, int(phase)) for phase in knots.phase])
    return np.where(points[..., 0] < middle, before, beyond) + up[:, None] - points[..., 2]


def _step_up(task: Task, phase: int) -> float:
    """m: what feet stand on in a phase, above the lowest ground: a block is as large as the trunk.

    Nothing in flight, nor beside an obstacle, of which `sides` knows the ground.
    """
    if task.obstacle is not None or task.schedule[phase].is_flight:
        return 0.0
    return task.places[task.schedule[phase].place].height - sides(task)[0]


def _distance(task: Task, points: Array, radius: float) -> Array:
    """(N+1, n) m: of balls that touch points (N+1, n, 3) from above to the obstacle.

    Negative inside; infinite without an obstacle. A gap counts as filled up to its higher edge.
    Between knots along straight lines, which lie below what flies; counted at the knot before.
    """
    out = np.full(points.shape[:2], np.inf)
    obstacle = task.obstacle
    if obstacle is None:
        return out
    top = max(obstacle.height, *sides(task))
    following = np.concatenate([points[1:], points[-1:]])
    for share in np.arange(_BETWEEN) / _BETWEEN:
        at = (1 - share) * points + share * following
        beside = np.maximum(obstacle.near - at[..., 0], at[..., 0] - obstacle.far)
        above = at[..., 2] + radius - top
        inside = np.maximum(beside, above)
        outside = np.hypot(np.maximum(beside, 0.0), np.maximum(above, 0.0))
        out = np.minimum(out, np.where(inside < 0, inside, outside) - radius)
    return out
