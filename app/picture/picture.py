"""A picture, as a value: made from a tab's state, drawn by `app.picture.scene.Scene`."""

from dataclasses import dataclass, fields
from typing import Any

from app.motion.baked import PlannedMotion
from app.motion.colours import Rgb
from llsrbm.look.shown_motion import ShownMotion
from llsrbm.motion.block import Block
from llsrbm.motion.rollout import Rollout
from llsrbm.request.jump import Jump
from llsrbm.request.scenario import Push
from llsrbm.robots import Robot


@dataclass(frozen=True, eq=False)
class Ghost:
    """A pinned motion, drawn translucent."""

    robot: Robot  # whose
    frames: ShownMotion  # of its motion
    colour: Rgb  # of the ghost


@dataclass(frozen=True, eq=False)
class Standing:
    """One of several robots in a row, drawn solid with its name and its ellipsoid."""

    title: str  # its name
    robot: Robot
    frames: ShownMotion  # of its motion
    inertia: ShownMotion  # the motion whose inertia is drawn: the plan's, which has the model's
    colour: Rgb  # of its ellipsoid
    blocks: tuple[Block, ...] = ()  # what stands around it


@dataclass(frozen=True, eq=False)
class Picture:
    """Everything that the scene draws of a tab's state; parts that stay are the same objects."""

    robot: Robot | None = None  # that is shown; None: none yet
    planned: PlannedMotion | None = None  # its plan; None: it stands in its default posture
    # frames of the robot that follows the plan, as far as they are computed; it is drawn solid
    # then, and the plan as a ghost
    simulated: ShownMotion | None = None
    rollout: Rollout | None = None  # the simulation, once it is complete
    pushes: tuple[Push, ...] = ()  # of the simulation, as far as it is computed
    blocks: tuple[Block, ...] = ()  # what stands around: of a plan alone, drawn as what it aims at
    ghosts: tuple[Ghost, ...] = ()  # pinned motions
    # robots beside each other, from left to right, the one that is shown among them; none: it is
    # alone
    row: tuple[Standing, ...] = ()
    layers: frozenset[str] = frozenset()  # names of the overlays that are drawn
    target: Jump | None = None  # where the landings' handles stand
    night: bool = False  # a dark ground and dim light
    fine: bool = False  # with all triangles: the browser has a graphics processor
    still: bool = False  # the motion stands: the robot has all triangles in any browser
    # the robot's meshes are there; else its collision shapes stand in for them
    prepared: bool = True

    @property
    def solid(self) -> ShownMotion | None:
        """The motion of the robot that is drawn solid; None: it stands in its default posture."""
        if self.planned is None:
            return None
        return self.simulated or self.planned.frames

    @property
    def motion(self) -> tuple[Robot, PlannedMotion, ShownMotion]:
        """The robot, its plan, and the motion that is drawn solid: where there is one."""
        frames = self.solid
        assert self.robot is not None
        assert self.planned is not None
        assert frames is not None
        return self.robot, self.planned, frames

    @property
    def ground(self) -> float:
        """Height of the ground, m: a landing below the start, or a gap, moves it down."""
        return 0.0 if self.planned is None else self.planned.ground


def changed_parts(before: Picture, after: Picture) -> frozenset[str]:
    """Names of the fields in which two pictures differ: of large parts, which object it is."""
    if before is after:
        return frozenset()
    names = (field.name for field in fields(Picture))
    return frozenset(
        name for name in names if not _same(getattr(before, name), getattr(after, name))
    )


_PLAIN = (bool, int, str, frozenset, Jump, Push)
_GROUPS = (Ghost, Standing)


def _same(before: Any, after: Any) -> bool:
    if before is after:
        return True
    if isinstance(before, _GROUPS) and type(before) is type(after):
        parts = zip(vars(before).values(), vars(after).values(), strict=True)
        return all(_same(one, other) for one, other in parts)
    if isinstance(before, tuple) and isinstance(after, tuple):
        pairs = zip(before, after, strict=False)
        return len(before) == len(after) and all(_same(one, other) for one, other in pairs)
    if isinstance(before, _PLAIN) and isinstance(after, _PLAIN):
        return before == after
    return False
