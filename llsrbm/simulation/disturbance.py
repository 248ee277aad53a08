"""Disturbances of the simulated world: drawn by a seed, and pushes, stated or drawn."""

import math
from dataclasses import replace

import numpy as np

from llsrbm.errors import InputError
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Disturbance
from llsrbm.request.scenario import DURATION, Push, Scenario
from llsrbm.robots.drives.table import JointDrives
from llsrbm.robots.robot import Robot
from llsrbm.simulation.episode import Hook, Situation

# Spread of the robustness benchmark, at noise 1. What the controller believes about its own errors
# is stated elsewhere, in the robot file's [uncertainty]: the two are independent.
TRUNK_MASS = 0.08  # of the trunk's mass, either way: a payload, cables, a wrong URDF
FRICTION = (0.5, 1.0)  # wet linoleum to rubber mat
CONTACT_TIME = (0.003, 0.020)  # s, hard floor to soft mat
# Of drives the robot's file says how far they may differ: `[drives] spread`, `friction_range`.
DELAY_CHANCE = 0.5  # of one control tick
BASE_VELOCITY_NOISE = 0.01  # m/s and rad/s
JOINT_VELOCITY_NOISE = 0.02  # rad/s or m/s

# Bounds however large the noise: beyond them no robot stands, or the integrator fails.
LEAST_FRICTION = 0.2
LEAST_CONTACT_TIME = 0.002  # s, four steps of the simulator


def draw_disturbance(robot: Robot, scenario: Scenario) -> Disturbance:
    """The disturbance of a robot that goes with a scenario's seed, the same each time.

    `noise` scales the distance from the nominal world, and the chance of a delay; `trunk_mass`
    counts as it is, with and without seed.
    """
    drawn = Disturbance()
    if scenario.seed is not None and scenario.noise is not None:
        drawn = _drawn(robot.file.drives, scenario.seed, scenario.noise)
    if scenario.trunk_mass is None:
        return drawn
    return replace(drawn, trunk_mass_factor=1 + scenario.trunk_mass)


def _drawn(drives: JointDrives, seed: int, noise: float) -> Disturbance:
    nominal = Disturbance()
    rng = np.random.default_rng(seed)
    # Every number is drawn whatever the noise, so that runs of one seed differ in scale alone.
    mass = rng.uniform(-TRUNK_MASS, TRUNK_MASS)
    friction = rng.uniform(*FRICTION)
    contact_time = rng.uniform(*CONTACT_TIME)
    delayed = rng.uniform() < DELAY_CHANCE * noise
    rotors = rng.uniform(-drives.spread, drives.spread)
    lowest, highest = drives.friction_range
    losses = lowest * (highest / lowest) ** rng.uniform()  # half as much is as far as twice
    return Disturbance(
        trunk_mass_factor=1 + noise * mass,
        friction=max(LEAST_FRICTION, nominal.friction + noise * (friction - nominal.friction)),
        contact_time=max(
            LEAST_CONTACT_TIME, nominal.contact_time + noise * (contact_time - nominal.contact_time)
        ),
        torque_delay_ticks=int(delayed),
        armature_factor=max(0.0, 1 + noise * rotors),
        joint_friction_factor=losses**noise,
        base_velocity_noise=noise * BASE_VELOCITY_NOISE,
        joint_velocity_noise=noise * JOINT_VELOCITY_NOISE,
    )


class Pushes(Hook):
    """Pushes the world as a scenario states; a push's impulse is exact whatever the tick.

    `drawn` is the random push, if there is one. Raises `InputError`: a push after `duration`, s.
    """

    def __init__(self, plan: Plan, scenario: Scenario, duration: float) -> None:
        self.drawn = drawn_push(plan, scenario)
        self._pushes = (*scenario.pushes, *(() if self.drawn is None else (self.drawn,)))
        latest = duration - DURATION
        for push in self._pushes:
            if push.time > latest:
                raise InputError(
                    f"push: time: expected 0 to {latest:.2f} s, as the simulation ends at "
                    f"{duration:.2f} s, got {push.time:g} s"
                )

    def before(self, situation: Situation) -> None:
        """Act with what of each push falls into the tick."""
        start, tick = situation.time, situation.world.tick
        for push in self._pushes:
            overlap = min(start + tick, push.time + DURATION) - max(start, push.time)
            if overlap > 0:
                share = overlap / DURATION / tick
                situation.world.push(share * np.array(push.impulse), share * np.array(push.moment))


def drawn_push(plan: Plan, scenario: Scenario) -> Push | None:
    """The push that a scenario's seed draws, the same direction and moment whatever its size.

    Horizontal in any direction, at any moment from the plan's start to its last touchdown.
    """
    if scenario.random_push is None:
        return None
    rng = np.random.default_rng([scenario.seed or 0, 2])  # apart from disturbance and noise
    angle, moment = rng.uniform(0.0, 2 * math.pi), rng.uniform(0.0, plan.touchdown)
    size = scenario.random_push
    return Push(moment, (size * math.cos(angle), size * math.sin(angle), 0.0))
