"""What may be simulated: conditions that make sense, and a solved plan of the robot at hand."""

from __future__ import annotations

import math
from numbers import Integral, Real
from typing import Any

from llsrbm.control import detection, landing, solvers
from llsrbm.errors import InputError
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Conditions
from llsrbm.planning.residuals import describe_worst
from llsrbm.robots import Robot
from llsrbm.simulation.disturbance import MOST_NOISE, check_trunk_mass

_SAME_MASS = 1e-6  # relative; what arithmetic of another machine may make of the same URDF


def make_conditions(
    *,
    board: float = 0.0,
    half_board: bool = False,
    seed: int | None = None,
    noise: float | None = None,
    detector: str = "residual",
    landing_strategy: str = "auto",
    solver: str = "quadprog",
    trunk_mass: float | None = None,
) -> Conditions:
    """Conditions from what a user gave.

    Args:
        board: thickness, m.
        half_board: under the front feet only; asks for a board.
        seed: None: nothing is disturbed, unless `noise` is given.
        noise: None: 1; given without a seed, the seed is 0.
        detector, landing_strategy, solver: names.
        trunk_mass: error of the trunk's mass, a share of it; None: as drawn.

    Raises:
        InputError: a name that is unknown, a number that makes no sense.
    """
    detection.check_name(detector)
    landing.check_name(landing_strategy)
    solvers.check_name(solver)
    board = _number("board", board)
    if board < 0:
        raise InputError(f"board: expected a thickness of 0 or more m, got {board:g}")
    if half_board and board == 0:
        raise InputError("half board: expected the board's thickness beside it, got none")
    if noise is not None:
        noise = _number("noise", noise)
        if not 0 <= noise <= MOST_NOISE:
            raise InputError(f"noise: expected 0 to {MOST_NOISE:g}, got {noise:g}")
        seed = 0 if seed is None else seed
    if trunk_mass is not None:
        trunk_mass = _number("trunk mass", trunk_mass)
        check_trunk_mass(trunk_mass)
    return Conditions(
        board=board,
        half_board=bool(half_board),
        seed=None if seed is None else _seed(seed),
        noise=1.0 if noise is None else noise,
        detector=detector,
        landing=landing_strategy,
        solver=solver,
        trunk_mass=trunk_mass,
    )


def check_plan(plan: Any) -> None:
    """Raise `InputError` unless it is a plan, and one that converged."""
    if not isinstance(plan, Plan):
        hint = {"Jump": "; plan it first: llsrbm.plan(jump)"}.get(type(plan).__name__, "")
        raise InputError(f"expected a plan to simulate, got a {type(plan).__name__}{hint}")
    if not plan.solved:
        raise InputError(
            f"the plan did not converge: {describe_worst(plan.violations)}; only a plan that "
            "satisfies every constraint is simulated"
        )


def check_robot(plan: Plan, robot: Robot) -> None:
    """Raise `InputError` where the plan was made with another robot than `robot`."""
    used, here = plan.robot_parameters, robot.parameters()
    for name in ("name", "legs", "joint_names", "mass"):
        if name not in used:
            raise InputError(f"the plan does not say its robot's {name}; expected {here[name]!r}")
        if not _same(used[name], here[name]):
            raise InputError(
                f"the plan is of another robot: its {name} is {_short(used[name])}, in "
                f"{robot.path} it is {_short(here[name])}; plan the jump again"
            )
    if plan.joint_names != robot.joint_names or plan.foot_position.shape[1] != len(robot.legs):
        raise InputError(
            f"the plan is of another robot: it has {plan.foot_position.shape[1]} feet and joints "
            f"{_short(list(plan.joint_names))}, {robot.path} has {len(robot.legs)} and "
            f"{_short(list(robot.joint_names))}; plan the jump again"
        )


def check_landing(conditions: Conditions, robot: Robot) -> None:
    """Raise `InputError` for a landing strategy that is not for this robot."""
    landing.resolved(conditions.landing, robot.file.control.force_phase)


def _number(name: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, Real) or not math.isfinite(value):
        raise InputError(f"{name}: expected a finite number, got {value!r}")
    return float(value)


def _seed(value: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, Integral) or int(value) < 0:
        raise InputError(f"seed: expected a whole number from 0 on, got {value!r}")
    return int(value)


def _same(used: Any, here: Any) -> bool:
    if isinstance(here, float):
        return isinstance(used, float | int) and math.isclose(used, here, rel_tol=_SAME_MASS)
    if isinstance(here, dict):  # the order of legs is the order of feet in every array
        return isinstance(used, dict) and list(used) == list(here) and used == here
    return bool(used == here)


def _short(value: Any) -> str:
    """A value as a message has room for it."""
    if isinstance(value, dict):
        return ", ".join(value)
    if isinstance(value, list):
        return ", ".join(map(str, value))
    return str(value)
