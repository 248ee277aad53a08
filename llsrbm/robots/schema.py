"""The robot file: what a person states about a robot, checked as it is read.

Mass properties and leg maps are not in it; they are computed from the URDF.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import BaseModel, Field, ValidationError, model_validator
from pydantic_core import ErrorDetails, PydanticCustomError

from llsrbm.errors import RobotFileError
from llsrbm.robots.control_table import Control
from llsrbm.robots.tables import (
    Interval,
    Length,
    Positive,
    PositiveInterval,
    Table,
    Vector,
    read_table,
)
from llsrbm.robots.urdf_table import AddedFrame, UrdfSource

# Keys of older robot files -> what does their work now.
REPLACED = {
    "limits.contact_force": (
        "plans keep to the drives' torque instead, limits.torque (the URDF's if left out) and "
        "limits.torque_share"
    ),
    "limits.foot_speed_in_base": (
        "plans keep to the drives' torque and speed instead, limits.torque and "
        "limits.joint_speed (the URDF's if left out)"
    ),
}


class LegFrames(Table):
    """Names, in the URDF, that make a leg.

    Attributes:
        foot: frame of the contact point.
        hip: joint about which the leg swings; reach is measured from its origin.
    """

    foot: str
    hip: str


_NAMED_TABLES: dict[str, type[BaseModel]] = {"legs": LegFrames, "frames": AddedFrame}


class Foot(Table):
    """What of a foot touches the ground; without this table feet are points.

    Attributes:
        corners: x forward, y left of the contact points in the frame of the foot, m: one for a
            point foot, four for a sole. In the world the sole is level.
        yaw: how far a foot may turn against the base, rad, outwards positive; not for points.
        turn_speed: the largest speed of that turn, rad/s; not for points.
        radius: of the sphere that is simulated at each corner, m; where the URDF has spheres
            there, theirs count.
    """

    corners: Annotated[tuple[tuple[float, float], ...], Field(min_length=1)] = ((0.0, 0.0),)
    yaw: Interval = (0.0, 0.0)
    turn_speed: Positive = 10.0
    radius: Positive | None = None

    @property
    def is_point(self) -> bool:
        """Whether the foot has no direction."""
        return len(self.corners) == 1


class Reach(Table):
    """Where a foot may be, in the leg's mirrored hip frame, m.

    Attributes:
        distance: shortest and longest distance from hip to foot.
        lower, upper: corners of the box.
        standing: lowest height of the hips above standing feet, a share of that in the default
            posture: the trunk must clear the ground also when a landing goes deeper than planned.
        about_standing: share of the samples for the leg maps that lie about the standing feet,
            where plans mostly keep them; the others lie anywhere in the box.
    """

    distance: PositiveInterval
    lower: Vector
    upper: Vector
    standing: Annotated[float, Field(gt=0, lt=1)] = 0.6
    about_standing: Annotated[float, Field(ge=0, le=1)] = 0.85

    @model_validator(mode="after")
    def _box_ordered(self) -> Self:
        for axis, low, high in zip("xyz", self.lower, self.upper, strict=True):
            if low > high:
                raise PydanticCustomError(
                    "box",
                    "lower exceeds upper along {axis}: {low} > {high}",
                    {"axis": axis, "low": low, "high": high},
                )
        return self


class Limits(Table):
    """What a plan keeps to.

    Attributes:
        torque: largest joint torque, Nm, or force of a sliding joint, N: one number for all joints,
            or one for each joint of a leg, from the base outwards; the URDF's if left out.
        joint_speed: largest joint speed, rad/s or m/s, in the same way.
        torque_share, speed_share: shares of them that a plan may use; the rest is for feedback.
        friction: coefficient of friction; plans and the controller stay within the pyramid that is
            inscribed in its cone.
        foot_speed: largest foot speed in the world along each axis, m/s.
        clearance: height of the feet above the ground line in mid-flight, m.
        feet_apart: shortest distance between two feet seen from above, m.
    """

    torque: Positive | Annotated[tuple[Positive, ...], Field(min_length=1)] | None = None
    joint_speed: Positive | Annotated[tuple[Positive, ...], Field(min_length=1)] | None = None
    torque_share: Positive = 0.85
    speed_share: Positive = 0.9
    friction: Positive
    foot_speed: Positive
    clearance: Length
    feet_apart: Length


class Timing(Table):
    """Shortest and longest duration of each phase, s."""

    takeoff: PositiveInterval
    flight: PositiveInterval
    landing: PositiveInterval


class Task(Table):
    """What may be asked of the robot: lowest and highest value of each part of a request.

    Attributes:
        twist: rad, positive to the left.
        forward, lateral: m.
        height: of the landing surface above the ground at the start, m.
    """

    twist: Interval
    forward: Interval
    lateral: Interval
    height: Interval


class Turning(Table):
    """What holds instead for jumps in which the body turns over.

    It leans far over its standing feet before it leaves them, and tucks its legs in the air.

    Attributes:
        axes: of the body, about which such jumps have been found: pitch of flips, roll of barrel
            rolls. Requests about another one are refused, and the page offers none.
        reach, timing: in place of the robot's.
        torque_share, speed_share: shares of the drives, in place of those of `Limits`.
    """

    axes: Annotated[tuple[Literal["pitch", "roll"], ...], Field(min_length=1)] = ("pitch", "roll")
    reach: Reach
    timing: Timing
    torque_share: Positive | None = None
    speed_share: Positive | None = None


class Example(Table):
    """The jump that a page shows first: one that shows the robot well, within `Task`.

    Attributes:
        twist: rad, positive to the left.
        forward, lateral, height: m.
    """

    twist: float = 0.0
    forward: float = 0.0
    lateral: float = 0.0
    height: float = 0.0


class Uncertainty(Table):
    """By how much the robot may differ from its URDF without surprising its user.

    Attributes:
        trunk_mass: share of the trunk's mass, either way: payload, cables, a battery. The contact
            detector takes it for two standard deviations (`llsrbm.control.detection`).
    """

    trunk_mass: Annotated[float, Field(ge=0, lt=1)] = 0.10


class RobotFile(Table):
    """A robot file's content.

    Attributes:
        name: short name, lower case.
        title: name to show.
        urdf: where its URDF is.
        legs: leg name -> frames, in the order used everywhere.
        posture: leg name -> joint angles of the default posture, rad, from the base outwards.
        foot, reach, limits, timing, task, example, control, uncertainty: see there.
        turning: likewise; a robot without it does no flips.
        planning: cost name -> weight, where this robot wants another one than
            `llsrbm.planning.problem.costs` has.
    """

    name: Annotated[str, Field(pattern=r"^[a-z0-9][a-z0-9_-]*$")]
    title: Annotated[str, Field(min_length=1)]
    urdf: UrdfSource
    legs: Annotated[dict[str, LegFrames], Field(min_length=1)]
    posture: dict[str, tuple[float, ...]]
    foot: Foot = Foot()
    reach: Reach
    limits: Limits
    timing: Timing
    task: Task
    example: Example = Example()
    control: Control = Control()
    uncertainty: Uncertainty = Uncertainty()
    turning: Turning | None = None
    planning: dict[str, Length] = Field(default_factory=dict)

    @property
    def turning_axes(self) -> tuple[str, ...]:
        """Of `pitch` and `roll` those about which it makes whole turns; none without [turning]."""
        return self.turning.axes if self.turning is not None else ()

    @model_validator(mode="after")
    def _posture_of_every_leg(self) -> Self:
        for leg in self.posture:
            if leg not in self.legs:
                raise PydanticCustomError(
                    "posture",
                    "posture.{leg}: no such leg; {legs}",
                    {"leg": leg, "legs": choices(leg, self.legs)},
                )
        for leg in self.legs:
            if leg not in self.posture:
                raise PydanticCustomError(
                    "posture", "posture.{leg}: missing; expected joint angles", {"leg": leg}
                )
        return self

    @model_validator(mode="after")
    def _example_within_task(self) -> Self:
        for name in sorted(self.example.model_fields_set):
            value, (low, high) = getattr(self.example, name), getattr(self.task, name)
            if not low <= value <= high:
                raise PydanticCustomError(
                    "example",
                    "example.{name}: expected {low} to {high}, as task.{name} says, got {value}",
                    {"name": name, "low": low, "high": high, "value": value},
                )
        return self


def choices(given: str, valid: Iterable[str], shown: int = 20) -> str:
    """The part of a message that names what would be accepted, the closest match first."""
    names = list(valid)
    close = difflib.get_close_matches(given, names, n=1)
    listed = ", ".join(names[:shown])
    if len(names) > shown:
        nearest = difflib.get_close_matches(given, names, n=shown, cutoff=0.0)
        listed = ", ".join(nearest) + f" and {len(names) - shown} more"
    return (f'did you mean "{close[0]}"? ' if close else "") + f"valid: {listed}"


def read_robot_file(path: str | Path) -> RobotFile:
    """Read and check a robot file; the URDF itself is looked at by `llsrbm.robots.load_robot`.

    Raises:
        RobotFileError: one line naming the file, the key, what was given and what is accepted.
    """
    path = Path(path)
    table = read_table(path, "a robot file", RobotFileError)
    try:
        return RobotFile.model_validate(table)
    except ValidationError as error:
        # A misspelt key is both unknown and missing; the first says more.
        details = sorted(error.errors(), key=lambda detail: detail["type"] != "extra_forbidden")
        more = f" (and {len(details) - 1} more)" if len(details) > 1 else ""
        raise RobotFileError(f"{path}: {_sentence(details[0])}{more}") from error


def _keys_beside(location: tuple[int | str, ...]) -> list[str]:
    """Names that are valid in the table holding the last key of a location."""
    table: type[BaseModel] = RobotFile
    for key in location[:-1]:
        field = table.model_fields.get(str(key))
        if field is None:
            # The name of a leg or a frame is one the person chose; below it come a table's keys.
            continue
        inner = field.annotation
        if key in _NAMED_TABLES:
            table = _NAMED_TABLES[str(key)]
        elif isinstance(inner, type) and issubclass(inner, BaseModel):
            table = inner
    return list(table.model_fields)


def _sentence(detail: ErrorDetails) -> str:
    """One pydantic complaint as: key, what was wrong, what would be accepted."""
    location = detail["loc"]
    key = ".".join(str(part) for part in location)
    given = detail["input"]
    given_text = str(list(given)) if isinstance(given, tuple) else repr(given)
    match detail["type"]:
        case "extra_forbidden" if key in REPLACED:
            return f'"{key}" is no key any more; remove it: {REPLACED[key]}'
        case "extra_forbidden":
            return f'unknown key "{key}"; {choices(str(location[-1]), _keys_beside(location))}'
        case "missing" if isinstance(location[-1], str):
            return f'missing key "{key}"; expected: {", ".join(_keys_beside(location))}'
        case "missing" | "too_long" | "too_short":
            container = ".".join(str(part) for part in location if isinstance(part, str))
            return f"{container}: {_expected_length(container, detail)}, got {given_text}"
        case "posture" | "example":
            return detail["msg"]
        case "tuple_type":
            return f"{key}: expected an array of numbers, got {given_text}"
        case "model_type" | "model_attributes_type" | "dict_type":
            return f"{key}: expected a table, got {given_text}"
        case "box" | "urdf":
            return f"{key}: {detail['msg']}"
        case _:
            message = detail["msg"][:1].lower() + detail["msg"][1:]
            return f"{key}: {message}, got {given_text}"


def _expected_length(key: str, detail: ErrorDetails) -> str:
    if detail["type"] == "too_short":
        return f"expected at least {detail['ctx']['min_length']}"
    vectors = ("lower", "upper", "xyz", "rpy")
    return f"expected {3 if key.rpartition('.')[2] in vectors else 2} values"
