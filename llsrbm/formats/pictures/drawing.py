"""A motion ready to be drawn by whatever draws: the replay in a browser, a video."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from llsrbm.analysis.wording import outcome_words
from llsrbm.errors import InputError
from llsrbm.formats.shown import Bodies, ellipsoid_of, mass_of, surroundings_of
from llsrbm.look import palette
from llsrbm.look.palette import Rgb
from llsrbm.look.timeline import Timeline, timeline
from llsrbm.look.titles import title_of
from llsrbm.look.visuals import LinkVisual, link_visuals, viewpoint
from llsrbm.mechanics import rotation_matrices, sign_continuous
from llsrbm.motion.plan import Plan
from llsrbm.motion.sampling import evenly, resample, with_events
from llsrbm.motion.trajectory import Trajectory
from llsrbm.motion.whole_body import WholeBodyMotion, whole_body_motion
from llsrbm.request.jump import Jump
from llsrbm.robots import Robot
from llsrbm.simulation.surroundings import Surroundings

Array = NDArray[np.float64]

FIELD_OF_VIEW = 36.0  # deg, upright
LEAST_FORCE = 1.0  # N; smaller ones are not drawn
_ROOM = 1.06  # a little more than what the robot needs


@dataclass(frozen=True, eq=False)
class Drawing:
    """A motion to be drawn at K instants, world frame: L legs.

    Attributes:
        motion: at these instants; time: (K,) s of the motion's own time.
        title: the request, in words; outcome: the result, in words.
        solid: the robot that moves; ghost: the plan that it followed, if that is another motion.
        axes: (K, 3) m and axes_quat: (K, 4): ellipsoid of the inertia about the CoM.
        force: (K, L, 3) N and pressed_at: (K, L, 3) m; of a rollout means from frame to frame.
        surroundings, timeline: ground and blocks; phases and events.
        colour: of the solid one.
    """

    motion: WholeBodyMotion
    time: Array
    title: str
    outcome: str
    solid: Bodies
    ghost: Bodies | None
    axes: Array
    axes_quat: Array
    force: Array
    pressed_at: Array
    surroundings: Surroundings
    timeline: Timeline
    colour: Rgb

    @property
    def robot(self) -> Robot:
        """That is drawn."""
        return self.motion.robot

    @property
    def flight(self) -> NDArray[np.bool_]:
        """(K,) whether no foot stands."""
        return np.asarray(~self.motion.contact.any(axis=1))

    @property
    def visuals(self) -> tuple[LinkVisual, ...]:
        """The robot's meshes."""
        return link_visuals(self.robot)

    @property
    def arrays(self) -> dict[str, Array]:
        """Everything that moves, over time; `ghost` only where there is one.

        `time`, `com`; `solid`, `ghost` (K, bodies with meshes, 7): position and quaternion;
        `ellipsoid` (K, 7): semi-axes and quaternion; `force` (K, L, 6): where it acts, and N.
        """
        arrays = {
            "time": self.time,
            "solid": self.solid.poses(self.visuals),
            "com": self.motion.com,
            "ellipsoid": np.hstack([self.axes, sign_continuous(self.axes_quat)]),
            "force": np.concatenate([self.pressed_at, self.force], axis=2),
        }
        if self.ghost is not None:
            arrays["ghost"] = self.ghost.poses(self.visuals)
        return arrays

    @property
    def arrow_per_newton(self) -> float:
        """m: a force as large as the weight is as long as the standing robot's CoM is high."""
        gravity = float(np.linalg.norm(self.robot.model.gravity.linear))
        return float(self.robot.com[2]) / (self.robot.mass * gravity)

    @cached_property
    def spheres(self) -> tuple[Array, Array]:
        """(n, 3) m and (n,) m: spheres that hold all the places where the robot gets."""
        centres, radii = [], []
        for bodies in filter(None, (self.solid, self.ghost)):
            for visual in self.visuals:
                low, high = visual.vertices.min(axis=0), visual.vertices.max(axis=0)
                body = visual.joint_id - 1
                R = rotation_matrices(bodies.quat[:, body])
                centres.append(bodies.position[:, body] + R @ ((low + high) / 2))
                radii.append(np.full(len(R), np.linalg.norm(high - low) / 2))
        if not centres:  # a robot without meshes
            return self.motion.com, np.full(len(self.time), float(self.robot.com[2]))
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


