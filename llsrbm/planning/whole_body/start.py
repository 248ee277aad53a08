"""A centroidal plan as the second stage begins from it: states and accelerations of its posture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from llsrbm.body.knot_motion import KnotMotion, states
from llsrbm.body.momentum import base_velocities
from llsrbm.mechanics import apply, interpolated, rotation_matrices, sign_continuous, slerp
from llsrbm.motion.plan import Plan
from llsrbm.motion.surroundings import Block, surroundings
from llsrbm.planning.problem.placement import task_of
from llsrbm.planning.whole_body.apart import Apart
from llsrbm.planning.whole_body.grid import LIMITS, NODES, SAME_INSTANT, Grid, Sizes
from llsrbm.request.scenario import Scenario
from llsrbm.robots.robot import Robot

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Start:
    """A plan on a grid of N intervals.

    Attributes:
        time: (2 N + 1,) s: the knots and the middles between them.
        state: name -> (N + 1, n), at the knots; motion: name -> (N, nodes, n), at the nodes.
        force: (N, nodes, 3 C) N, of all contact points.
        place, foot_quat: (2 N + 1, L, 3) m, (2 N + 1, L, 4) of the feet.
        limits: of the request: shares of torque and speed, friction.
        solids: the ground and blocks; apart: distances of links from each other and from them.
    """

    time: Array
    state: dict[str, Array]
    motion: dict[str, Array]
    force: Array
    place: Array
    foot_quat: Array
    limits: Array
    solids: tuple[Block, ...]
    apart: Apart

    @property
    def step(self) -> Array:
        """(N,) s."""
        return np.diff(self.time[::2])

    @property
    def heading(self) -> Array:
        """(N + 1, L, 2) in which direction the feet look."""
        ahead: Array = rotation_matrices(self.foot_quat[::2])[..., :2, 0]
        return ahead


def start_of(plan: Plan, robot: Robot, grid: Grid) -> Start:
    """A plan as the second stage begins from it."""
    limits = task_of(plan, robot).limits
    assert plan.joint_velocity is not None  # a plan that converged has it
    order = [plan.joint_names.index(name) for name in robot.joint_names]
    time, known = grid.times(plan), plan.time
    knots, _ = states(robot, KnotMotion.of_plan(plan))
    R = rotation_matrices(plan.base_quat)
    omega = apply(np.swapaxes(R, -1, -2), knots.omega)
    position, velocity = plan.joint_position[:, order], plan.joint_velocity[:, order]
    state = {
        "position": interpolated(time, known, plan.base_position),
        "quat": _turning(time, known, plan.base_quat),
        "joint_position": interpolated(time, known, position),
        "velocity": interpolated(
            time,
            known,
            base_velocities(
                robot,
                plan.com_velocity,
                plan.base_position,
                plan.base_quat,
                omega,
                position,
                velocity,
            ),
        ),
        "omega": interpolated(time, known, omega),
        "joint_velocity": interpolated(time, known, velocity),
    }
    halves = np.diff(time)[:, None]
    rates = {
        "acceleration": "velocity",
        "omega_rate": "omega",
        "joint_acceleration": "joint_velocity",
    }
    middles = (time[1:] + time[:-1]) / 2
    interval = np.searchsorted(known, middles, side="right") - 1
    force = plan.contact_force.reshape(len(known), -1)[interval]
    # Feet's places count where they stand, in flight only their height does.
    place = interpolated(time, known, plan.foot_position.reshape(len(known), -1))
    last_knot = np.searchsorted(known, time + SAME_INSTANT, side="right") - 1
    count, solids = grid.intervals, surroundings(robot, plan, Scenario()).solids
    q = np.hstack([state["position"], np.roll(state["quat"], -1, axis=1), state["joint_position"]])
    return Start(
        time=time,
        state={name: values[::2] for name, values in state.items()},
        motion={
            name: (np.diff(state[of], axis=0) / halves).reshape(count, len(NODES), -1)
            for name, of in rates.items()
        },
        force=force.reshape(count, len(NODES), -1),
        place=place.reshape(len(time), -1, 3),
        foot_quat=plan.foot_quat[last_knot],
        limits=np.array([getattr(limits, name) for name in LIMITS]),
        solids=solids,
        apart=Apart.near(q, time, state["quat"][::2], robot, solids),
    )


def variables(start: Start, grid: Grid, sizes: Sizes, unit: Array) -> Array:
    """All variables of the second stage, in units: states, then the controls at both nodes."""
    found = []
    for k, knot in enumerate(grid.knots):
        found += [values[k] for values in start.state.values()]
        if knot.last:
            break
        for node in range(len(NODES)):
            found += [values[k, node] for values in start.motion.values()]
            force = start.force[k, node].reshape(sizes.legs, -1)
            found.append(force[list(knot.standing)].ravel())
    return np.concatenate(found) / unit


def _turning(time: Array, known: Array, quat: Array) -> Array:
    quat = sign_continuous(quat)
    left = np.clip(np.searchsorted(known, time + SAME_INSTANT, side="right") - 1, 0, len(known) - 2)
    share = np.clip((time - known[left]) / np.diff(known)[left], 0.0, 1.0)
    return sign_continuous(slerp(quat[left], quat[left + 1], share))
