"""A part of a motion as a plan's knots: what the whole-body problem begins from, and stays near to.

Its phases last as the motion has them, or as gravity lets flights last where it was slowed down or
sped up. Frames that are a little off are smoothed by as much. At both ends the robot stands at rest
on its footholds, as near to the motion's posture as it can.
"""

from __future__ import annotations

import warnings

import numpy as np
from scipy.interpolate import UnivariateSpline

from llsrbm.arrays import Array
from llsrbm.body.momentum import centroidal_states
from llsrbm.body.postures import solve_postures
from llsrbm.mechanics import (
    GRAVITY,
    interpolated,
    quaternions_about_z,
    sign_continuous,
)
from llsrbm.motion.plan import Plan
from llsrbm.planning.whole_body.grid import Grid
from llsrbm.planning.whole_body.motion import Motion
from llsrbm.planning.whole_body.result import Feet, plan_of
from llsrbm.planning.whole_body.sizes import NODES
from llsrbm.planning.whole_body.start import footholds, tilts
from llsrbm.planning.whole_body.unplanned import unplanned
from llsrbm.repairing.part import NoJump
from llsrbm.repairing.request import Request
from llsrbm.repairing.sliding import led_at
from llsrbm.repairing.stances import noise
from llsrbm.robots.robot import Robot

FARTHEST = 0.03  # m that a foot may be from its foothold as the robot stands at an end
# m by which it stands lower there, in turn, until all feet reach theirs: where one of the motion's
# feet hangs in the air, the middle of them is too high.
LOWER = (0.0, 0.03, 0.06)
BESIDE = 0.2  # s of the motion beside its jump that smoothing looks at
_RATES = {
    "acceleration": "velocity",
    "omega_rate": "omega",
    "joint_acceleration": "joint_velocity",
}


def begun(request: Request, robot: Robot, grid: Grid, solver: str) -> Plan:
    """The motion on a grid, in the project's frame; nothing of it need hold.

    `solver`: that will solve it. Raises `NoJump`: the robot cannot stand as the motion does.
    """
    task = request.task
    durations = _durations(request)
    edges = np.concatenate([[0.0], np.cumsum(durations)])
    time = grid.times(edges)
    states = _states(request, grid)
    _stand(request, robot, states)
    halves = np.diff(time)[:, None]
    shape = grid.intervals, len(NODES)
    rates = {
        name: (np.diff(states[of], axis=0) / halves).reshape(*shape, -1)
        for name, of in _RATES.items()
    }
    state = {name: values[::2] for name, values in states.items()}
    state["durations"] = np.tile(durations, (grid.intervals + 1, 1))
    motion = Motion(time[::2], state, rates, _forces(rates["acceleration"], grid, robot))
    feet = Feet(*footholds(task, grid), tilts(task, grid))
    return plan_of(motion, feet, unplanned(task, robot, solver), robot, grid)


def _durations(request: Request) -> Array:
    """(P,) s: as long as gravity would have let the motion last, within what may be."""
    wanted = np.diff(request.part.edges) / request.part.slower
    low, high = np.array([request.task.times(p) for p in range(len(wanted))]).T
    return np.clip(wanted, low, high)


def file_times(request: Request, edges: Array, time: Array) -> Array:
    """Instants of the motion, s of its own time, that instants (K,) s of a plan stand for.

    `edges`: (P + 1,) s of the plan's phases. Each phase is stretched evenly.
    """
    return np.interp(time, edges, request.part.edges)


