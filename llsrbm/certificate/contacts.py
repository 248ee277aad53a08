"""Checks of the feet: friction, forces that only push, and standing feet that stay."""

import numpy as np

from llsrbm.arrays import Array, stretches
from llsrbm.certificate.finding import Check
from llsrbm.certificate.sampled_motion import NO_FORCES, SampledMotion
from llsrbm.mechanics import cross
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.robots.feet import foot_contacts, pushed_points
from llsrbm.robots.placements import velocities

SLIGHT = 5e-3  # of the weight: a smaller force slips as well, and moves nothing
SLIP = 0.01  # m


class Friction(Check):
    """Forces within the friction cone: worst = |f_t| / (mu f_n), at a contact, f_n along the normal
    of what its foot stands on.

    mu is the one that was planned with, of a rollout that of its ground. Forces below half a
    hundredth of the weight are left out.
    """

    name, unit = "friction", ""

    def take(self, motion: SampledMotion) -> None:
        """The foot nearest to slipping."""
        if motion.forces is None:
            self.unknown(NO_FORCES)
            return
        across = motion.normals[:, :, None]
        normal = (motion.forces * across).sum(axis=-1)
        tangential = np.linalg.norm(motion.forces - normal[..., None] * across, axis=-1)
        pulls = normal <= 0
        shares = tangential / np.where(pulls, 1.0, motion.friction * normal)
        slight = np.linalg.norm(motion.forces, axis=-1) < SLIGHT * motion.weight
        # What pulls is a matter of `ContactForce`.
        shares = np.where(pulls | slight, 0.0, shares).max(axis=2)
        self.largest(motion, shares, motion.friction, motion.robot.leg_names)


class ContactForce(Check):
    """The ground only pushes, and only feet that stand.

    worst = 1 + e / (m g), e the largest force on a contact into the ground, or any on a foot in
    the air.
    """

    name, unit = "contact_force", "N"

    def take(self, motion: SampledMotion) -> None:
        """The foot that is pulled or floats most."""
        if motion.forces is None:
            self.unknown(NO_FORCES)
            return
        normal = (motion.forces * motion.normals[:, :, None]).sum(axis=-1)
        pulls = np.maximum(-normal.min(axis=2), 0.0)
        # A tick of a rollout in which a foot lands or leaves begins or ends in the air.
        standing = motion.contact
        if isinstance(motion.source, Rollout):
            standing = standing | np.abs(motion.forces).sum(axis=(2, 3)).astype(bool)
        floating = np.where(standing, 0.0, np.linalg.norm(motion.forces, axis=-1).sum(axis=2))
        shares = 1 + np.maximum(pulls, floating) / motion.weight
        self.largest(motion, shares, 0.0, motion.robot.leg_names)


class Slip(Check):
    """Standing feet stay where they stand, by the forward kinematics of the motion itself, and a
    whole body's plan has its forces there.

    worst: the largest distance in m of a contact point from where it was when the foot came to
    stand, or from where the plan has its force. A ball may roll: of two ways, that of the leg's
    foot frame, about which a draft's foot turns, with the ball's in height, and that of the point
    by which the ball touches, the shorter one counts.
    `limit`: 1 cm; between its knots a draft's feet wander by about half.
    """

    name, unit = "slip", "m"

    def __init__(self) -> None:
        super().__init__()
        # leg -> (c, 3) m: where the points of a foot that still stands came to stand, and how far
        # those by which it touches have moved since.
        self._stand: dict[int, tuple[Array, Array]] = {}

    def take(self, motion: SampledMotion) -> None:
        """The foot that moves furthest."""
        moved = _beside_forces(motion)
        places, velocities = _feet(motion)
        stand, self._stand = self._stand, {}
        for leg in range(len(motion.robot.legs)):
            for first, end in stretches(motion.contact[:, leg]):
                span = slice(first, end)
                came, rolled = places[first, leg], np.zeros_like(places[first, leg])
                if first == 0:
                    came, rolled = stand.get(leg, (came, rolled))
                speed, time = velocities[span, leg], motion.time[span]
                steps = (speed[1:] + speed[:-1]) / 2 * np.diff(time)[:, None, None]
                touching = np.cumsum(np.concatenate([rolled[None], steps]), axis=0)
                both = places[span, leg] - came, touching
                ways = [np.linalg.norm(way, axis=-1).max(axis=-1) for way in both]
                moved[span, leg] = np.maximum(moved[span, leg], np.minimum(*ways))
                if end == len(motion.contact):
                    self._stand[leg] = came, touching[-1]
        self.largest(motion, moved, SLIP, motion.robot.leg_names, allowed=SLIP)


def _beside_forces(motion: SampledMotion) -> Array:
    """(K, L) m: how far from where feet stand a whole body's plan has its forces; else 0."""
    if motion.points is None or not (isinstance(motion.source, Plan) and motion.source.refined):
        return np.zeros(motion.contact.shape)
    pushed = pushed_points(motion.robot, motion.placed, motion.normals)
    beside = np.linalg.norm(motion.points - pushed, axis=-1).max(axis=-1)
    return np.where(motion.contact, beside, 0.0)


def _feet(motion: SampledMotion) -> tuple[Array, Array]:
    """(K, L, c, 3) m: balls, point feet's where their frames are seen from above; m/s: of points by
    which balls touch.
    """
    turn, origin = motion.placed
    linear, angular = velocities(motion.model, motion.placed, motion.v)
    contacts, is_point = foot_contacts(motion.robot), motion.robot.file.foot.is_point
    places = np.empty((len(motion.time), len(contacts), *contacts[0].centres.shape))
    speeds = np.empty_like(places)
    for i, (leg, contact) in enumerate(zip(motion.robot.legs, contacts, strict=True)):
        frame = motion.model.frames[leg.foot_frame_id]
        joint, placed = frame.parentJoint, frame.placement
        R, at = turn[:, joint], origin[:, joint, None]
        centres = placed.translation + contact.centres @ placed.rotation.T
        places[:, i] = at + centres @ np.swapaxes(R, -1, -2)
        arms = places[:, i] - at - contact.radius * motion.normals[:, i, None]
        speeds[:, i] = linear[:, joint, None] + cross(angular[:, joint, None], arms)
        if is_point:  # a frame beside the middle of its ball sinks as the ball rolls
            places[:, i, :, :2] = (at[:, 0] + R @ placed.translation)[:, None, :2]
    return places, speeds
