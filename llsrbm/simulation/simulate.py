"""The loop: measure, decide, advance, record; from the start to a second after the plan's end."""

from __future__ import annotations

import time as wall_clock
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from llsrbm.control.controller import WholeBodyController
from llsrbm.control.measurement import Measurement
from llsrbm.control.reference import braking_time
from llsrbm.errors import Cancelled
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Disturbance, Rollout
from llsrbm.robots import Robot
from llsrbm.scenario import Scenario
from llsrbm.simulation.disturbance import draw_disturbance
from llsrbm.simulation.recorder import Recorder
from llsrbm.simulation.start import standing_state, starting_velocity
from llsrbm.simulation.verdict import TOPPLED, Fall, judge
from llsrbm.simulation.world import Diverged, TickResult, World

Array = NDArray[np.float64]

STANDING = 1.0  # s after the plan's end, and after what speed it ends with, in which robots stand
LEAST_TICKS = 2  # of a rollout: where it diverges before, its last known state is repeated
_AFTER_FALL = 0.3  # s that are still shown of a robot that has fallen
_ASKED_EVERY = 20  # ticks between looking whether to stop and telling how far it is
SO_FAR_INTERVAL = 0.2  # s of wall time between two reports of the motion so far
SO_FAR_RATE = 60.0  # instants/s in them: as browsers draw


def simulate(
    plan: Plan,
    robot: Robot,
    scenario: Scenario,
    *,
    cancelled: Callable[[], bool] | None = None,
    progress: Callable[[float], None] | None = None,
    so_far: Callable[[Array, Array], None] | None = None,
) -> Rollout:
    """Let the whole robot follow a plan.

    The same plan and scenario give the same rollout, wall times aside.

    Args:
        plan: a plan that converged, of this robot.
        robot: as the controller believes it is.
        scenario: board, disturbance, and names of detector, landing strategy and QP solver.
        cancelled: asked now and then; True ends with `Cancelled`.
        progress: told the share that is done, 0 to 1.
        so_far: called every `SO_FAR_INTERVAL` with the instants (K,) s and the states (K, 7 + J)
            until now, from the start on, see `Recorder.so_far`.

    Raises:
        InputError: a name that is unknown, or a board that does not fit under the robot.
        Cancelled: on request.
    """
    disturbance = draw_disturbance(scenario)
    tick = 1.0 / robot.file.control.rate
    world = World(robot, plan, scenario, disturbance, tick)
    controller = WholeBodyController(robot, plan, scenario)
    recorder = Recorder(robot, disturbance.trunk_mass_factor)
    measure = _Sensors(robot, disturbance, scenario.seed or 0)
    start = standing_state(robot, plan)
    world.reset(start, starting_velocity(robot, plan, start))

    ticks = round((plan.duration + braking_time(plan) + STANDING) / tick) + 1
    torque: Array = np.zeros(len(robot.joint_names))
    fall: Fall | None = None
    stride = max(1, round(1.0 / (tick * SO_FAR_RATE)))
    wall_start = reported_at = wall_clock.perf_counter()
    for k in range(ticks):
        if k % _ASKED_EVERY == 0:
            if cancelled is not None and cancelled():
                raise Cancelled("the simulation was cancelled")
            if progress is not None:
                progress(k / ticks)
            if so_far is not None and wall_clock.perf_counter() - reported_at >= SO_FAR_INTERVAL:
                reported_at = wall_clock.perf_counter()
                so_far(*recorder.so_far(tick, stride))
        state, mujoco_state = world.state(), (world.qpos, world.qvel)
        measurement = Measurement(k * tick, *measure(*state), torque)
        tick_start = wall_clock.perf_counter()
        decision = controller.step(measurement)
        tick_time = wall_clock.perf_counter() - tick_start
        try:
            result = world.advance(decision.command.torque)
        except Diverged as error:
            fall = fall or Fall(k * tick, str(error))
            result = TickResult.unknown(len(robot.legs), len(robot.joint_names))
            while len(recorder) < LEAST_TICKS:
                recorder.add(state, mujoco_state, decision, tick_time, result)
            break
        torque = result.torque
        recorder.add(state, mujoco_state, decision, tick_time, result)
        if fall is None:
            fall = _fallen(
                k * tick,
                state[0],
                decision.target.R_world_base,
                trunk_contact=result.trunk_contact,
                obstacle_contact=result.obstacle_contact,
            )
        elif k * tick > fall.time + _AFTER_FALL:
            break
    wall_time = wall_clock.perf_counter() - wall_start

    columns = recorder.arrays(world.joint_order)
    columns["time"] = np.arange(len(recorder)) * tick
    outcome = judge(robot, plan, recorder, columns, controller, fall, wall_time)
    if progress is not None:
        progress(1.0)
    return Rollout(
        jump=plan.jump,
        robot_parameters=robot.parameters(),
        control_parameters=robot.control_parameters(),
        scenario=scenario,
        disturbance=disturbance,
        outcome=outcome,
        plan=plan,
        joint_names=tuple(robot.joint_names[j] for j in world.joint_order),
        detection_threshold=controller.detector.threshold,
        **columns,
    )


class _Sensors:
    """Velocities as measured: the true ones and white noise, the same for the same seed."""

    def __init__(self, robot: Robot, disturbance: Disturbance, seed: int) -> None:
        self._rng = np.random.default_rng([seed, 1])  # apart from what drew the disturbance
        self._scale = np.full(robot.model.nv, disturbance.joint_velocity_noise)
        self._scale[:6] = disturbance.base_velocity_noise

    def __call__(self, q: Array, v: Array) -> tuple[Array, Array]:
        return q, v + self._scale * self._rng.standard_normal(len(v))


def _fallen(
    time: float,
    q: Array,
    planned: Array,
    *,
    trunk_contact: bool,
    obstacle_contact: bool = False,
) -> Fall | None:
    """Whether it has fallen in the state q (nq,), with its base planned to be at (3, 3)."""
    if trunk_contact:
        return Fall(time, "the trunk touched the ground")
    if obstacle_contact:
        return Fall(time, "it touched the hurdle")
    x, y, z, w = q[3:7]
    up = np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])
    if up @ planned[:, 2] < np.cos(TOPPLED):
        return Fall(time, "it toppled over")
    return None
