"""The costs of the paper (section IV-B), and some that hold plans together, found by name.

Terms are written without their weight; weights are parameters of the solver, so that changing one
costs nothing. Adding a cost is one entry of `COSTS`.
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import casadi as ca
import numpy as np

from llsrbm.planning.problem.roles import Role
from llsrbm.planning.problem.stage import Stage
from llsrbm.request.jump import Jump
from llsrbm.robots.robot import Robot

FREE_TWIST = 0.2  # rad at which the cost of symmetry counts half


@dataclass(frozen=True, eq=False)
class Cost:
    """A weighted term of the objective.

    Attributes:
        name: as in requests and files.
        weight: default, in `unit`.
        effect: of a larger weight.
        applies: to a role: whether its stages contribute.
        term: of a stage, without the weight.
        share: of the weight that counts for a request.
        of_arms: whether it means something for robots with arms alone.
    """

    name: str
    weight: float
    unit: str
    effect: str
    applies: Callable[[Role], bool]
    term: Callable[[Stage], Any]
    share: Callable[[Jump], float] = lambda _: 1.0
    of_arms: bool = False

    def concerns(self, robot: Robot) -> bool:
        """True if the weight means something for a robot."""
        return bool(robot.arms) or not self.of_arms


def _moves(role: Role) -> bool:
    return not role.terminal


def _swings(role: Role) -> bool:
    return bool(role.swinging)


def _moves_arms(role: Role) -> bool:
    return role.moves_arms and not role.terminal


def _force_follows_force(role: Role) -> bool:
    return role.in_contact and (not role.last or (not role.final and bool(role.remaining)))


def _swing_effort(stage: Stage) -> Any:
    """n |d xdot|^2: of the first step of every leg, then of those of legs that land."""
    steps = [steps[0][0] for steps in stage.feet_steps.values()]
    stops = [steps[1][0] for steps in stage.feet_steps.values() if len(steps) > 1]
    each = (ca.sumsqr(ca.vertcat(*group)) for group in (steps, stops) if group)
    return stage.intervals * sum(each)


def _asymmetry(stage: Stage) -> Any:
    """|x_i - x_j|^2 / n of legs that mirror each other."""
    x, hips = stage.feet_in_hip, stage.model.hips
    pairs = [
        (i, j)
        for i, j in combinations(range(stage.layout.legs), 2)
        if np.allclose(hips[i] * [1, -1, 1], hips[j]) and {i, j} <= set(stage.role.swinging)
    ]
    return sum(ca.sumsqr(x[:, i] - x[:, j]) for i, j in pairs) / stage.intervals


COSTS: tuple[Cost, ...] = (
    Cost(  # differences of the contact forces between knots: the paper's fdot^2
        "force_smoothness",
        0.02,
        "1/(mg/n)^2",
        "forces rise and fall more slowly",
        _force_follows_force,
        lambda s: s.intervals * ca.sumsqr(s.symbols["force_step"]) / s.layout.contacts,
    ),
    Cost(  # shares the load between the feet
        "force_magnitude",
        1e-3,
        "1/(mg/n)^2",
        "load is shared more evenly",
        lambda role: role.in_contact,
        lambda s: ca.sumsqr(s.symbols["force"]) / s.intervals / s.layout.contacts,
    ),
    Cost(  # steps of the feet in flight: the paper's pdot^2
        "foot_movement",
        0.02,
        "1/m^2",
        "feet move less in flight; inertia shaping fades above 0.02",
        _swings,
        lambda s: s.intervals * s.dt**2 * ca.sumsqr(s.foot_velocity_base),
    ),
    # Steps of the feet's velocity against the base. Smooth swings; and some curvature where the
    # paper's costs have next to none, without which the solver creeps along valleys of equal cost.
    Cost(
        "swing_effort",
        2e-4,
        "1/(m/s)^2",
        "legs swing more smoothly; feet draw in less",
        _swings,
        _swing_effort,
    ),
    Cost(  # of the arms' joints
        "arm_movement",
        5e-3,
        "1/(rad/s)^2",
        "arms move less, and shape the inertia less",
        _moves_arms,
        lambda s: ca.sumsqr(s.arm_rates) / s.intervals,
        of_arms=True,
    ),
    # Steps of the arms' speeds. With a quarter of it arms fling themselves about at their drives'
    # limits, and of eleven jumps five more are refused; with five times as much two more.
    Cost(
        "arm_effort",
        4e-3,
        "1/(rad/s)^2",
        "arms swing more smoothly",
        _moves_arms,
        lambda s: s.intervals * ca.sumsqr(s.arm_step),
        of_arms=True,
    ),
    Cost(  # about the vertical; points do not turn
        "foot_turning",
        0.05,
        "1/rad^2",
        "soles turn no more than the twist asks",
        _swings,
        lambda s: s.intervals * s.dt**2 * ca.sumsqr(s.foot_turn),
    ),
    Cost(  # H^2 / m^2: the paper's energy consumption
        "linear_momentum",
        0.05,
        "1/(m/s)^2",
        "the CoM moves more slowly, pushed by larger forces",
        _moves,
        lambda s: ca.sumsqr(s.velocity) / s.intervals,
    ),
    Cost(  # L^2 / m^2: the paper's energy consumption
        "angular_momentum",
        5.0,
        "1/(m2/s)^2",
        "less angular momentum: more of a twist has to come from a small inertia",
        _moves,
        lambda s: ca.sumsqr(s.momentum) / s.intervals,
    ),
    # (qx^2 + qy^2) / n, the sine of half the tilt, squared; of a flip qz in place of one. A light
    # base rests upright between heavy legs; a flip stays in its plane.
    Cost(
        "tilt",
        50.0,
        "1",
        "the base stays upright; legs swing less",
        _moves,
        lambda s: ca.dot(s.parameters["upright_axes"], s.quat[1:] ** 2) / s.intervals,
    ),
    Cost(  # the base's angular velocity about the same axes
        "tilt_rate",
        1.0,
        "1/(rad/s)^2",
        "the base rolls and pitches more slowly",
        _moves,
        lambda s: ca.dot(s.parameters["upright_axes"], s.rotation_rate**2) / s.intervals,
    ),
    # Legs that swing apart, one forward and one back, spare a light base some of its pitch, which
    # makes a fore-aft split stance. Fades with the request's twist.
    Cost(
        "symmetry",
        0.0,
        "1/m^2, 1/rad^2",
        "jumps without a twist swing left and right legs alike",
        _swings,
        _asymmetry,
        lambda jump: 1 / (1 + (jump.twist / FREE_TWIST) ** 2),
    ),
    Cost(  # squared durations of the phases: the paper's time penalisation
        "time",
        20.0,
        "1/s^2",
        "shorter phases, as far as their limits allow, and larger forces",
        lambda role: role.first,
        lambda s: s.duration**2,
    ),
    Cost(  # guides the solver towards large twists
        "final_orientation",
        200.0,
        "1",
        "the solver turns towards the target sooner; the end itself is a constraint",
        lambda role: role.terminal,
        lambda s: ca.sumsqr(s.quat - s.parameters["goal_quat"]),
    ),
    Cost(  # of a replanned jump: where it lands, and its CoM from above its feet
        "landing_shift",
        1.0,
        "1/m^2",
        "a jump that is planned anew under way lands nearer to where it was to land",
        lambda role: role.terminal and role.under_way,
        lambda s: ca.sumsqr(s.shift) + ca.sumsqr(s.off_goal[:2]),
    ),
)


def default_weights() -> dict[str, float]:
    """Cost name -> default weight."""
    return {cost.name: cost.weight for cost in COSTS}


def weight_parameter(cost: Cost) -> str:
    """Name of the solver's parameter that holds the weight."""
    return f"weight_{cost.name}"
