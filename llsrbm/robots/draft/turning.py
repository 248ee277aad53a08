"""Whether a quadruped's drives can turn it over, by an estimate, and the table [turning] if so.

A flip of flight time T leaves the ground at v = g T / 2 and turns at w = W / T, so that it needs

    E = m v^2 / 2 + I w^2 / 2 + m g h

on a way up by h from the crouch, least at T^4 = 4 I W^2 / (m g^2). The legs can do the work of
their drives' torques over the angles by which the joints open on that way, and a knee in mid-stroke
opens at 2 v / L.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from llsrbm.arrays import Array
from llsrbm.mechanics import GRAVITY

LEGS = 4

# Of energy and speed that a flip needs by this estimate, the least that the drives' work and speed
# have to be: between robots that flip and robots that do not. From their URDFs Go2, Go1 and A1 do
# 2.9, 3.0 and 3.3 times the work, ANYmal B 2.4 and ANYmal C 1.2. With the torques of their files
# ANYmal B and Solo12 do 1.2 and 1.7 times, and front flips were planned with 2.6 and 2.3 times
# these torques (`benchmarks.turning`): 3.3 and 4.0 times the work. So it is a coarse estimate.
WORK = 2.7
# Go2, Go1 and A1 have 1.6, 1.9 and 2.0 times the speed, ANYmal C 0.9.
SPEED = 1.2

# Shares of the farthest that a foot is from its hip with the leg in its plane, as the tables of
# Go1 (0.385 m) and A1 (0.360 m) have them; of Go2 (0.389 m) they are 3 % less. Knees' stops are
# limits of their own.
NEAREST, FARTHEST = 0.36, 1.06
FORWARD, INWARD, OUTWARD = 0.78, 0.16, 0.265
LOWEST, HIGHEST = 1.08, 0.28
CROUCH = 0.5  # lowest hips, a share of the standing height; theirs
ABOUT_STANDING = 0.3  # of the leg maps' samples; theirs
TIMING = {"takeoff": [0.3, 0.8], "flight": [0.3, 0.7], "landing": [0.4, 1.0]}  # s, theirs
# m that knees keep from the ground: Go1's and A1's 0.1, as such a share, and no more than plans of
# plain jumps may.
KNEES, KNEES_MOST = 0.27, 0.1

IN_THE_AIR = 0.8 * 2 * np.pi  # rad of the turn; the rest is made on standing feet
STRETCHED = 0.93  # share of the leg's length, of the distance from hip to foot at lift-off
STANDING = 0.74  # share of the leg's length, of the hips above the feet in the default posture
USED = 0.85, 0.9  # shares of torque and speed that plans may use; a robot file's defaults


@dataclass(frozen=True)
class FlipEstimate:
    """A flip against a robot's drives.

    Attributes:
        flight: s, of the flip that takes least energy.
        energy: J, at lift-off, from the crouch.
        work: J, of the legs' drives on the way up.
        knee_speed, fastest: rad/s, of a knee at lift-off, and as fast as plans may let it turn.
    """

    flight: float
    energy: float
    work: float
    knee_speed: float
    fastest: float


def estimate(
    mass: float, inertia: float, length: float, torque: Array, speed: Array
) -> FlipEstimate:
    """Estimate a flip of a robot with four legs of two links as long as each other.

    Args:
        mass: kg.
        inertia: kg m2, about the lateral axis, legs tucked.
        length: m, of a leg.
        torque, speed: (n,) Nm and rad/s of a leg's drives, hip and knee the last two of them.
    """
    flight = float((4 * inertia * IN_THE_AIR**2 / (mass * GRAVITY**2)) ** 0.25)
    lift_off = GRAVITY * flight / 2
    low, high = CROUCH * STANDING * length, STRETCHED * length
    knee = 2 * (np.arccos(low / length) - np.arccos(high / length))  # rad by which it opens
    energy = (
        mass * lift_off**2 / 2
        + inertia * (IN_THE_AIR / flight) ** 2 / 2
        + mass * GRAVITY * (high - low)
    )
    work = LEGS * USED[0] * float(torque[-1] * knee + torque[-2] * knee / 2)
    return FlipEstimate(flight, float(energy), work, 2 * lift_off / length, USED[1] * speed[-1])


def turning_table(stretch: float, outward: float) -> dict[str, Any]:
    """[turning] of a robot file, m and s.

    Args:
        stretch: m, farthest distance from hip to foot with the leg in its plane.
        outward: m, of standing feet from their hips.
    """
    return {
        "axes": ["pitch"],
        "knee_margin": round(min(KNEES * stretch, KNEES_MOST), 2),
        "reach": {
            "distance": metres(NEAREST * stretch, FARTHEST * stretch),
            "lower": metres(-FORWARD * stretch, outward - INWARD * stretch, -LOWEST * stretch),
            "upper": metres(FORWARD * stretch, outward + OUTWARD * stretch, -HIGHEST * stretch),
            "standing": CROUCH,
            "about_standing": ABOUT_STANDING,
        },
        "timing": TIMING,
    }


def left_out(flip: FlipEstimate) -> str:
    """Why a robot gets no table [turning]; empty if it gets one."""
    if flip.work < WORK * flip.energy:
        return (
            f"a flip takes {flip.energy:.0f} J and its drives' torque does {flip.work:.0f} J on "
            f"the way up, {flip.work / flip.energy:.1f} times as much; robots that flip have "
            f"{WORK:g} times or more"
        )
    if flip.fastest < SPEED * flip.knee_speed:
        return (
            f"at lift-off of a flip knees open at {flip.knee_speed:.1f} rad/s and may turn at "
            f"{flip.fastest:.1f} rad/s, {flip.fastest / flip.knee_speed:.1f} times as fast; robots "
            f"that flip have {SPEED:g} times or more"
        )
    return ""


def metres(*lengths: float) -> list[float]:
    """Lengths as robot files have them."""
    return [round(float(length), 2) for length in lengths]
