"""The costs of the paper (section IV-B), one small class each, found by name.

Terms are written without their weight; weights are parameters of the solver, so that changing one
costs nothing. Adding a cost is one class and its place in `COSTS`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, ClassVar

import casadi as ca

from llsrbm.planning.layout import Role
from llsrbm.planning.stage import Stage
from llsrbm.trajectory.plan import Phase


class Cost(ABC):
    """A weighted term of the objective.

    Attributes:
        name: as in requests and files.
        weight: default.
        unit: of the weight.
        effect: what raising the weight does.
    """

    name: ClassVar[str]
    weight: ClassVar[float]
    unit: ClassVar[str]
    effect: ClassVar[str]

    @abstractmethod
    def applies(self, role: Role) -> bool:
        """Whether stages of that role contribute."""

    @abstractmethod
    def term(self, stage: Stage) -> Any:
        """The stage's contribution, without the weight."""


class ForceSmoothness(Cost):
    """Differences of the contact forces between knots, squared: the paper's fdot^2."""

    name = "force_smoothness"
    weight = 0.02
    unit = "1/(mg/n)^2"
    effect = "forces rise and fall more slowly"

    def applies(self, role: Role) -> bool:
        """Where a force follows a force."""
        return role.in_contact and not role.last

    def term(self, stage: Stage) -> Any:
        """n |df|^2 / contacts."""
        step = stage.symbols["force_step"]
        return stage.intervals * ca.sumsqr(step) / stage.layout.contacts


class ForceMagnitude(Cost):
    """Contact forces squared: shares the load between the feet."""

    name = "force_magnitude"
    weight = 1e-3
    unit = "1/(mg/n)^2"
    effect = "load is shared more evenly"

    def applies(self, role: Role) -> bool:
        """In contact."""
        return role.in_contact

    def term(self, stage: Stage) -> Any:
        """|f|^2 / (n contacts)."""
        return ca.sumsqr(stage.symbols["force"]) / stage.intervals / stage.layout.contacts


class FootMovement(Cost):
    """Steps of the feet in flight, squared: the paper's pdot^2.

    Of feet that turn, the mean over their contact points.
    """

    name = "foot_movement"
    weight = 0.02
    unit = "1/m^2"
    effect = "feet move less in flight; inertia shaping fades above 0.02"

    def applies(self, role: Role) -> bool:
        """In flight."""
        return role.phase == Phase.FLIGHT

    def term(self, stage: Stage) -> Any:
        """n |dp|^2."""
        legs = stage.layout.legs
        lever = ca.sumsqr(stage.parameters["corners"]) * legs / stage.layout.contacts
        speed = ca.sumsqr(stage.foot_velocity_base)
        if stage.layout.foot_coordinates > 3:
            speed += lever * ca.sumsqr(stage.foot_turn)
        return stage.intervals * stage.dt**2 * speed


class LinearMomentum(Cost):
    """H^2 / m^2: the paper's energy consumption."""

    name = "linear_momentum"
    weight = 0.05
    unit = "1/(m/s)^2"
    effect = "the CoM moves more slowly, jumps get lower"

    def applies(self, role: Role) -> bool:
        """Wherever the robot moves."""
        return not role.terminal

    def term(self, stage: Stage) -> Any:
        """|v|^2 / n."""
        return ca.sumsqr(stage.velocity) / stage.intervals


class AngularMomentum(Cost):
    """L^2 / m^2: the paper's energy consumption."""

    name = "angular_momentum"
    weight = 5.0
    unit = "1/(m2/s)^2"
    effect = "less angular momentum: more of a twist has to come from a small inertia"

    def applies(self, role: Role) -> bool:
        """Wherever the robot moves."""
        return not role.terminal

    def term(self, stage: Stage) -> Any:
        """|L/m|^2 / n."""
        return ca.sumsqr(stage.momentum) / stage.intervals


class Tilt(Cost):
    """Roll and pitch of the base: a light base rests upright between heavy legs."""

    name = "tilt"
    weight = 0.0
    unit = "1"
    effect = "the base stays upright; legs swing less"

    def applies(self, role: Role) -> bool:
        """Wherever the robot moves."""
        return not role.terminal

    def term(self, stage: Stage) -> Any:
        """(qx^2 + qy^2) / n, the sine of half the tilt, squared."""
        return ca.sumsqr(stage.quat[1:3]) / stage.intervals


class TiltRate(Cost):
    """The base's angular velocity about its own x and y."""

    name = "tilt_rate"
    weight = 0.0
    unit = "1/(rad/s)^2"
    effect = "the base rolls and pitches more slowly"

    def applies(self, role: Role) -> bool:
        """Over every interval."""
        return not role.terminal

    def term(self, stage: Stage) -> Any:
        """(omega_x^2 + omega_y^2) / n."""
        return ca.sumsqr(stage.rotation_rate[:2]) / stage.intervals


class Time(Cost):
    """Squared durations of the phases: the paper's time penalisation."""

    name = "time"
    weight = 20.0
    unit = "1/s^2"
    effect = "shorter phases and larger forces"

    def applies(self, role: Role) -> bool:
        """Once a phase."""
        return role.first

    def term(self, stage: Stage) -> Any:
        """T^2."""
        return stage.duration**2


class FinalOrientation(Cost):
    """Distance of the final attitude from the target: guides the solver towards large twists."""

    name = "final_orientation"
    weight = 200.0
    unit = "1"
    effect = "the solver turns towards the target sooner; the end itself is a constraint"

    def applies(self, role: Role) -> bool:
        """At the end."""
        return role.terminal

    def term(self, stage: Stage) -> Any:
        """|q - q_goal|^2."""
        return ca.sumsqr(stage.quat - stage.parameters["goal_quat"])


COSTS: tuple[Cost, ...] = (
    ForceSmoothness(),
    ForceMagnitude(),
    FootMovement(),
    LinearMomentum(),
    AngularMomentum(),
    Tilt(),
    TiltRate(),
    Time(),
    FinalOrientation(),
)


def default_weights() -> dict[str, float]:
    """Cost name -> default weight."""
    return {cost.name: cost.weight for cost in COSTS}


def weight_parameter(cost: Cost) -> str:
    """Name of the solver's parameter that holds the weight."""
    return f"weight_{cost.name}"
