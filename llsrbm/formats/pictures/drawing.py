"""A motion for a video: what is drawn of it, and from where it is looked at."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from llsrbm.arrays import Array
from llsrbm.look.shown_motion import ShownMotion, shown_trajectory
from llsrbm.look.timeline import Timeline, timeline
from llsrbm.look.visuals import LinkVisual, link_visuals, viewpoint
from llsrbm.mechanics import rotation_matrices
from llsrbm.motion.plan import Plan
from llsrbm.motion.sampling import evenly
from llsrbm.motion.trajectory import Trajectory

FIELD_OF_VIEW = 36.0  # deg, upright
_ROOM = 1.06  # a little more than what the robot needs


@dataclass(frozen=True, eq=False)
class Drawing:
    """A plan or a rollout to be drawn at K instants."""

    trajectory: Trajectory
    solid: ShownMotion  # the robot that moves
    ghost: ShownMotion | None  # the plan that it followed, if that is another motion
    timeline: Timeline  # phases and events

    @cached_property
    def visuals(self) -> tuple[LinkVisual, ...]:
        """The robot's meshes."""
        return link_visuals(self.solid.robot)

    @cached_property
    def spheres(self) -> tuple[Array, Array]:
        """(n, 3) m and (n,) m: spheres that hold all the places where the robot gets."""
        centres, radii = [], []
        for shown in filter(None, (self.solid, self.ghost)):
            for visual in self.visuals:
                low, high = visual.vertices.min(axis=0), visual.vertices.max(axis=0)
                body = visual.joint_id - 1
                R = rotation_matrices(shown.body_wxyz[:, body])
                centres.append(shown.body_position[:, body] + R @ ((low + high) / 2))
                radii.append(np.full(len(R), np.linalg.norm(high - low) / 2))
        return np.concatenate(centres), np.concatenate(radii)


@dataclass(frozen=True)
class View:
    """A camera at a distance (m) from the (3,) m `target` that it looks at.

    As seen from there it stands at `azimuth`, deg: 0 ahead (x), 90 to the left (y), and
    `elevation`, deg, above the horizon.
    """

    target: Array
    azimuth: float
    elevation: float
    distance: float

    @property
    def axes(self) -> Array:
        """(3, 3) columns: right, up, and from what is seen to the camera."""
        azimuth, elevation = math.radians(self.azimuth), math.radians(self.elevation)
        right = np.array([-math.sin(azimuth), math.cos(azimuth), 0.0])
        c, s = math.cos(elevation), math.sin(elevation)
        back = np.array([c * math.cos(azimuth), c * math.sin(azimuth), s])
        return np.column_stack([right, np.cross(back, right), back])


def draw(trajectory: Trajectory, fps: float, pad: float = 0.0) -> Drawing:
    """Everything that is drawn of a plan or a rollout; errors as of `shown_trajectory`."""
    time = evenly(trajectory, fps, pad)
    solid = shown_trajectory(trajectory, time)
    if isinstance(trajectory, Plan):
        return Drawing(trajectory, solid, None, timeline(trajectory))
    ghost = shown_trajectory(trajectory.plan, time)
    return Drawing(trajectory, solid, ghost, timeline(trajectory.plan, trajectory))


def view_of(
    drawing: Drawing, aspect: float, camera: tuple[float, float, float] | None = None
) -> View:
    """A camera that does not move and sees the robot all the time, as large as that allows.

    `aspect`: width / height of the picture; `camera`: azimuth and elevation, deg, and distance, m;
    None: from where the page looks, as far away as it takes.
    """
    centres, radii = drawing.spheres
    if camera is None:
        place, target = viewpoint(drawing.solid.robot)
        x, y, z = place - target
        turned = math.degrees(math.atan2(y, x)), math.degrees(math.atan2(z, math.hypot(x, y)))
    else:
        turned = camera[:2]
    axes = View(np.zeros(3), *turned, 1.0).axes
    seen = centres @ axes
    upright = math.radians(FIELD_OF_VIEW) / 2
    half = np.array([math.atan(aspect * math.tan(upright)), upright])
    # From the middle x0 of the picture, spheres are seen whole from beyond
    # z + (+-(x - x0) cos(a) + r) / sin(a), a to each side.
    sides = np.array([1.0, -1.0])[:, None, None] * seen[:, :2]
    least = seen[:, 2:] + (sides * np.cos(half) + radii[:, None]) / np.sin(half)
    most = least.max(axis=1)  # (2 sides, 2 directions)
    middle = (most[0] - most[1]) / 2 * np.tan(half)
    # What is looked at is as far away as the robot, so that a camera may turn around it.
    depth = float((seen[:, 2].min() + seen[:, 2].max()) / 2)
    distance = (float(most.mean(axis=0).max()) - depth) * _ROOM
    return View(axes @ [*middle, depth], *turned, distance if camera is None else float(camera[2]))
