"""A plan followed in the simulator, from its start to a second after its end."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from llsrbm.control.controller import WholeBodyController
from llsrbm.control.reference import braking_time
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.request.scenario import Scenario
from llsrbm.robots import Robot
from llsrbm.simulation.disturbance import Pushes, draw_disturbance
from llsrbm.simulation.episode import Episode, Hook
from llsrbm.simulation.recorder import Recorder
from llsrbm.simulation.replanning import Replanning
from llsrbm.simulation.sensors import Sensors
from llsrbm.simulation.start import standing_state, starting_velocity
from llsrbm.simulation.verdict import judge
from llsrbm.simulation.world import World

Array = NDArray[np.float64]

STANDING = 1.0  # s after the plan's end, and after what speed it ends with, in which robots stand


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
        scenario: board, disturbance, pushes, whether to plan anew, and names of detector, landing
            strategy, QP solver and estimator.
        cancelled, progress, so_far: see `Episode.run`.

    Raises:
        InputError: a name that is unknown, a board that does not fit under the robot, a box in
            which it would stand at the start, or a push outside of the simulated time.
        Cancelled: on request.
    """
    disturbance = draw_disturbance(scenario)
    duration = plan.duration + braking_time(plan) + STANDING
    tick = 1.0 / robot.file.control.rate
    pushes = Pushes(plan, scenario, duration)
    world = World(robot, plan, scenario, disturbance, tick)
    controller = WholeBodyController(robot, plan, scenario)
    recorder = Recorder(robot, disturbance.trunk_mass_factor)
    sensors = Sensors(robot, disturbance, scenario, tick)
    start = standing_state(robot, plan)
    world.reset(start, starting_velocity(robot, plan, start))
    world.check_start()
    hooks: list[Hook] = [pushes]
    if scenario.replan:
        hooks.append(Replanning(plan, robot, tick, scenario.replan_latency))
    episode = Episode(world, sensors, controller, recorder, hooks)
    episode.run(round(duration / tick) + 1, cancelled=cancelled, progress=progress, so_far=so_far)

    if progress is not None:
        progress(1.0)
    columns = recorder.arrays(world.joint_order)
    columns["time"] = np.arange(len(recorder)) * tick
    run = episode.fall, episode.wall_time, episode.replans
    return Rollout(
        jump=plan.jump,
        robot_parameters=robot.parameters(),
        control_parameters=robot.control_parameters(),
        scenario=scenario,
        disturbance=replace(disturbance, random_push=pushes.drawn),
        outcome=judge(robot, plan, recorder, columns, controller, *run),
        plan=plan,
        joint_names=tuple(robot.joint_names[j] for j in world.joint_order),
        detection_threshold=controller.detector.threshold,
        replans=tuple(episode.replans),
        **columns,
    )
