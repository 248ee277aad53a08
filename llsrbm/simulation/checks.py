"""Checks before a simulation: a solved plan of the robot at hand, and a scenario of known names."""

import math
from typing import Any

from llsrbm.control import landing, qp
from llsrbm.control.detection import DETECTORS
from llsrbm.errors import InputError
from llsrbm.motion.plan import Plan
from llsrbm.planning.problem.violations import describe_worst
from llsrbm.request.messages import look_up
from llsrbm.request.scenario import Scenario
from llsrbm.robots import Robot
from llsrbm.robots.drives.variants import driven
from llsrbm.simulation.sensors import ESTIMATORS

LATENCIES = {"fixed": "the robot file's", "measured": "the computing time, if longer"}
"""Ways to time new plans, see `llsrbm.simulation.replanning`."""

_SAME_MASS = 1e-6  # relative; what arithmetic of another machine may make of the same URDF


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
    if plan.jump.payload and not plan.refined:
        raise InputError(
            "the plan is a draft, which is of the robot without its payload; expected the plan of "
            "the whole body"
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


def check_scenario(scenario: Scenario, robot: Robot) -> None:
    """Raise `InputError` for a name that is unknown, or a landing that is not for this robot."""
    look_up("detector", scenario.detector, DETECTORS)
    qp.check_name(scenario.solver)
    look_up("estimator", scenario.estimator, ESTIMATORS)
    look_up("replan latency", scenario.replan_latency, LATENCIES)
    driven(robot, scenario.drives)
    landing.resolved(scenario.landing, robot.file.control.force_phase)


def _same(used: Any, here: Any) -> bool:
    if isinstance(here, float):
        return isinstance(used, float | int) and math.isclose(used, here, rel_tol=_SAME_MASS)
    if isinstance(here, dict):  # the order of legs is the order of feet in every array
        return isinstance(used, dict) and list(used) == list(here) and used == here
    return bool(used == here)


def _short(value: Any) -> str:
    if isinstance(value, dict):
        return ", ".join(value)
    if isinstance(value, list):
        return ", ".join(map(str, value))
    return str(value)
