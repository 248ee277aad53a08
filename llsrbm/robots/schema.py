"""The robot file: what a person states about a robot, checked as it is read.

Mass properties and leg maps are not in it; they are computed from the URDF.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from llsrbm.errors import RobotFileError
from llsrbm.installed import assets_directory
from llsrbm.request.messages import choices
from llsrbm.request.tables import (
    Interval,
    Length,
    Positive,
    PositiveInterval,
    Table,
    Vector,
    fault,
    read_table,
    validated,
)
from llsrbm.robots.control_table import Control
from llsrbm.robots.urdf_table import UrdfSource


class LegFrames(Table):
    """Names in the URDF: the frame of a leg's contact point; the joint about which it swings.

    Reach is measured from the hip's origin.
    """

    foot: str
    hip: str


class Foot(Table):
    """Contact points of a foot with the ground; without this table feet are points.

    Attributes:
        corners: x forward, y left of the contact points in the frame of the foot, m: one for a
            point foot, four for a sole. In the world the sole is level.
        yaw: how far a foot may turn against the base, rad, outwards positive; turn_speed: its
            largest speed, rad/s; not for points.
        radius: of the sphere that is simulated at each corner, m; where the URDF has spheres
            there, theirs count.
    """

    corners: Annotated[tuple[tuple[float, float], ...], Field(min_length=1)] = ((0.0, 0.0),)
    yaw: Interval = (0.0, 0.0)
    turn_speed: Positive = 10.0
    radius: Positive | None = None

    @property
    def is_point(self) -> bool:
        """True if the foot has no direction."""
        return len(self.corners) == 1


class Reach(Table):
    """Where a foot may be, in the leg's mirrored hip frame, m.

    Attributes:
        distance: shortest and longest from hip to foot; lower, upper: corners of the box.
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
                raise fault(f"lower exceeds upper along {axis}: {low} > {high}")
        return self


class Limits(Table):
    """Limits that a plan keeps to.

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
    """Range of requests: twist (rad, positive to the left), displacement (m), landing height (m)
    above the ground at the start.
    """

    twist: Interval
    forward: Interval
    lateral: Interval
    height: Interval


class Turning(Table):
    """Values for jumps in which the body turns over, in place of the others.

    It leans far over its standing feet before it leaves them, and tucks its legs in the air.

    Attributes:
        axes: of the body, about which such jumps have been found: pitch of flips, roll of barrel
            rolls. Requests about another one are refused, and the page offers none.
        torque_share, speed_share: shares of the drives, in place of those of `Limits`.
    """

    axes: Annotated[tuple[Literal["pitch", "roll"], ...], Field(min_length=1)] = ("pitch", "roll")
    reach: Reach
    timing: Timing
    torque_share: Positive | None = None
    speed_share: Positive | None = None


class Example(Table):
    """The jump that a page shows first: one that shows the robot well, within `Task`."""

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
        name: short name, lower case; title: name to show.
        legs: leg name -> frames, in the order used everywhere.
        posture: leg name -> joint angles of the default posture, rad, from the base outwards.
        turning: a robot without it does no flips.
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
                raise fault(f"posture.{leg}: no such leg; {choices(leg, self.legs)}")
        for leg in self.legs:
            if leg not in self.posture:
                raise fault(f"posture.{leg}: missing; expected joint angles")
        return self

    @model_validator(mode="after")
    def _example_within_task(self) -> Self:
        for name in sorted(self.example.model_fields_set):
            value, (low, high) = getattr(self.example, name), getattr(self.task, name)
            if not low <= value <= high:
                raise fault(
                    f"example.{name}: expected {low} to {high}, as task.{name} says, got {value}"
                )
        return self


def robot_files() -> dict[str, Path]:
    """The robots that come with the project: name -> file, by name."""
    return {path.stem: path for path in sorted((assets_directory() / "robots").glob("*.toml"))}


def read_robot_file(path: str | Path) -> RobotFile:
    """Read and check a robot file; the URDF itself is looked at by `llsrbm.robots.load_robot`.

    Raises:
        RobotFileError: one line naming the file, the key, what was given and what is accepted.
    """
    path = Path(path)
    table = read_table(path, "a robot file", RobotFileError)
    return validated(RobotFile, table, str(path), RobotFileError)
