"""The robot file: what a person states about a robot, checked as it is read.

Mass properties and leg maps are not in it; they are computed from the URDF.
"""

from __future__ import annotations

from operator import gt
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Field, SerializerFunctionWrapHandler, model_serializer, model_validator

from llsrbm.errors import RobotFileError
from llsrbm.installed import assets_directory
from llsrbm.request.messages import choices
from llsrbm.request.tables import (
    LARGEST,
    Interval,
    Length,
    OneLine,
    Positive,
    PositiveInterval,
    Table,
    Vector,
    fault,
    read_table,
    validated,
)
from llsrbm.robots.control_schema import Control, Reserve, Uncertainty
from llsrbm.robots.drives.table import JointDrives
from llsrbm.robots.wire_schema import Wire


class AddedFrame(Table):
    """A massless link that is added to the URDF, such as the middle of a sole on the ground.

    Attributes:
        link: of the URDF, which carries it.
        xyz, rpy: its origin, m, and its roll, pitch and yaw, rad, in that link's frame.
        radius: of a ball there that is solid, m, for a link that URDFs only draw, such as a hand.
    """

    link: str
    xyz: Vector
    rpy: Vector = (0.0, 0.0, 0.0)
    radius: Positive | None = None


class UrdfSource(Table):
    """Where the URDF is, and what is changed in it before anything reads it.

    Attributes:
        package, path: name of the package, for example "example-robot-data", and the URDF inside
            its robots folder.
        file: the URDF relative to the robot file; instead of the other two.
        held: joint name -> angle, rad (sliding: m), at which the joint is fixed: arms, a waist, a
            neck. Links that it carries become part of the body that it hangs on.
        frames: name -> frame that is added to a link.
    """

    package: str | None = None
    path: str | None = None
    file: str | None = None
    held: dict[str, float] = Field(default_factory=dict)
    frames: dict[str, AddedFrame] = Field(default_factory=dict)

    @model_serializer(mode="wrap")
    def _without_empty_tables(self, serialise: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Files without `held` and `frames` are written as before there were such keys.

        Cached leg maps and plan files are known by this.
        """
        table: dict[str, Any] = serialise(self)
        return {
            key: value
            for key, value in table.items()
            if key not in ("held", "frames") or value != {}
        }

    @model_validator(mode="after")
    def _one_source(self) -> Self:
        given = (self.package is not None, self.path is not None, self.file is not None)
        if given not in ((True, True, False), (False, False, True)):
            raise fault('expected either "package" and "path", or "file"')
        return self

    def installed(self) -> tuple[str, str]:
        """Package and path; only where `file` is None."""
        if self.package is None or self.path is None:
            raise ValueError("the URDF lies beside the robot file")
        return self.package, self.path


class LegFrames(Table):
    """Names in the URDF: the frame of a leg's contact point; the joint about which it swings.

    Reach is measured from the hip's origin.
    """

    foot: str
    hip: str


class ArmFrames(Table):
    """Names in the URDF: the frame at the end of an arm. Joints between it and the base that are
    not held are the arm's.
    """

    hand: str


class ArmReach(Table):
    """Where plans move the arms: joint angles of the first arm, rad, the others mirrored.

    The URDF's stops hold as well. Places nearer to the trunk or the legs are left out.

    Attributes:
        lower, upper: from the base outwards.
    """

    lower: Annotated[tuple[float, ...], Field(min_length=1)]
    upper: Annotated[tuple[float, ...], Field(min_length=1)]

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if len(self.lower) != len(self.upper) or any(map(gt, self.lower, self.upper)):
            raise fault("expected as many lower as upper angles, none above its upper one")
        return self


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
        regeneration: largest power, W, that a drive takes back as it brakes; None: any.
        stop_margin: what joints keep from either of the URDF's stops, a share of what lies between.
        knee_margin: m that knees of standing legs keep from what the feet stand on.
        legs_apart: m that legs side by side keep from each other in flight.
        friction: coefficient of friction; plans and the controller stay within the pyramid that is
            inscribed in its cone.
        foot_speed: largest foot speed in the world along each axis, m/s.
        clearance: height of the feet above the ground line in mid-flight, m.
        feet_apart: shortest distance between two feet seen from above, m.
        touchdown_braking: least braking, m/s^2, of feet that come down over the last centimetres:
            they are still as they meet the ground.
    """

    torque: Positive | Annotated[tuple[Positive, ...], Field(min_length=1)] | None = None
    joint_speed: Positive | Annotated[tuple[Positive, ...], Field(min_length=1)] | None = None
    torque_share: Positive = 0.85
    speed_share: Positive = 0.9
    regeneration: Positive | None = None
    stop_margin: Annotated[float, Field(ge=0, lt=0.5)] = 0.02
    knee_margin: Annotated[float, Field(ge=0, le=0.1)] = 0.045
    legs_apart: Annotated[float, Field(ge=0, le=0.2)] = 0.02
    friction: Positive
    foot_speed: Positive
    clearance: Length
    feet_apart: Length
    touchdown_braking: Positive = 120.0


class Timing(Table):
    """Shortest and longest duration of each phase, s."""

    takeoff: PositiveInterval
    flight: PositiveInterval
    landing: PositiveInterval


class Task(Table):
    """Usual requests: twist (rad, positive to the left), displacement (m), landing height (m) above
    the ground at the start. Tables of solved jumps and random requests are of these ranges, and
    sliders begin with them; more may be asked for.
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
        torque_share, speed_share, knee_margin: in place of those of `Limits`.
        height: in place of that of `Task`, m.
    """

    axes: Annotated[tuple[Literal["pitch", "roll"], ...], Field(min_length=1)] = ("pitch", "roll")
    reach: Reach
    timing: Timing
    torque_share: Positive | None = None
    speed_share: Positive | None = None
    knee_margin: Positive | None = None
    height: Interval | None = None


class Example(Table):
    """The jump that a page shows first: one that shows the robot well, within `Task`."""

    twist: float = 0.0
    forward: float = 0.0
    lateral: float = 0.0
    height: float = 0.0


class LinkPairs(Table):
    """Pairs of links that must not touch, beside those that are found to be able to meet.

    Attributes:
        add, exclude: names of links of the URDF, two a pair.
    """

    add: tuple[tuple[str, str], ...] = ()
    exclude: tuple[tuple[str, str], ...] = ()


class RobotFile(Table):
    """A robot file's content.

    Attributes:
        name: short name, lower case; title: name to show.
        legs: leg name -> frames, in the order used everywhere.
        arms: arm name -> frames, likewise: limbs that never stand, all alike.
        posture: leg or arm name -> joint angles of the default posture, rad, from the base
            outwards.
        arm_reach: of robots with arms.
        turning: a robot without it does no flips.
        planning: cost name -> weight, where this robot wants another one than
            `llsrbm.planning.problem.costs` has.
        wire: a robot without it is simulated and has no messages of its own.
    """

    name: Annotated[str, Field(pattern=r"^[a-z0-9][a-z0-9_-]*$")]
    title: Annotated[str, Field(min_length=1), OneLine]
    urdf: UrdfSource
    legs: Annotated[dict[str, LegFrames], Field(min_length=1)]
    arms: dict[str, ArmFrames] = Field(default_factory=dict)
    posture: dict[str, tuple[float, ...]]
    arm_reach: ArmReach | None = None
    foot: Foot = Foot()
    reach: Reach
    limits: Limits
    reserve: Reserve = Reserve()
    drives: JointDrives = JointDrives()
    timing: Timing
    task: Task
    example: Example = Example()
    control: Control = Control()
    uncertainty: Uncertainty = Uncertainty()
    turning: Turning | None = None
    link_pairs: LinkPairs = LinkPairs()
    planning: dict[str, Length] = Field(default_factory=dict)
    wire: Wire | None = None

    @property
    def turning_axes(self) -> tuple[str, ...]:
        """Axes, `pitch` and `roll`, about which it makes whole turns; none without [turning]."""
        return self.turning.axes if self.turning is not None else ()

    @property
    def turned(self) -> RobotFile:
        """As [turning] has it, for jumps in which the body turns over; itself without one."""
        if self.turning is None:
            return self
        shares = ("torque_share", "speed_share", "knee_margin")
        given = {name: getattr(self.turning, name) for name in (*shares, "height")}
        limits = {name: given[name] for name in shares if given[name] is not None}
        height = {} if given["height"] is None else {"height": given["height"]}
        return self.model_copy(
            update={
                "reach": self.turning.reach,
                "timing": self.turning.timing,
                "limits": self.limits.model_copy(update=limits),
                "task": self.task.model_copy(update=height),
            }
        )

    def for_jump(self, *, turns: bool) -> RobotFile:
        """The file as it applies to a jump: `turned`, if its body turns over."""
        return self.turned if turns else self

    @model_serializer(mode="wrap")
    def _without_arms_if_none(self, serialise: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Robots without arms are written as before there were any: caches know them by this."""
        table: dict[str, Any] = serialise(self)
        if not self.arms:
            for key in ("arms", "arm_reach"):
                table.pop(key, None)
        return table

    @model_validator(mode="after")
    def _posture_of_every_limb(self) -> Self:
        limbs = [*self.legs, *self.arms]
        for limb in self.posture:
            if limb not in limbs:
                raise fault(f"posture.{limb}: no such leg or arm; {choices(limb, limbs)}")
        for limb in limbs:
            if limb not in self.posture:
                raise fault(f"posture.{limb}: missing; expected joint angles")
        if twice := sorted(self.legs.keys() & self.arms.keys()):
            raise fault(f"arms.{twice[0]}: a leg is called so, too; expected another name")
        if (self.arm_reach is not None) != bool(self.arms):
            raise fault("arm_reach: expected for robots with [arms], and for no others")
        if self.arm_reach is not None:
            joints = len(self.arm_reach.lower)
            for arm in self.arms:
                if len(self.posture[arm]) != joints:
                    raise fault(f"posture.{arm}: expected {joints} angles, as arm_reach has")
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
    Raises `RobotFileError`: one line naming the file, the key, what was given and what is accepted.
    """
    path = Path(path)
    table = read_table(path, "a robot file", RobotFileError)
    return validated(RobotFile, table, str(path), RobotFileError, LARGEST)
