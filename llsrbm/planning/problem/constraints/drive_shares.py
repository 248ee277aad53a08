"""Torques and speeds of all joints as shares of their limits: as rows, and in the whole body.

Arrays (N, 2, J) are of each interval, in its middle and at lift-off or touchdown beside it.
"""

from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np

from llsrbm.arrays import Array
from llsrbm.planning.problem.knots import Knots

# Beyond so many times the limit rows grow with its root: near a straight leg shares of thousands
# come up on the way to a solution, and slopes of millions, with which Fatrop may look for a
# direction for ever. At the limit 0.2 % are left out.
FAR_BEYOND = 10.0

MIDDLE, EDGE = 0, 1  # where over an interval, in arrays (N, 2, J)
Place = tuple[int, int, int]  # in one


def compressed(share: Any, root: Callable[[Any], Any] = ca.sqrt) -> Any:
    """A share, or its bound, as a row: increasing, and far beyond the limit ever slower."""
    return share / root(root(1 + (share / FAR_BEYOND) ** 2))


def expanded(row: Array) -> Array:
    """The share that a row is of."""
    fourth = row**4
    square = fourth / FAR_BEYOND**2
    return np.sign(row) * np.sqrt((square + np.sqrt(square**2 + 4 * fourth)) / 2)


def at_middle_and_edge(middle: Array, edge: Array) -> Array:
    """(N, 2, J) of (N, J) each."""
    return np.stack([middle, edge], axis=1)


def of_planned(excess: Array, knots: Knots) -> Array:
    """(N, 2, J) likewise with room where arms are held."""
    excess[..., knots.task.held_arms] = -np.inf
    return excess


def of_edges(excess: Array) -> Array:
    """(N, 2, J) likewise with room where there is no edge."""
    excess[:, EDGE] = np.fmax(excess[:, EDGE], -np.inf)
    return excess


def available(knots: Knots) -> Array:
    """(N, 2, J) Nm or N; infinite where there is no edge."""
    edge = np.where(np.isnan(_edge_velocity(knots)), np.inf, knots.loads.edge_available)
    return at_middle_and_edge(knots.loads.torque_available, edge)


def speed_shares(knots: Knots) -> Array:
    """(N, 2, J) of the limits; NaN where there is no edge."""
    shares = at_middle_and_edge(knots.loads.joint_velocity, _edge_velocity(knots))
    return shares / knots.task.robot.speed_limit


def _edge_velocity(knots: Knots) -> Array:
    """(N, J) rad/s or m/s; NaN where no rows are, see `Role.at_edge`."""
    velocity = knots.loads.edge_velocity.copy()
    for interval, role in enumerate(knots.layout.roles[: len(velocity)]):
        for leg in {*role.landing} - {*role.at_edge}:
            velocity[interval, knots.task.robot.leg_joint_index[leg]] = np.nan
    return velocity
