"""Draws what the simulated world does differently from what the controller believes."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from llsrbm.errors import InputError
from llsrbm.motion.rollout import Conditions, Disturbance

# Spread of the robustness benchmark, at noise 1. What the controller believes about its own errors
# is stated elsewhere, in the robot file's [uncertainty]: the two are independent.
TRUNK_MASS = 0.08  # of the trunk's mass, either way: a payload, cables, a wrong URDF
FRICTION = (0.5, 1.0)  # wet linoleum to rubber mat
CONTACT_TIME = (0.003, 0.020)  # s, hard floor to soft mat
DELAY_CHANCE = 0.5  # of one control tick
BASE_VELOCITY_NOISE = 0.01  # m/s and rad/s
JOINT_VELOCITY_NOISE = 0.02  # rad/s or m/s

# Bounds however large the noise: beyond them no robot stands, or the integrator fails.
LEAST_FRICTION = 0.2
LEAST_CONTACT_TIME = 0.002  # s, four steps of the simulator
MOST_NOISE = 3.0  # beyond it no floor is that slippery
LARGEST_TRUNK_MASS = 0.5  # share of the trunk's mass, either way, that may be asked for


def draw_disturbance(conditions: Conditions) -> Disturbance:
    """The disturbance that goes with a seed, the same each time.

    Args:
        conditions: `seed` None disturbs nothing; `noise` scales the distance from the nominal
            world, and the chance of a delay; `trunk_mass` counts as it is, with and without seed.

    Raises:
        InputError: the seed is negative, or the noise or the trunk's mass out of range.
    """
    drawn = _drawn(conditions)
    share = conditions.trunk_mass
    if share is None:
        return drawn
    check_trunk_mass(share)
    return replace(drawn, trunk_mass_factor=1 + share)


def check_trunk_mass(share: float) -> None:
    """Raise `InputError` for an error of the trunk's mass that is out of range."""
    most = LARGEST_TRUNK_MASS
    if not (math.isfinite(share) and -most <= share <= most):
        raise InputError(f"trunk mass: expected {-most:g} to {most:g} of it, got {share:g}")


def _drawn(conditions: Conditions) -> Disturbance:
    seed, noise = conditions.seed, conditions.noise
    if not (math.isfinite(noise) and 0 <= noise <= MOST_NOISE):
        raise InputError(f"noise: expected 0 to {MOST_NOISE:g}, got {noise:g}")
    if seed is None:
        return Disturbance()
    if seed < 0:
        raise InputError(f"seed: expected a whole number from 0 on, got {seed}")
    nominal = Disturbance()
    rng = np.random.default_rng(seed)
    # Every number is drawn whatever the noise, so that runs of one seed differ in scale alone.
    mass = rng.uniform(-TRUNK_MASS, TRUNK_MASS)
    friction = rng.uniform(*FRICTION)
    contact_time = rng.uniform(*CONTACT_TIME)
    delayed = rng.uniform() < DELAY_CHANCE * noise
    return Disturbance(
        trunk_mass_factor=1 + noise * mass,
        friction=max(LEAST_FRICTION, nominal.friction + noise * (friction - nominal.friction)),
        contact_time=max(
            LEAST_CONTACT_TIME,
            nominal.contact_time + noise * (contact_time - nominal.contact_time),
        ),
        torque_delay_ticks=int(delayed),
        base_velocity_noise=noise * BASE_VELOCITY_NOISE,
        joint_velocity_noise=noise * JOINT_VELOCITY_NOISE,
    )
