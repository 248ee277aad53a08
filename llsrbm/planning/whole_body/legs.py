"""Feet, shanks and knees in a pose, as expressions, and the rows that they keep to.

What touches are balls: that of a point foot, those at the corners of a sole. A foot that stands
does not slide, and its ball is as high as it stands; frames of point feet may be beside the middle
of their balls (ANYmal's by 23 mm), and are higher or lower as shanks lean.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import casadi as ca

from llsrbm.body.trunk_and_knees import knee_joint
from llsrbm.models.rigid_bodies import Mark, Moving, RigidBodies, cross
from llsrbm.planning.whole_body.interval import Pose
from llsrbm.robots.feet import foot_contacts

DRIFT = 10.0  # 1/s: by how much of it a standing foot's drift falls
TURN_UNIT = 5.0  # of rows of soles that turn
LANDING_UNIT = 0.1  # m, of rows of places and distances


@dataclass(frozen=True, eq=False)
class Leg:
    """A leg in a pose, world axes.

    Attributes:
        foot: (3,) m, of its frame; sole: (3, 3) its axes.
        velocity, omega: (3,) m/s, rad/s of the frame.
        balls: (3,) m each, their middles; rises: m/s, how fast they do.
        radius: m of the balls.
        knee_height: m; None: it has no knee.
        shank: (3,) m of the foot, and of the middle between it and the knee if there is one, base
            axes, from the base's origin.
    """

    foot: Any
    sole: Any
    velocity: Any
    omega: Any
    balls: list[Any]
    rises: list[Any]
    radius: float
    knee_height: Any
    shank: list[Any]


@dataclass(frozen=True, eq=False)
class Ground:
    """Place, heading and edge that a leg's foot is measured against.

    Attributes:
        place: (3,) m, where it stands, or will; heading: (2,) where a sole looks.
        towards: (2,) the direction across the edge that it crosses.
    """

    place: Any
    heading: Any
    towards: Any


def legs_of(bodies: RigidBodies, pose: Pose, mark: Mark) -> list[Leg]:
    """All legs in a pose."""
    R, robot = pose.R, bodies.robot
    base = mark(ca.mtimes(R.T, pose.velocity))
    feet = bodies.feet(pose.joint_position, pose.joint_velocity, pose.omega, base)
    joint, found = knee_joint(robot), []
    for leg, foot, contact in zip(robot.legs, feet, foot_contacts(robot), strict=True):
        at, velocity, up = mark(foot.position), mark(foot.velocity), R[2, :].T
        arms = [
            mark(ca.mtimes(foot.rotation, ca.DM(c))) if c.any() else ca.SX(3, 1)
            for c in contact.centres
        ]
        place = pose.position + ca.mtimes(R, at)
        knee = None if joint is None else mark(_joint(bodies, leg.joint_ids[joint], pose))
        found.append(
            Leg(
                foot=place,
                sole=ca.mtimes(R, foot.rotation),
                velocity=ca.mtimes(R, velocity),
                omega=ca.mtimes(R, foot.omega),
                balls=[place + ca.mtimes(R, arm) for arm in arms],
                rises=[ca.dot(up, velocity + cross(foot.omega, arm)) for arm in arms],
                radius=contact.radius,
                knee_height=None if knee is None else pose.position[2] + ca.dot(up, knee),
                shank=[at] if knee is None else [at, (at + knee) / 2],
            )
        )
    return found


def _joint(bodies: RigidBodies, joint: int, pose: Pose) -> Any:
    """(3,) m: where a joint is, base axes, from the base's origin."""
    zero = ca.SX.zeros(3)
    base = Moving(ca.SX.eye(3), zero, zero, zero)
    chain, joints = bodies.chain(joint), pose.joint_position
    *_, last = bodies.moving(chain, joints, ca.SX.zeros(joints.shape), base)
    return last.position


def off_place(leg: Leg, ground: Ground) -> list[Any]:
    """How far a foot is from where it stands, m, and by how much its sole leans or turns, rad."""
    off = leg.foot - ground.place
    if len(leg.balls) > 1:
        ahead, sole = ground.heading, leg.sole
        turns = sole[1, 0] * ahead[0] - sole[0, 0] * ahead[1]
        return [off, ca.vertcat(sole[2, 1], -sole[2, 0], turns)]
    height = leg.balls[0][2] - leg.radius - ground.place[2]
    return [ca.vertcat(off[0], off[1], height)]


def rest(leg: Leg, ground: Ground) -> Any:
    """Rows that are zero where a foot stands: its velocity makes up for what it has drifted."""
    off = off_place(leg, ground)
    if len(leg.balls) > 1:
        turn = (leg.omega + DRIFT * off[1]) / TURN_UNIT
        return ca.vertcat(leg.velocity + DRIFT * off[0], turn)
    velocity = ca.vertcat(leg.velocity[0], leg.velocity[1], leg.rises[0])
    return velocity + DRIFT * off[0]


def landing(leg: Leg, ground: Ground) -> Any:
    """Rows that are zero where a foot is at its place."""
    off = off_place(leg, ground)
    return ca.vertcat(off[0] / LANDING_UNIT, *off[1:])


def heights(leg: Leg) -> Any:
    """m: lowest points of a foot's balls; of a sole, its middle first."""
    lowest = [ball[2] - leg.radius for ball in leg.balls]
    return ca.vertcat(*([leg.foot[2]] if len(lowest) > 1 else []), *lowest)


def along(leg: Leg, ground: Ground) -> Any:
    """Places of a foot's balls across an edge, in units of rows."""
    seen = [ca.dot(ground.towards, ball[:2]) for ball in leg.balls]
    return ca.vertcat(*seen) / LANDING_UNIT


def knee_height(leg: Leg, ground: Ground) -> Any:
    """Height of a knee above its foot's ground, in units of rows."""
    return (leg.knee_height - ground.place[2]) / LANDING_UNIT


def squared_distances(one: Leg, other: Leg) -> list[Any]:
    """Squares of how far feet are apart, and middles of shanks, in units of rows."""
    pairs = zip(one.shank, other.shank, strict=True)
    return [ca.sumsqr((here - there) / LANDING_UNIT) for here, there in pairs]
