"""The request in numbers: where everything starts and ends, and the limits that hold between."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from llsrbm.arrays import Array, IntArray
from llsrbm.mechanics import rotation_matrices, turns_about_z
from llsrbm.models import free_arms_of
from llsrbm.models.drives import near_stops
from llsrbm.planning.problem.apex import FREE_APEX
from llsrbm.request.jump import Jump
from llsrbm.request.jump_types import Displacement
from llsrbm.request.obstacle import Obstacle
from llsrbm.request.route import Landing
from llsrbm.request.schedule import Schedule
from llsrbm.request.slopes import leaning
from llsrbm.request.tuning import Tuning
from llsrbm.robots.drives.variants import with_strength
from llsrbm.robots.robot import Robot
from llsrbm.robots.schema import Foot, Limits, Reach, Timing

# What trunk, knees and feet keep from what they clear, m: feet of simulated jumps are 2 cm lower
# than planned where they cross a hurdle, and knees are thick.
BODY_MARGIN = 0.04


@dataclass(frozen=True, eq=False)
class Footholds:
    """Where feet stand in one place.

    Attributes:
        feet: (L, 3) m; yaw: (L,) rad, headings of the feet; points look nowhere, 0.
        contacts: (C, 3) m, legs x corners.
        tilt: (L, 2) gradients of the surface under each foot, along the world's x and y axes.
        heading: rad, of the robot that stands there.
        origin: (3,) m: where the origin of the default posture is, on the surface.
        aside: (3,) m, by how much the body is elsewhere than over that origin, as feet are.
        lean: (2,) gradient of what the body is level to, along the world's x and y axes: that of
            the surface, and of the plane nearest to feet at different heights; on soles 0.
    """

    feet: Array
    yaw: Array
    contacts: Array
    tilt: Array
    heading: float
    origin: Array
    aside: Array = field(default_factory=lambda: np.zeros(3))
    lean: Array = field(default_factory=lambda: np.zeros(2))

    @property
    def height(self) -> float:
        """m, of the surface."""
        return float(self.origin[2])


@dataclass(frozen=True, eq=False)
class Edges:
    """The edge between two places that each foot crosses, if their surfaces differ in height.

    Attributes:
        towards: (L, 2) horizontal directions across it; zeros where there is none to mind.
        gap: (L,) m: how far it is from start to target along `towards`.
        rise: m, of the second surface above the first.
    """

    towards: Array
    gap: Array
    rise: float

    @classmethod
    def between(cls, start: Footholds, goal: Footholds) -> Edges:
        """Edges along that axis of the landing heading that leaves the widest gap.

        Onto a higher surface from a foot's own start to all of the target, to a lower one from all
        of the start to the foot's own target. Where a foot has no gap there is no edge for any: no
        block fits under all feet of one place without being in the way of the other's, and what
        they land on comes, or goes, in mid-flight (`llsrbm.motion.surroundings`).
        """
        c, s = np.cos(goal.heading), np.sin(goal.heading)
        axes = np.array([(c, s), (-c, -s), (-s, c), (s, -c)])
        legs = len(start.feet)
        before, after = (
            place.contacts[:, :2].reshape(legs, -1, 2) @ axes.T for place in (start, goal)
        )
        rise = goal.height - start.height
        if rise < 0:
            gaps = after.min(axis=1) - before.max(axis=(0, 1))
        else:
            gaps = after.min(axis=(0, 1)) - before.max(axis=1)
        widest = gaps.max(axis=1)
        towards = axes[gaps.argmax(axis=1)] * (widest > 0).all()
        return cls(towards, np.maximum(widest, 0.0), rise)


@dataclass(frozen=True, eq=False)
class InMotion:
    """The state of a robot that is under way, beside its CoM's and its attitude.

    Attributes:
        momentum: (3,) kg m2/s, angular, about the CoM.
        feet, feet_velocity: (L, d) x_i m, rad and their rates (`llsrbm.models.base`).
        heights: (L,) m, of the feet in the world.
        begun: (L,) shares of the feet's swings that are over; 0 of feet that stand.
        arms: (A n,) rad and rad/s of the arms' joints.
    """

    momentum: Array
    feet: Array
    feet_velocity: Array
    heights: Array
    begun: Array
    arms: tuple[Array, Array]


@dataclass(frozen=True, eq=False)
class RowBounds:
    """Bounds of a constraint's rows of joints at each knot.

    Attributes:
        lower, upper: (N+1, J).
        reserve: (N+1, J) that they keep where earlier ones did not do.
    """

    lower: Array
    upper: Array
    reserve: Array


@dataclass(frozen=True, eq=False)
class Task:
    """A request as the planner solves it.

    Attributes:
        jump: the request.
        schedule: which feet stand in which phase, and in which place.
        mass: kg.
        places: (displacements + 1) where feet stand, the start first.
        start_position, goal_position: (3,) m, CoM.
        start_quat: (4,) w, x, y, z; goal_quat: likewise, continuous in the twist (w < 0 beyond 180
            degrees) and through whole turns.
        start_velocity, goal_velocity: (3,) m/s, CoM.
        motion: the rest of the state at the start of a schedule that is under way; else None.
        corners: (c, 3) m, contact points of a foot in its frame.
        limits, reach, timing, foot: of the robot file, with what the request changes.
        robot: whose drives and whole body a plan is checked with; `drive_strength` and `battery`
            are its, as shares of what its file says.
        weights: cost name -> weight, of every cost.
        tuning: what of weights and limits the request changes.
        correction: (N, 3) kg m2/s, base axes: by how much the whole body's angular momentum exceeds
            the model's over each interval of an earlier solution; None: it is not known.
        rolled: (N + 1, L, 2) m: how far standing feet have rolled from where they stand, at the
            knots of an earlier solution (`llsrbm.body.rolling`); None: they do not roll.
        agreed_bounds: constraint name -> bounds at which the check of an earlier solution would
            have held (`AgreedConstraint`); of the others those that follow from `limits`.
        obstacle: what is jumped over, if anything.
        clears: whether trunk and knees are kept clear of it, or of the ground.
        body_margin: m that they keep.
        apex: lowest and highest apex of the CoM in every flight, m above the ground at the start.
        requested: the request of which `jump` does less; None: `jump` is what was asked.
        penalty: cost of a whole range of it that is given up; 0: nothing may be
            (`problem.shortfall`).
        displacement: where each of several jumps leads, by the request's route or by the jump
            type; () the request itself says it.
    """

    jump: Jump
    schedule: Schedule
    mass: float
    places: tuple[Footholds, ...]
    start_position: Array
    goal_position: Array
    start_quat: Array
    goal_quat: Array
    start_velocity: Array
    goal_velocity: Array
    corners: Array
    limits: Limits
    reach: Reach
    timing: Timing
    foot: Foot
    robot: Robot
    weights: dict[str, float]
    tuning: Tuning
    motion: InMotion | None = None
    correction: Array | None = None
    rolled: Array | None = None
    agreed_bounds: Mapping[str, RowBounds] = field(default_factory=dict)
    obstacle: Obstacle | None = None
    clears: bool = False
    requested: Jump | None = None
    penalty: float = 0.0
    displacement: tuple[Displacement, ...] | tuple[Landing, ...] = ()
    body_margin: float = BODY_MARGIN
    apex: tuple[float, float] = FREE_APEX
    drive_strength: float = 1.0
    battery: float = 1.0

    def __post_init__(self) -> None:
        robot = with_strength(self.robot, self.drive_strength, self.battery)
        object.__setattr__(self, "robot", robot)

    @property
    def agrees(self) -> bool:
        """Whether a draft is to agree with the whole body.

        That of a flip that is caught is only where the whole body's problem begins.
        """
        return not (self.jump.turns and self.schedule.is_caught)

    @property
    def joints(self) -> int:
        """J."""
        return len(self.robot.joint_names)

    @cached_property
    def stopped_joints(self) -> IntArray:
        """(n,) places among `joint_names` of joints that may come near a stop: of arms all."""
        legs = self.robot.leg_joint_index[near_stops(self.robot)]
        return np.concatenate([legs, self.free_arms])

    @cached_property
    def free_arms(self) -> IntArray:
        """(A n,) places among `joint_names` of the joints of free arms."""
        free = free_arms_of(self.jump, self.robot)
        index: IntArray = self.robot.arm_joint_index
        return index if free else index[:0]

    @cached_property
    def held_arms(self) -> IntArray:
        """(n,) places among `joint_names` of the joints of arms that are held, as if they were
        locked: no plan is refused for what that takes.
        """
        return np.setdiff1d(self.robot.arm_joint_index, self.free_arms)

    @cached_property
    def lowest_hips(self) -> float:
        """Least height of the hips above the frames of standing feet, m."""
        robot = self.robot
        stands = float((robot.base_position + robot.hips - robot.feet)[:, 2].mean())
        return self.reach.standing * (stands - robot.foot_lift)

    def times(self, phase: int) -> tuple[float, float]:
        """Shortest and longest duration of a phase, s."""
        time = self.schedule[phase].time
        if isinstance(time, str):
            low, high = getattr(self.timing, time)
            return float(low), float(high)
        return time

    def footholds_before(self, phase: int) -> Footholds:
        """Where feet stand in a phase, or stood last."""
        return self._footholds[0][phase]

    def footholds_after(self, phase: int) -> Footholds:
        """Where feet stand in a phase, or stand next."""
        return self._footholds[1][phase]

    @cached_property
    def _footholds(self) -> tuple[list[Footholds], list[Footholds]]:
        """Where feet stood, and where they land, of each phase."""
        each = (self.schedule.places_before, self.schedule.places_after)
        before, after = ([self._each_in(places) for places in rows] for rows in each)
        return before, after

    def _each_in(self, places: IntArray) -> Footholds:
        """Each foot where it stands in its place (L,)."""
        rows = [self.places[place] for place in places]
        legs, corners = range(len(rows)), len(self.corners)
        return Footholds(
            feet=np.array([row.feet[i] for i, row in zip(legs, rows, strict=True)]),
            yaw=np.array([row.yaw[i] for i, row in zip(legs, rows, strict=True)]),
            contacts=np.concatenate(
                [row.contacts[i * corners : (i + 1) * corners] for i, row in enumerate(rows)]
            ),
            tilt=np.array([row.tilt[i] for i, row in zip(legs, rows, strict=True)]),
            heading=rows[0].heading,
            origin=rows[0].origin,
            aside=rows[0].aside,
            lean=rows[0].lean,
        )

    def edges(self, phase: int, leg: int) -> Edges:
        """Edges that a foot swinging in a phase crosses, as all feet would."""
        each = self.schedule.places_before, self.schedule.places_after
        before, after = (int(places[phase, leg]) for places in each)
        return self._edges[before, after]

    @cached_property
    def _edges(self) -> dict[tuple[int, int], Edges]:
        each = self.schedule.places_before, self.schedule.places_after
        pairs = zip(*(places.ravel().tolist() for places in each), strict=True)
        return {(a, b): Edges.between(self.places[a], self.places[b]) for a, b in set(pairs)}

    def tilt(self, phase: int, progress: Array) -> Array:
        """(K, L, 2) gradients of the surfaces on which feet stand, or between which they swing.

        `progress`: (K, L) share of each foot's swing; of feet that stand it does not count.
        """
        before, after = self.footholds_before(phase).tilt, self.footholds_after(phase).tilt
        share = np.where(self.schedule.stands[phase], 0.0, np.nan_to_num(progress))[..., None]
        return before + share * (after - before)

    def lean(self, place: int) -> tuple[float, float]:
        """Pitch and roll, rad, of the body that stands in a place."""
        here = self.places[place]
        ahead, left = here.lean @ turns_about_z(here.heading)[:2, :2]
        return -float(np.arctan(ahead)), float(np.arctan(left))

    def swing_share(self, phase: int, progress: Array) -> Array:
        """Shares of the feet's whole swings, of shares of what is left of them in a phase."""
        if self.motion is None or phase > 0:
            return progress
        begun: Array = self.motion.begun
        return begun + (1 - begun) * progress

    def towards(self, phase: int) -> Array:
        """(L, 2) directions across the edges that swinging feet cross; zeros of feet that stand."""
        legs = range(len(self.schedule.legs))
        flying = ~self.schedule.stands[phase]
        return np.array([self.edges(phase, i).towards[i] * flying[i] for i in legs])


def contact_points(feet: Array, yaw: Array, corners: Array, tilt: Array | None = None) -> Array:
    """Contact points of feet that lie on their surfaces.

    Args:
        feet: (..., L, 3) m, world frame.
        yaw: (..., L) rad, headings.
        corners: (c, 3) m, in the frame of a foot.
        tilt: (..., L, 2) the surfaces' gradients; None: they are level.

    Returns:
        (..., L c, 3) m, world frame, legs x corners.
    """
    c, s = np.cos(yaw)[..., None], np.sin(yaw)[..., None]
    x, y, z = corners.T
    turned = np.stack([c * x - s * y, s * x + c * y, np.broadcast_to(z, (c * x).shape)], axis=-1)
    if tilt is not None:
        turned = turned @ np.swapaxes(rotation_matrices(leaning(tilt)), -1, -2)
    points: Array = feet[..., None, :] + turned
    return points.reshape(*yaw.shape[:-1], -1, 3)
