"""The planner as the paper writes it: CasADi's Opti and Ipopt, states and controls at every knot.

Kept to compare with: x = (r, q, H, L), u = (f, p) at each knot, explicit Euler steps of eq. 8 with
I_W inverted symbolically, one dt a phase, the paper's costs and constraints. Departures, without
which it finds no jump of this robot: the CoM-to-foot distance is bounded by 0.25 ... 0.75 m (the
paper's 0.6 m excludes ANYmal's own stance), feet clear the ground, phases have the planner's
shortest times, and the norm of q is left to the dynamics (with a constraint at each knot Ipopt does
not converge).
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import casadi as ca
import numpy as np

from llsrbm.body.knot_motion import KnotMotion
from llsrbm.mechanics import GRAVITY
from llsrbm.models.base import CentroidalModel
from llsrbm.planning.problem.rotations import quat_product, rotation_matrix
from llsrbm.planning.problem.task import Task
from llsrbm.request.schedule import together

LEG_LENGTH = (0.25, 0.75)  # m, CoM to foot
LARGEST_FORCE = 230.0  # N a contact, vertical: the paper knows no drives


@dataclass(frozen=True)
class BaselineResult:
    """How one solve of the baseline went."""

    converged: bool
    iterations: int
    solve_time_s: float
    final_yaw: float
    motion: KnotMotion


def _solve3(A: ca.MX, b: ca.MX) -> ca.MX:
    """A^-1 b of a symmetric (3, 3) A by Cramer's rule: Opti's `inv` cannot be expanded."""
    columns = [A[:, i] for i in range(3)]
    cross = [ca.cross(columns[1], columns[2]), ca.cross(columns[2], columns[0])]
    cross.append(ca.cross(columns[0], columns[1]))
    return ca.vertcat(*(ca.dot(c, b) for c in cross)) / ca.dot(columns[0], cross[0])


@dataclass(frozen=True, eq=False)
class _Variables:
    """Opti's problem and its variables: a column a knot, or an interval."""

    opti: ca.Opti
    intervals: int  # a phase
    T: ca.MX  # (3,) s
    r: ca.MX
    q: ca.MX
    H: ca.MX
    L: ca.MX
    f: ca.MX  # shares of the weight a leg
    p: ca.MX

    @classmethod
    def of(cls, legs: int, intervals: int) -> _Variables:
        opti, N = ca.Opti(), 3 * intervals
        r, q = opti.variable(3, N + 1), opti.variable(4, N + 1)
        H, L = opti.variable(3, N + 1), opti.variable(3, N + 1)
        f, p = opti.variable(3 * legs, N), opti.variable(3 * legs, N + 1)
        return cls(opti, intervals, opti.variable(3), r, q, H, L, f, p)


