"""Feet, shanks and knees in a pose, as expressions, and the rows that they keep to.

What touches are balls: that of a point foot, those at the corners of a sole. A foot that stands
does not slide, and its ball is as high as it stands. A point foot's rolls as its shank turns, by 2
cm as a Go2 crouches; its frame may be beside the middle of the ball (ANYmal's by 23 mm), and is
higher or lower as the shank leans.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import casadi as ca

from llsrbm.planning.whole_body.chain import split
from llsrbm.planning.whole_body.leg_pose import pose_outputs
from llsrbm.planning.whole_body.limbs import LimbKind

DRIFT = 10.0  # 1/s: by how much of it a standing foot's drift falls
TURN_UNIT = 5.0  # of rows of soles that turn
LANDING_UNIT = 0.1  # m, of rows of places and distances


@dataclass(frozen=True, eq=False)
class Leg:
    """A leg in a pose, world axes.

    Attributes:
        foot: (3,) m, of its frame; sole: (3, 3) its axes; None of a ball.
        velocity, omega: (3,) m/s, rad/s of a sole's frame; slides: (3,) m/s, of the point by which
            a point foot's ball touches.
        balls: (3,) m each, their middles.
        radius: m of the balls.
        knee: (3,) m; empty if it has none.
        shank: (3,) m of the foot, and of the middle between it and the knee if there is one, base
            axes, from the base's origin.
    """

    foot: Any
    velocity: Any
    sole: Any
    omega: Any
    slides: Any
    balls: list[Any]
    radius: Any
    knee: Any
    shank: list[Any]

    @classmethod
    def of(cls, kind: LimbKind, pose: Any, radius: Any) -> Leg:
        """A leg by the outputs of `leg_pose`, with the radius of its balls, m."""
        at = split(pose, pose_outputs(kind))
        soles = kind.corners > 1
        return cls(
            foot=at["foot"],
            velocity=at["velocity"] if soles else None,
            sole=ca.reshape(at["sole"], 3, 3) if soles else None,
            omega=at["omega"] if soles else None,
            slides=None if soles else at["slides"],
            balls=ca.vertsplit(at["balls"], 3),
            radius=radius,
            knee=at["knee"],
            shank=ca.vertsplit(at["shank"], 3),
        )


@dataclass(frozen=True, eq=False)
class Ground:
    """Place, heading and edge that a leg's foot is measured against.

    Attributes:
        place: (3,) m, where it stands, or will; heading: (2,) where a sole looks.
        axes: (3, 3) of the surface there, its normal last; tilt: (2,) how it rises along x and y.
        towards: (2,) the direction across the edge that it crosses.
    """

    place: Any
    heading: Any
    axes: Any
    tilt: Any
    towards: Any

    def height(self, point: Any) -> Any:
        """m: of a point, less what the surface rises from the place to below it."""
        return point[2] - ca.dot(self.tilt, point[:2] - self.place[:2])


def off_place(leg: Leg, ground: Ground) -> list[Any]:
    """How far a foot is from where it stands, m, and by how much its sole leans or turns, rad."""
    off = leg.foot - ground.place
    if len(leg.balls) > 1:
        ahead, sole = ground.heading, leg.sole
        turns = sole[1, 0] * ahead[0] - sole[0, 0] * ahead[1]
        leans = [ca.dot(ground.axes[:, 2], sole[:, i]) for i in range(2)]
        return [off, ca.vertcat(leans[1], -leans[0], turns)]
    above = ca.dot(ground.axes[:, 2], leg.balls[0] - ground.place) - leg.radius
    return [ca.vertcat(off[0], off[1], above)]


def rest(leg: Leg, ground: Ground) -> Any:
    """Rows that are zero where a foot stands: its velocity makes up for what it has drifted.

    A ball rolls where its shank turns it, and is not called back.
    """
    off = off_place(leg, ground)
    if len(leg.balls) > 1:
        turn = (leg.omega + DRIFT * off[1]) / TURN_UNIT
        return ca.vertcat(leg.velocity + DRIFT * off[0], turn)
    return ca.mtimes(ground.axes.T, leg.slides) + ca.vertcat(0, 0, DRIFT * off[0][2])


def landing(leg: Leg, ground: Ground) -> Any:
    """Rows that are zero where a foot is at its place."""
    off = off_place(leg, ground)
    return ca.vertcat(off[0] / LANDING_UNIT, *off[1:])


def heights(leg: Leg, ground: Ground) -> Any:
    """m: lowest points of a foot's balls, as `Ground.height`; of a sole, its middle first."""
    # From a slope a ball is as far as its middle is above it by more than this.
    radius = leg.radius / ground.axes[2, 2]
    lowest = [ground.height(ball) - radius for ball in leg.balls]
    return ca.vertcat(*([ground.height(leg.foot)] if len(lowest) > 1 else []), *lowest)


def along(leg: Leg, ground: Ground) -> Any:
    """Places of a foot's balls across an edge, in units of rows."""
    seen = [ca.dot(ground.towards, ball[:2]) for ball in leg.balls]
    return ca.vertcat(*seen) / LANDING_UNIT


def knee_height(leg: Leg, ground: Ground) -> Any:
    """Height of a knee above its foot's ground, in units of rows."""
    return (ground.height(leg.knee) - ground.place[2]) / LANDING_UNIT


def squared_distances(one: Leg, other: Leg) -> list[Any]:
    """Squares of how far feet are apart, and middles of shanks, in units of rows."""
    pairs = zip(one.shank, other.shank, strict=True)
    return [ca.sumsqr((here - there) / LANDING_UNIT) for here, there in pairs]
