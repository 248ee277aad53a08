"""The costs of the paper (section IV-B), one small class each, found by name.

Terms are written without their weight; weights are parameters of the solver, so that changing one
costs nothing. Adding a cost is one class and its place in `COSTS`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from itertools import combinations
from typing import Any, ClassVar

import casadi as ca
import numpy as np

from llsrbm.planning.problem.layout import Role
from llsrbm.planning.problem.stage import Stage
from llsrbm.request.jump import Jump

FREE_TWIST = 0.2  # rad at which `Symmetry` counts half


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

    def share(self, jump: Jump) -> float:
        """Share of the weight that counts for a request."""
        return 1.0

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
        return role.in_contact and (not role.last or (not role.final and bool(role.staying)))

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
    """Steps of the feet in flight, squared: the paper's pdot^2."""

    name = "foot_movement"
    weight = 0.02
    unit = "1/m^2"
    effect = "feet move less in flight; inertia shaping fades above 0.02"

    def applies(self, role: Role) -> bool:
        """While feet swing."""
        return bool(role.swinging)

    def term(self, stage: Stage) -> Any:
        """n |dp|^2."""
        return stage.intervals * stage.dt**2 * ca.sumsqr(stage.foot_velocity_base)


class SwingEffort(Cost):
    """Steps of the feet's velocity against the base in flight, squared: what swings the legs.

    Smooth swings; and some curvature where the paper's costs have next to none, without which the
    solver creeps along valleys of equal cost.
    """

    name = "swing_effort"
    weight = 2e-4
    unit = "1/(m/s)^2"
    effect = "legs swing more smoothly; feet draw in less"

    def applies(self, role: Role) -> bool:
        """While feet swing."""
        return bool(role.swinging)

    def term(self, stage: Stage) -> Any:
        """n |d xdot|^2."""
        # The first of every leg, then those of legs that land.
        steps = [steps[0][0] for steps in stage.feet_steps.values()]
        stops = [steps[1][0] for steps in stage.feet_steps.values() if len(steps) > 1]
        each = (ca.sumsqr(ca.vertcat(*group)) for group in (steps, stops) if group)
        return stage.intervals * sum(each)


class FootTurning(Cost):
    """Turns of the feet about the vertical in flight, squared; points do not turn."""

    name = "foot_turning"
    weight = 0.05
    unit = "1/rad^2"
    effect = "soles turn no more than the twist asks"

    def applies(self, role: Role) -> bool:
        """While feet swing."""
        return bool(role.swinging)

    def term(self, stage: Stage) -> Any:
        """n |dpsi|^2."""
        return stage.intervals * stage.dt**2 * ca.sumsqr(stage.foot_turn)


class LinearMomentum(Cost):
    """H^2 / m^2: the paper's energy consumption."""

    name = "linear_momentum"
    weight = 0.05
    unit = "1/(m/s)^2"
    effect = "the CoM moves more slowly, pushed by larger forces"

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
    """Turns of the base about axes that it should not turn about: roll and pitch, but of a flip.

    A light base rests upright between heavy legs; a flip stays in its plane.
    """

    name = "tilt"
    weight = 50.0
    unit = "1"
    effect = "the base stays upright; legs swing less"

    def applies(self, role: Role) -> bool:
        """Wherever the robot moves."""
        return not role.terminal

    def term(self, stage: Stage) -> Any:
        """(qx^2 + qy^2) / n, the sine of half the tilt, squared; of a flip qz in place of one."""
        axes = stage.parameters["upright_axes"]
        return ca.dot(axes, stage.quat[1:] ** 2) / stage.intervals


class TiltRate(Cost):
    """The base's angular velocity about the axes of `Tilt`."""

    name = "tilt_rate"
    weight = 1.0
    unit = "1/(rad/s)^2"
    effect = "the base rolls and pitches more slowly"

    def applies(self, role: Role) -> bool:
        """Over every interval."""
        return not role.terminal

    def term(self, stage: Stage) -> Any:
        """(omega_x^2 + omega_y^2) / n; of a flip omega_z in place of one."""
        axes = stage.parameters["upright_axes"]
        return ca.dot(axes, stage.rotation_rate**2) / stage.intervals


class Symmetry(Cost):
    """Legs that mirror each other swing alike in flight, where no twist is asked.

    Legs that swing apart, one forward and one back, spare a light base some of its pitch; that is
    walking's way, and what they land in. Fades with the twist that is asked:
    1 / (1 + (twist / 0.2 rad)^2) of the weight counts.
    """

    name = "symmetry"
    weight = 0.0
    unit = "1/m^2, 1/rad^2"
    effect = "jumps without a twist swing left and right legs alike"

    def share(self, jump: Jump) -> float:
        """Fades with the twist."""
        return 1 / (1 + (jump.twist / FREE_TWIST) ** 2)

    def applies(self, role: Role) -> bool:
        """While feet swing."""
        return bool(role.swinging)

    def term(self, stage: Stage) -> Any:
        """|x_i - x_j|^2 / n of mirrored legs."""
        x, hips = stage.feet_in_hip, stage.model.hips
        pairs = [
            (i, j)
            for i, j in combinations(range(stage.layout.legs), 2)
            if np.allclose(hips[i] * [1, -1, 1], hips[j]) and {i, j} <= set(stage.role.swinging)
        ]
        return sum(ca.sumsqr(x[:, i] - x[:, j]) for i, j in pairs) / stage.intervals


class Time(Cost):
    """Squared durations of the phases: the paper's time penalisation."""

    name = "time"
    weight = 20.0
    unit = "1/s^2"
    effect = "shorter phases, as far as their limits allow, and larger forces"

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


class LandingShift(Cost):
    """Squared distances of a replanned jump: where it lands, and its CoM from above its feet."""

    name = "landing_shift"
    weight = 1.0
    unit = "1/m^2"
    effect = "a jump that is planned anew under way lands nearer to where it was to land"

    def applies(self, role: Role) -> bool:
        """At the end."""
        return role.terminal and role.under_way

    def term(self, stage: Stage) -> Any:
        """|s|^2 + |r - r_goal - s|^2."""
        return ca.sumsqr(stage.shift) + ca.sumsqr(stage.off_goal[:2])


COSTS: tuple[Cost, ...] = (
    ForceSmoothness(),
    ForceMagnitude(),
    FootMovement(),
    SwingEffort(),
    FootTurning(),
    LinearMomentum(),
    AngularMomentum(),
    Tilt(),
    TiltRate(),
    Symmetry(),
    Time(),
    FinalOrientation(),
    LandingShift(),
)


def default_weights() -> dict[str, float]:
    """Cost name -> default weight."""
    return {cost.name: cost.weight for cost in COSTS}


def weight_parameter(cost: Cost) -> str:
    """Name of the solver's parameter that holds the weight."""
    return f"weight_{cost.name}"
