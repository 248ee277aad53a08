"""Draws what the simulated world does differently from what the controller believes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from llsrbm.motion.rollout import Disturbance
from llsrbm.request.scenario import Scenario

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


def draw_disturbance(scenario: Scenario) -> Disturbance:
    """The disturbance that goes with a seed, the same each time.

    Args:
        scenario: `seed` None disturbs nothing; `noise` scales the distance from the nominal
            world, and the chance of a delay; `trunk_mass` counts as it is, with and without seed.
    """
    drawn = Disturbance()
    if scenario.seed is not None and scenario.noise is not None:
        drawn = _drawn(scenario.seed, scenario.noise)
    if scenario.trunk_mass is None:
        return drawn
    return replace(drawn, trunk_mass_factor=1 + scenario.trunk_mass)


def _drawn(seed: int, noise: float) -> Disturbance:
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
