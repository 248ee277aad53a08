"""The functions that scripts, the command line and the page call."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

from llsrbm.jump import Jump
from llsrbm.planning.planner import INTERVALS, planner_for
from llsrbm.planning.solvers import names as solver_names
from llsrbm.planning.task import make_task
from llsrbm.robots import load_robot
from llsrbm.trajectory.plan import Plan


def plan(
    jump: Jump,
    *,
    solver: str = solver_names()[0],
    intervals: int = INTERVALS,
    weights: dict[str, float] | None = None,
    warm: bool = False,
    cancelled: Callable[[], bool] | None = None,
    progress: Callable[[str], None] | None = None,
) -> Plan:
    """Plan a jump; the solver of each robot and model is built once and kept.

    Args:
        jump: the request.
        solver: "fatrop" or "ipopt".
        intervals: N, shared evenly by the three phases.
        weights: cost name -> weight, in place of the defaults (`llsrbm.planning.costs`).
        warm: start from the last plan of the same robot and model.
        cancelled: asked between attempts; True ends with `Cancelled`.
        progress: told in words what is being done.

    Raises:
        InputError: an unknown name, or a request out of the robot's range.
        RobotFileError: the robot file is wrong.
        NotConverged: no attempt satisfied every constraint; its `plan` is the last iterate.
    """
    make_task(jump, load_robot(jump.robot), weights)  # a request out of range builds no solver
    start = time.perf_counter()
    planner = planner_for(jump.robot, jump.model, solver, intervals)
    build_time = time.perf_counter() - start
    result = planner.plan(jump, weights=weights, warm=warm, cancelled=cancelled, progress=progress)
    return replace(result, report=replace(result.report, build_time_s=build_time))
