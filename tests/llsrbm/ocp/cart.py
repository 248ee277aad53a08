"""A cart that is pushed from rest to rest at another place: optimal control without robots.

Its acceleration u is constant over each of N intervals; a drag turns it nonlinear. The cost is the
sum of w u^2 dt, where the weight w of the first half of the intervals and that of the second are
parameters of their own.
"""

from functools import cache

import casadi as ca
import numpy as np

from llsrbm.ocp.horizon import Horizon, Problem, Row, Run, StageExpressions
from llsrbm.ocp.lifting import Lifting
from llsrbm.ocp.transcription import Transcription

INTERVALS = 12
PUSH = 100.0  # m/s2, wide enough to change nothing


def expressions(kind: str, built: list[str]) -> StageExpressions:
    """Of the "first" stage, where the cart rests, an "inner" one, or the "last"."""
    built.append(kind)
    names = ("x", "v") if kind == "last" else ("x", "v", "u")
    z = ca.SX.sym("z", len(names))
    shared = ca.SX.sym("p", 4)
    duration, drag = shared[0], shared[1]
    weight = ca.SX.sym("weight")
    lift = Lifting(z)
    rest = Row(z[:2], equality=True)
    if kind == "last":
        return StageExpressions(z, 2, shared, weight, ca.SX(0), (rest,), None, lift)
    x, v, u = ca.vertsplit(z)
    dt = lift(duration / INTERVALS)
    step = lift(lift(u - drag * ca.sin(v)) * dt)
    push = Row(u)
    return StageExpressions(
        variables=z,
        states=2,
        shared=shared,
        local=weight,
        cost=weight * u**2 * dt,
        rows=(rest, push) if kind == "first" else (push,),
        next_state=ca.vertcat(x + (v + step / 2) * dt, v + step),
        lift=lift,
    )


def horizon(built: list[str] | None = None, fixed: bool = True) -> Horizon:
    """N intervals; `built` learns what is built, `fixed` is whether the start is."""
    built = [] if built is None else built
    half = INTERVALS // 2
    first, second = (slice(2, 3),), (slice(3, 4),)

    def run(kind: str, count: int, local: tuple[slice, ...]) -> Run:
        return Run(kind, count, lambda: expressions(kind, built), local)

    before = (run("first", 1, first), run("inner", half - 1, first))
    return Horizon(
        (
            *(before if fixed else (run("inner", half, first),)),
            run("inner", half, second),
            run("last", 1, second),
        ),
        4,
    )


@cache
def transcription():
    return Transcription(horizon())


def problem(
    distance: float,
    duration: float = 2.0,
    drag: float = 0.0,
    weights: tuple[float, float] = (1.0, 1.0),
    push: float = PUSH,
) -> Problem:
    """The numbers of a way of so many metres in so many seconds."""
    gap, rest = np.zeros(2), np.zeros(2)
    inner = [gap, np.array([push])]
    goal = np.array([distance, 0.0])
    parts = [[gap, rest, np.array([push])], *([inner] * (INTERVALS - 1)), [goal]]
    upper = np.concatenate([part for stage in parts for part in stage])
    lower = np.where(upper == push, -push, upper)
    return Problem(np.array([duration, drag, *weights]), lower, upper)


def best_pushes(
    distance: float, duration: float = 2.0, weights: tuple[float, float] = (1.0, 1.0)
) -> np.ndarray:
    """(N,) without a drag: the weighted least norm of what moves the cart there and stops it."""
    dt = duration / INTERVALS
    moved = (INTERVALS - np.arange(INTERVALS) - 0.5) * dt**2
    A = np.array([moved, np.full(INTERVALS, dt)])
    lightness = 1 / np.repeat(weights, INTERVALS // 2)
    return lightness * (A.T @ np.linalg.solve(A * lightness @ A.T, [distance, 0.0]))


def pushes(variables: np.ndarray) -> np.ndarray:
    """(N,) of the variables."""
    return variables[:-2].reshape(INTERVALS, 3)[:, 2]


def places(variables: np.ndarray) -> np.ndarray:
    """(N + 1,) of the variables."""
    return np.append(variables[:-2].reshape(INTERVALS, 3)[:, 0], variables[-2])