def solve_baseline(
    task: Task, model: CentroidalModel, intervals: int, expand: bool
) -> BaselineResult:
    """Build and solve; only the solve is timed.

    Args:
        task: the same request the planner gets.
        model: "srbm" or "llsrbm" (feet enter through the model's inertia).
        intervals: N, a third a phase.
        expand: whether Opti turns its MX graph into SX first.
    """
    x = _Variables.of(model.legs, intervals // 3)
    opti, N = x.opti, 3 * x.intervals
    start, goal = (place.feet.ravel() for place in task.places)
    cost = 20.0 * ca.sumsqr(x.T) + 200.0 * ca.sumsqr(x.q[:, N] - task.goal_quat)
    for name, k in (("takeoff", 0), ("flight", 1), ("landing", 2)):
        shortest, longest = getattr(task.timing, name)
        opti.subject_to(opti.bounded(shortest, x.T[k], longest))
    for k in range(N):
        _dynamics(x, k, task, model)
        _feet_in_their_place(x, k, task, start, goal)
        cost += _running_cost(x, k, task.mass)
    _ends(x, task, goal)
    opti.minimize(cost)
    _guess(x, task, start, goal)
    options = {"expand": expand, "print_time": False}
    opti.solver("ipopt", options, {"print_level": 0, "sb": "yes", "max_iter": 300})
    before = time.perf_counter()
    try:
        solution = opti.solve()
    except RuntimeError:  # Opti raises when Ipopt stops early; the statistics say so too
        solution = opti.debug
    wall = time.perf_counter() - before
    stats = opti.stats()
    # opti.solve() also builds the solver: take the time that Ipopt itself reports.
    solve_time = float(stats.get("t_wall_total", wall))
    end = solution.value(x.q[:, N])
    newtons = x.f * _unit(task, model.legs)
    return BaselineResult(
        bool(stats["success"]),
        int(stats["iter_count"]),
        solve_time,
        2 * float(np.arctan2(end[3], end[0])),
        _motion(task, *(solution.value(v).T for v in (x.T, x.r, x.q, x.H, x.p, newtons))),
    )


def _unit(task: Task, legs: int) -> float:
    """N, a leg's share of the weight."""
    return task.mass * GRAVITY / legs


def _dynamics(x: _Variables, k: int, task: Task, model: CentroidalModel) -> None:
    """Euler's step over an interval, and the rows of its legs and forces."""
    opti, n, m, legs = x.opti, x.intervals, task.mass, model.legs
    phase, dt = k // n, x.T[k // n] / n
    R = rotation_matrix(x.q[:, k])
    feet = ca.reshape(x.p[:, k], 3, legs)
    beta = ca.mtimes(R.T, feet - ca.repmat(x.r[:, k], 1, legs))
    o = model.offset_map(tuple(range(legs)))({i: beta[:, i] for i in range(legs)})
    hips = ca.horzcat(*(model.foot_in_hip(i, beta[:, i], o) for i in range(legs)))
    omega = _solve3(model.inertia(hips, o), ca.mtimes(R.T, x.L[:, k]))  # base axes
    total, moment = ca.MX.zeros(3), ca.MX.zeros(3)
    for i in range(legs):
        shares = x.f[3 * i : 3 * i + 3, k]
        force, arm = shares * _unit(task, legs), feet[:, i] - x.r[:, k]
        total += force
        moment += ca.cross(arm, force)
        opti.subject_to(opti.bounded(LEG_LENGTH[0] ** 2, ca.sumsqr(arm), LEG_LENGTH[1] ** 2))
        if phase == 1:
            opti.subject_to(force == 0)
        else:
            _friction(opti, shares, task.limits.friction, LARGEST_FORCE / _unit(task, legs))
    opti.subject_to(x.r[:, k + 1] == x.r[:, k] + dt * x.H[:, k] / m)
    spin = 0.5 * quat_product(x.q[:, k], ca.vertcat(0, omega))
    opti.subject_to(x.q[:, k + 1] == x.q[:, k] + dt * spin)
    opti.subject_to(x.H[:, k + 1] == x.H[:, k] + dt * (total - ca.DM([0, 0, m * GRAVITY])))
    opti.subject_to(x.L[:, k + 1] == x.L[:, k] + dt * moment)


def _friction(opti: ca.Opti, force: ca.MX, mu: float, largest: float) -> None:
    fx, fy, fz = ca.vertsplit(force)
    opti.subject_to(opti.bounded(0, fz, largest))
    for tangential in (fx, fy):
        opti.subject_to(tangential - mu * fz <= 0)
        opti.subject_to(tangential + mu * fz >= 0)


def _feet_in_their_place(
    x: _Variables, k: int, task: Task, start: np.ndarray, goal: np.ndarray
) -> None:
    """Feet stand, or are above an arch from start to goal, (3 L,) m."""
    n, p = x.intervals, x.p[:, k]
    if n < k < 2 * n:
        s = (k - n) / n
        line = (1 - s) * start[2::3] + s * goal[2::3]
        arch = 4 * s * (1 - s) * task.limits.clearance
        x.opti.subject_to(p[2::3] >= line + arch)
    else:
        x.opti.subject_to(p == (goal if k >= 2 * n else start))


def _running_cost(x: _Variables, k: int, m: float) -> ca.MX:
    n = x.intervals
    cost = (0.05 * ca.sumsqr(x.H[:, k] / m) + 5.0 * ca.sumsqr(x.L[:, k] / m)) / n
    cost += 0.02 * n * ca.sumsqr(x.p[:, k + 1] - x.p[:, k])
    if k % n and k // n != 1:
        cost += 0.02 * n * ca.sumsqr(x.f[:, k] - x.f[:, k - 1]) / (x.f.shape[0] // 3)
    return cost


def _ends(x: _Variables, task: Task, goal: np.ndarray) -> None:
    opti, N = x.opti, 3 * x.intervals
    opti.subject_to(x.p[:, N] == goal)
    opti.subject_to(x.r[:, 0] == task.start_position)
    opti.subject_to(x.q[:, 0] == ca.DM([1, 0, 0, 0]))
    opti.subject_to(x.H[:, 0] == 0)
    opti.subject_to(x.L[:, 0] == 0)
    opti.subject_to(x.r[:, N] == task.goal_position)
    opti.subject_to(x.H[:, N] == 0)
    opti.subject_to(x.L[:, N] == 0)


def _guess(x: _Variables, task: Task, start: np.ndarray, goal: np.ndarray) -> None:
    """The paper's: linear interpolation of position and orientation, feet from start to goal."""
    opti, N = x.opti, 3 * x.intervals
    for k in range(N + 1):
        s = k / N
        half = task.jump.twist * s / 2
        opti.set_initial(x.r[:, k], (1 - s) * task.start_position + s * task.goal_position)
        opti.set_initial(x.q[:, k], [np.cos(half), 0, 0, np.sin(half)])
        opti.set_initial(x.p[:, k], (1 - s) * start + s * goal)
    legs = x.f.shape[0] // 3
    opti.set_initial(x.f, np.tile([0.0, 0.0, 1.0], legs)[:, None] @ np.ones((1, N)))
    opti.set_initial(x.T, [0.48, 0.35, 0.48])


def _motion(
    task: Task,
    T: np.ndarray,
    r: np.ndarray,
    q: np.ndarray,
    H: np.ndarray,
    p: np.ndarray,
    f: np.ndarray,
) -> KnotMotion:
    """Durations (3,), and a row a knot of everything: positions, turns, momenta, feet, forces."""
    knots, n = len(r), len(f) // 3
    steps = np.repeat(T / n, n)
    feet = p.reshape(knots, -1, 3)
    forces = f.reshape(len(f), -1, 3)
    level = np.zeros((*feet.shape[:2], 4))
    level[..., 0] = 1.0
    phase = np.repeat(np.arange(3), n)
    return KnotMotion(
        time=np.concatenate([[0.0], np.cumsum(steps)]),
        schedule=together(tuple(leg.name for leg in task.robot.legs)),
        phase=np.append(phase, 2),
        com=r,
        com_velocity=H / task.mass,
        base_quat=q / np.linalg.norm(q, axis=1, keepdims=True),
        foot_position=feet,
        foot_quat=level,
        contact_point=feet,
        contact_force=np.concatenate([forces, forces[-1:]]),
    )