def _states(request: Request, grid: Grid) -> dict[str, Array]:
    """Name -> (2 N + 1, n) states of the motion at a grid's instants, rates in a plan's time."""
    edges, known = request.part.edges, request.part.motion
    at = grid.times(edges)
    phase = [grid.phase_at(half) for half in range(len(at))]
    faster = (np.diff(edges) / _durations(request))[phase][:, None]
    led = led_at(request, known.time)
    position = request.frame.points(led.points(known.base_position))
    quat = sign_continuous(request.frame.attitudes(led.attitudes(known.base_quat)))
    quat = quat * np.copysign(1.0, quat[0, 0])  # w is positive as it begins
    beside = (known.time >= edges[0] - BESIDE) & (known.time <= edges[-1] + BESIDE)
    columns = np.hstack([position, quat, known.joint_position])[beside]
    values, slopes = _smooth(known.time[beside], columns, at)
    values[:, 2] -= interpolated(at, edges, _at_edges(request))
    quat = values[:, 3:7] / np.linalg.norm(values[:, 3:7], axis=1, keepdims=True)
    # The rate of a unit quaternion, in the base's axes.
    w, v = quat[:, :1], quat[:, 1:]
    dw, dv = slopes[:, 3:4], slopes[:, 4:7]
    omega = 2 * (w * dv - dw * v - np.cross(v, dv))
    return {
        "position": values[:, :3],
        "quat": quat,
        "joint_position": values[:, 7:],
        "velocity": slopes[:, :3] * faster,
        "omega": omega * faster,
        "joint_velocity": slopes[:, 7:] * faster,
    }


def _at_edges(request: Request) -> Array:
    """(P + 1,) m by which the motion's feet are above their footholds, at the phases' edges."""
    return np.array(request.sunk[request.places_at_edges])


def _smooth(time: Array, values: Array, at: Array) -> tuple[Array, Array]:
    """Values (K, n) at times (K,) s, and their rates, at instants (M,): splines that miss frames by
    as much as these are off.
    """
    found, slopes = np.empty((2, len(at), values.shape[1]))
    degree = min(3, len(time) - 1)
    for i, column in enumerate(values.T):
        off = noise(column)
        with warnings.catch_warnings():  # that it misses frames by a little less, or more
            warnings.simplefilter("ignore", UserWarning)
            spline = UnivariateSpline(time, column, k=degree, s=len(time) * off**2)
        found[:, i], slopes[:, i] = spline(at), spline.derivative()(at)
    return found, slopes


def _stand(request: Request, robot: Robot, states: dict[str, Array]) -> None:
    """Have the robot stand at rest at both ends, as near to its posture there as it can."""
    task, ends = request.task, [0, -1]
    q = np.hstack(
        [
            states["position"][ends],
            np.roll(states["quat"][ends], -1, axis=1),
            states["joint_position"][ends],
        ]
    )
    com, _, _ = centroidal_states(robot.model, q, np.zeros((2, robot.model.nv)))
    quat = states["quat"][ends]
    feet = np.array([task.places[0].feet, task.places[-1].feet])
    soles = quaternions_about_z(np.array([task.places[0].yaw, task.places[-1].yaw]))
    near = states["joint_position"][ends]
    for lower in LOWER:
        found = solve_postures(robot, com - [0.0, 0.0, lower], quat, feet, soles, near=near)
        if found.residual_m.max() <= FARTHEST:
            break
    else:
        when = ("begins", "ends")[int(found.residual_m.argmax())]
        raise NoJump(
            f"{robot.name} cannot stand as the motion {when}: a foot is "
            f"{100 * found.residual_m.max():.0f} cm from where it stands"
        )
    states["position"][ends] = found.base_position
    states["joint_position"][ends] = found.joint_position
    for name in _RATES.values():
        states[name][ends] = 0.0


def _forces(acceleration: Array, grid: Grid, robot: Robot) -> Array:
    """(N, nodes, C, 3) N: what a point mass needs, shared evenly by the feet that stand."""
    corners, legs = len(robot.corners), len(robot.legs)
    total = robot.mass * (acceleration + np.array([0.0, 0.0, GRAVITY]))
    total[..., 2] = np.maximum(total[..., 2], 0.0)
    found = np.zeros((grid.intervals, len(NODES), legs, corners, 3))
    for k, knot in enumerate(grid.knots[:-1]):
        standing = list(knot.standing)
        if standing:
            found[k][:, standing] = (total[k] / (len(standing) * corners))[:, None, None]
    return found.reshape(grid.intervals, len(NODES), -1, 3)
