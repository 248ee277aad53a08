"""The card of a motion: what it is, and what checks and simulations found of it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat

from llsrbm.certificate import Certificate
from llsrbm.files.native import StatedCertificate, StatedJump
from llsrbm.mechanics import final_yaw
from llsrbm.motion.outcome import Outcome
from llsrbm.motion.plan import Plan
from llsrbm.motion.solve_report import Refinement, SolveReport
from llsrbm.request.jump import Jump
from llsrbm.request.tuning import Tuning

PIROUETTE = math.radians(120)  # rad of a turn from which on a motion is called one ...
_ON_THE_SPOT = 0.08  # m: ... where it leads no further than that
KINDS = ("back-flip", "front-flip", "barrel-roll", "route", "pirouette")
"""Kinds of motions beside those that are called as their jump type."""
_NAME = r"^[a-z0-9_]+(-[a-z0-9_]+)*-\d{4,}$"

Count = Annotated[int, Field(ge=0, le=10**6)]


@dataclass(frozen=True)
class Figures:
    """Figures of a motion; angles in rad.

    Attributes:
        forward_m, lateral_m, height_m: from where the base stands first to where it stands last, in
            axes of the robot that takes off.
        turn: about the vertical, to the left; whole turns are counted.
        apex_m: how far the CoM rises; flight_s: without a foot on the ground, all flights together.
        peak_power_w: the largest sum of what the drives give, at 1 kHz.
        torque_share: the largest share of the torque that a drive has at its speed.
    """

    forward_m: FiniteFloat
    lateral_m: FiniteFloat
    height_m: FiniteFloat
    turn: FiniteFloat
    apex_m: FiniteFloat
    flight_s: FiniteFloat
    duration_s: FiniteFloat
    peak_power_w: FiniteFloat
    torque_share: FiniteFloat

    @property
    def distance_m(self) -> float:
        """How far it leads horizontally."""
        return math.hypot(self.forward_m, self.lateral_m)

    @classmethod
    def of(cls, plan: Plan, certificate: Certificate) -> Figures:
        """Those of a certified plan."""
        stood = plan.base_position[-1] - plan.base_position[0]
        forward, lateral, height = stood.tolist()
        share = certificate["torque_at_speed"].worst
        power = certificate.power.peak_w
        assert share is not None  # the torques of a whole body's plan are known
        assert power is not None
        return cls(
            forward_m=forward,
            lateral_m=lateral,
            height_m=height,
            turn=final_yaw(plan.time, plan.base_quat, plan.angular_velocity[:, 2]),
            apex_m=float(plan.com[:, 2].max() - plan.com[0, 2]),
            flight_s=plan.airborne,
            duration_s=plan.duration,
            peak_power_w=power,
            torque_share=share,
        )


NONE = Figures(*[0.0] * 9)
"""Of a motion that was not looked at."""


@dataclass(frozen=True)
class Simulated:
    """Simulations of a motion, each with everything disturbed by its seed."""

    seeds: Count = 0
    landed: Count = 0
    strict: Count = 0

    @classmethod
    def of(cls, outcomes: Sequence[Outcome]) -> Simulated:
        """How some simulations ended."""
        return cls(
            seeds=len(outcomes),
            landed=sum(outcome.status == "landed" for outcome in outcomes),
            strict=sum(outcome.strict for outcome in outcomes),
        )

    @property
    def all_strict(self) -> bool:
        """Whether there were some and all were strict."""
        return 0 < self.seeds == self.strict


class Card(BaseModel):
    """A motion of a library in plain data.

    Attributes:
        name: of letters that a file's name may have, `ROBOT-KIND-NUMBER`; it never changes.
        kind: as people call it: "back-flip", "pirouette", "route", else the jump type.
        drawn: by which draw it was found (`llsrbm.library.draws`); None: it was given.
        request, tuning, limits, report, refinement, certificate: as of a `Plan`.
        intervals: of each phase; denser_in_flight: how much denser than even ones those of a flight
            are beside its edges (`Grid`), of motions that were kept before it was said 0.3.
    """

    model_config = ConfigDict(frozen=True, ser_json_inf_nan="strings", extra="forbid")

    name: Annotated[str, Field(pattern=_NAME, max_length=200)]
    kind: Annotated[str, Field(pattern=r"^[a-z0-9_-]+$", max_length=100)]
    robot: Annotated[str, Field(min_length=1, max_length=200)]
    drawn: Count | None = None
    request: StatedJump
    figures: Figures
    simulated: Simulated
    certificate: StatedCertificate
    tuning: Tuning
    limits: Annotated[dict[str, FiniteFloat], Field(max_length=1000)]
    report: SolveReport
    refinement: Refinement
    intervals: Annotated[tuple[Count, ...], Field(min_length=1, max_length=1000)]
    denser_in_flight: Annotated[float, Field(ge=0.0, le=1.0)] = 0.3

    @property
    def type(self) -> str:
        """The jump type's name."""
        return self.request.type

    @property
    def certified(self) -> bool:
        """Whether all checks of its certificate hold."""
        return all(found["holds"] for found in self.certificate.values())

    def summary(self) -> dict[str, Any]:
        """The part that a list shows, as plain data: SI units, radians."""
        return {
            "name": self.name,
            "robot": self.robot,
            "kind": self.kind,
            "type": self.type,
            **vars(self.figures),
            "distance_m": self.figures.distance_m,
            "certified": self.certified,
            "simulated": vars(self.simulated),
        }


def kind_of(jump: Jump) -> str:
    """The name that people have for a jump: its flip, a pirouette, a route, or its type.

    A type's file is called by its name.
    """
    if jump.turns:
        if jump.pitch:
            return "back-flip" if jump.pitch < 0 else "front-flip"
        return "barrel-roll"
    if jump.route:
        return "route"
    moved = max(abs(jump.forward), abs(jump.lateral), abs(jump.height))
    if jump.type == Jump().type and abs(jump.twist) >= PIROUETTE and moved <= _ON_THE_SPOT:
        return "pirouette"
    name = jump.type.removesuffix(".toml").replace("\\", "/").rpartition("/")[2].lower()
    return "".join(letter if letter.isascii() and letter.isalnum() else "-" for letter in name)


def rounded_request(jump: Jump) -> dict[str, Any]:
    """A request as plain data with as many digits as tell two jumps apart, without its robot."""
    return {name: _rounded(value) for name, value in jump.as_dict().items() if name != "robot"}


def _rounded(value: Any) -> Any:
    if isinstance(value, float):
        return float(np.round(value, 3)) + 0.0
    if isinstance(value, dict):
        return {key: _rounded(each) for key, each in value.items()}
    return [_rounded(each) for each in value] if isinstance(value, list | tuple) else value