def draw(
    trajectory: Trajectory, fps: float, pad: float = 0.0, *, with_instants: bool = False
) -> Drawing:
    """Everything that is drawn of a plan or a rollout.

    `with_instants`: have those as well at which contacts change; nothing is padded then.

    Raises:
        InputError: as `whole_body_motion` does, or the motion has numbers that are none.
        RobotFileError: the robot is not there.
    """
    for name in ("time", "com", "base_position", "base_quat", "joint_position", "inertia"):
        if not np.isfinite(getattr(trajectory, name)).all():  # a solver may have diverged
            raise InputError(f"{name} is not finite everywhere; expected a motion to be drawn")
    motion = whole_body_motion(trajectory, fps, pad, events=with_instants)
    time = with_events(trajectory, fps) if with_instants else evenly(trajectory, fps, pad)
    robot = motion.robot
    rollout = None if isinstance(trajectory, Plan) else trajectory
    plan = trajectory if isinstance(trajectory, Plan) else trajectory.plan
    axes, axes_quat = ellipsoid_of(motion, mass_of(trajectory, robot))
    assert motion.foot_force is not None  # plans and rollouts have them
    assert motion.pressed_at is not None
    force, ghost = motion.foot_force, None
    if rollout is not None:
        force = _means(rollout.time, rollout.contact_force, time, force)
        sampled = resample(plan, time)
        order = [plan.joint_names.index(name) for name in robot.joint_names]
        ghost = Bodies.of(robot, sampled, sampled.joint_position[:, order])
    return Drawing(
        motion=motion,
        time=time,
        title=title(trajectory),
        outcome=outcome_words(trajectory),
        solid=Bodies.of(robot, motion, motion.joint_position),
        ghost=ghost,
        axes=axes,
        axes_quat=axes_quat,
        force=force,
        pressed_at=motion.pressed_at,
        surroundings=surroundings_of(trajectory, robot),
        timeline=timeline(plan, rollout),
        colour=palette.PLANNED if rollout is None else palette.SIMULATED,
    )


def view_of(
    drawing: Drawing, aspect: float, camera: tuple[float, float, float] | None = None
) -> View:
    """A camera that does not move and sees the robot all the time, as large as that allows.

    `aspect`: width / height of the picture; `camera`: azimuth and elevation, deg, and distance, m;
    None: from where the page looks, as far away as it takes.
    """
    centres, radii = drawing.spheres
    if camera is None:
        place, target = viewpoint(drawing.robot)
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


def _means(ticks: Array, values: Array, time: Array, sampled: Array) -> Array:
    """Of `values` (T, ...), held from tick to tick, from each of `time` (K,) to the next.

    `sampled` (K, ...) is taken where there is no next, or no tick.
    """
    flat = values.reshape(len(values), -1)
    total = np.vstack([np.zeros(flat.shape[1]), np.cumsum(np.diff(ticks)[:, None] * flat[:-1], 0)])
    sums = np.stack([np.interp(time, ticks, column) for column in total.T], axis=1)
    means = np.diff(sums, axis=0) / np.diff(time)[:, None]
    within = (time[:-1] >= ticks[0] - 1e-9) & (time[1:] <= ticks[-1] + 1e-9)
    result = sampled.copy()
    result[:-1][within] = means.reshape(len(means), *values.shape[1:])[within]
    return result


def title(trajectory: Trajectory) -> str:
    """Robot, jump and model, whatever robot it is."""
    jump = trajectory.jump
    plain = replace(jump, robot=Jump().robot)
    if isinstance(trajectory, Plan):
        task = title_of(plain, trajectory.tuning)
    else:
        task = title_of(plain, trajectory.plan.tuning, trajectory.scenario)
    return f"{Path(jump.robot).stem}: {task}"
