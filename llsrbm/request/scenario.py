"""The scenario of a simulation: board, disturbance, pushes, and parts of the controller."""

from __future__ import annotations

import json
import math
import reprlib
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from typing import Annotated, Any

from llsrbm.errors import InputError
from llsrbm.request.messages import (
    FieldSpec,
    Flag,
    Name,
    Number,
    Whole,
    check_fields,
    choices,
    field_specs,
)

DURATION = 0.02  # s that a push takes: one by hand is longer, one by a ball shorter
LARGEST_IMPULSE = 200.0  # N s; it throws the heaviest robot here, of 54 kg, aside with 4 m/s
LARGEST_MOMENT = 50.0  # N m s
MOST_PUSHES = 100  # of one simulation: a page and a file hold them all

SYMBOL = "T,JX,JY,JZ[,MX,MY,MZ]"
"""How a push is written in a line of text: `Push`'s numbers in their order."""

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Push:
    """A constant wrench on the trunk's CoM over `DURATION`. Raises `InputError`: numbers that are
    not finite or too large, or a time before the start.
    """

    time: float  # s since the plan's start, when it begins
    impulse: Vector  # N s, world frame: the integral of its force
    # N m s, world frame: the integral of its moment about the trunk's CoM.
    moment: Vector = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        object.__setattr__(self, "time", Number("").checked("push: time", self.time))
        if self.time < 0:
            raise InputError(f"push: time: expected at least 0 s, got {self.time:g}")
        for name, highest, unit in (
            ("impulse", LARGEST_IMPULSE, "N s"),
            ("moment", LARGEST_MOMENT, "N m s"),
        ):
            vector = _vector(name, getattr(self, name))
            size = math.hypot(*vector)
            if size > highest:
                raise InputError(
                    f"push: {name}: expected at most {highest:g} {unit}, got {size:g} {unit}"
                )
            object.__setattr__(self, name, vector)


@dataclass(frozen=True)
class PushList(FieldSpec):
    """Any number of pushes: `Push`es, or mappings of their fields as files have them."""

    def checked(self, name: str, value: Any) -> tuple[Push, ...]:
        if isinstance(value, str | bytes | Mapping) or not isinstance(value, Sequence):
            raise InputError(f"{name}: expected a list of pushes, got {reprlib.repr(value)}")
        if len(value) > MOST_PUSHES:
            raise InputError(f"{name}: expected at most {MOST_PUSHES}, got {len(value)}")
        return tuple(_push(name, each) for each in value)


def parse_push(text: str) -> Push:
    """The push that a line of text means: "0.4,0,12,0". Raises `InputError`: not four or seven
    numbers, or not those of a push.
    """
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) not in (4, 7):
        raise InputError(f"push: expected {SYMBOL} in s, N s and N m s, got {reprlib.repr(text)}")
    time, *wrench = numbers
    moment = wrench[3:] or (0.0, 0.0, 0.0)
    return Push(time, _vector("impulse", wrench[:3]), _vector("moment", moment))


def _vector(name: str, value: Any) -> Vector:
    """Three finite numbers, as Python's own."""
    try:
        x, y, z = (Number("").checked(name, each) for each in value)
    except (TypeError, ValueError, InputError):
        raise InputError(
            f"push: {name}: expected three finite numbers, got {reprlib.repr(value)}"
        ) from None
    return x, y, z


def _push(name: str, value: Any) -> Push:
    if isinstance(value, Push):
        return value
    known = [field.name for field in fields(Push)]
    least = set(known[:2])
    if not isinstance(value, Mapping) or not least <= set(value) <= set(known):
        raise InputError(
            f"{name}: expected pushes of {', '.join(known)}, got {reprlib.repr(value)}"
        )
    return Push(**value)


_THICKEST = 1.0  # m; beyond any robot, what passes under its feet is checked with the plan
MOST_NOISE = 3.0  # beyond it no floor is that slippery
LARGEST_TRUNK_MASS = 0.5  # share of the trunk's mass, either way


