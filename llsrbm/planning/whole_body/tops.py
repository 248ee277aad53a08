"""Rows of how high the CoM flies, straight about a motion, among those of what is kept apart."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from llsrbm.planning.problem.apex import FREE_APEX
from llsrbm.planning.problem.task import Task
from llsrbm.planning.whole_body.apart import Row
from llsrbm.planning.whole_body.grid import Grid
from llsrbm.robots.robot import Robot

Array = NDArray[np.float64]

KEPT = 1e-3  # m that rows keep of the limits, for what is between the instants and not straight
MISSED = 1.5e-3  # m by which a motion may fly higher or lower


def tops(q: Array, grid: Grid, task: Task, robot: Robot) -> dict[int, tuple[Row, ...]]:
    """Rows of the instants at which the CoM is highest in each flight, of postures q (2 N + 1, nq).

    Of that instant among the grid's, which is within a millimetre of the apex. None where requests
    do not limit it.
    """
    if task.apex == FREE_APEX:
        return {}
    data, found = robot.model.createData(), {}
    low, high = task.apex
    kept = min(KEPT, (high - low) / 4)
    for p in task.schedule.flights:
        halves = np.flatnonzero((grid.shares >= p) & (grid.shares <= p + 1))
        heights = [float(pin.centerOfMass(robot.model, data, q[t])[2]) for t in halves]
        top = int(halves[np.argmax(heights)])
        z, J = max(heights), pin.jacobianCenterOfMass(robot.model, data, q[top])[2]
        slope = np.concatenate([data.oMi[1].rotation @ J[:3], J[3:]])
        found[top] = tuple(
            Row(room + MISSED, MISSED + kept, sign * slope)
            for room, sign in ((z - low, 1.0), (high - z, -1.0))
        )
    return found