@dataclass(frozen=True)
class Scenario:
    """Conditions of a simulation; each field states its meaning, unit and range with its type.

    Both of `seed` and `noise` are None, and nothing is disturbed, or none is: 0 and 1 stand in for
    the one that is left out; `seed=None, noise=None` undisturbs. A random push and an estimator's
    errors are drawn by the seed too, or by 0. Whether the names are known, a board passes under the
    feet and pushes come while the robot moves is checked when it is simulated. Raises `InputError`:
    a value of another type or out of range, or half a board without a board.
    """

    board: Annotated[
        float,
        Number("Thickness of a board that is slid in in mid-flight", "M", 0.0, _THICKEST, "m"),
    ] = 0.0
    half_board: Annotated[bool, Flag("The board lies under the front feet only")] = False
    seed: Annotated[
        int | None,
        Whole("Draws a disturbance (`llsrbm.simulation.disturbance`); without: none", "N"),
    ] = None
    noise: Annotated[
        float | None,
        Number("Scale of the disturbance, 1 as in the robustness benchmark", "S", 0.0, MOST_NOISE),
    ] = None
    detector: Annotated[str, Name("Contact detector: residual or norm")] = "residual"
    landing: Annotated[
        str, Name("Landing strategy: auto (as the robot file has it), scaled, planned or tracking")
    ] = "auto"
    solver: Annotated[str, Name("QP solver of the controller: quadprog")] = "quadprog"
    trunk_mass: Annotated[
        float | None,
        Number(
            "Error of the trunk's mass in place of the drawn one, such as 0.12: the simulated "
            "trunk weighs 1 + this of what the controller believes",
            "SHARE",
            -LARGEST_TRUNK_MASS,
            LARGEST_TRUNK_MASS,
            "of it",
        ),
    ] = None
    drives: Annotated[
        str,
        Name(
            "Drives that are simulated and controlled: true, with rotors, friction and delay as "
            "the robot file has them, or ideal, without, to compare"
        ),
    ] = "true"
    pushes: Annotated[
        tuple[Push, ...],
        PushList(
            "A push on the trunk's CoM: when it begins, s, impulse, N s, and moment, N m s, in the "
            "world frame",
            SYMBOL,
        ),
    ] = ()
    random_push: Annotated[
        float | None,
        Number(
            "Impulse of one more push, drawn by the seed: horizontal, between start and touchdown",
            "NS",
            0.0,
            LARGEST_IMPULSE,
            "N s",
        ),
    ] = None
    estimator: Annotated[
        str,
        Name(
            "State estimate that the controller is given: truth, drift as of a legged robot's, or "
            "imu: estimated by inertial unit, joint encoders and feet"
        ),
    ] = "truth"
    replan: Annotated[
        bool, Flag("Flight and landing are planned anew, 50 times a second, from what is measured")
    ] = False
    replan_latency: Annotated[
        str,
        Name(
            "When a new plan is followed: fixed (after the robot file's latency, repeatable) or "
            "measured (after the processor's time that it took, if that is longer)"
        ),
    ] = "fixed"

    def __post_init__(self) -> None:
        check_fields(self)
        if self.half_board and self.board == 0:
            raise InputError("half board: expected the board's thickness beside it, got none")
        if self.seed is None and self.noise is not None:
            object.__setattr__(self, "seed", 0)
        if self.noise is None and self.seed is not None:
            object.__setattr__(self, "noise", 1.0)

    def but(self, **changes: Any) -> Scenario:
        """This scenario with other values in the fields that are named. Raises `InputError`: no
        such field, or a value that makes no sense.
        """
        for name in changes:
            if name not in field_specs(Scenario):
                given = json.dumps(name)  # a file's keys may hold anything
                raise InputError(
                    f"unknown field {given:.60}; {choices(name, field_specs(Scenario))}"
                )
        return replace(self, **changes)

    def stated(self) -> dict[str, Any]:
        """The fewest fields that ask for this scenario: name -> value."""
        plain = asdict(Scenario(seed=self.seed)) | {"seed": None}
        return {name: value for name, value in asdict(self).items() if value != plain[name]}
