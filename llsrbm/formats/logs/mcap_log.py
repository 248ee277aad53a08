"""A log for Foxglove, rerun and other viewers of MCAP: Foxglove's protobuf schemas.

Log time is ns from 0 at the motion's first instant; messages are 1/fps apart, and there are some
exactly at each lift-off and touchdown (of a rollout: at each change of contact, phase or mode).
Topics, of a rollout for the simulated robot, under /plan/ for the plan that it followed:
  /joint_states       foxglove.JointStates by name: rad or m, per s, effort = torque in Nm or N
  /tf, /tf_static     foxglove.FrameTransforms from link to link as in the URDF, "world" above the
                      root link, so a URDF layer moves; the plan's frames begin with "plan/", which
                      is the layer's frame prefix then
  /robot              foxglove.SceneUpdate once: the links' meshes, for viewers without the URDF
  /base, /com         foxglove.PoseInFrame in "world"; the CoM's turns with the inertia's axes
  /inertia            foxglove.SceneUpdate: the uniform solid of the same mass and inertia
  /contact_forces     foxglove.SceneUpdate: arrows, 0.8 m as large as the weight
  /state              JSON with a schema, to plot: CoM, momenta, principal moments, base, contacts,
                      forces, joints, torques as shares of their limits; com.x, foot_force.LF.z, ...
  /scene              foxglove.SceneUpdate: ground, box, board, as they come and go
  /reference          JSON, of a rollout: what the controller tracked
rerun draws /tf, /base and /com of it and keeps the rest as it is; format "rrd" has everything.
World frame, SI units; Foxglove's quaternions are x, y, z, w by name, without jumps of sign. Doubles
all through, meshes' too. Everything beside the numbers is the attachment llsrbm.json, and in parts
the metadata record "llsrbm".
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from llsrbm.analysis.inertia_ellipsoid import ellipsoid
from llsrbm.formats.base import Extra, Format, Options
from llsrbm.formats.logs.foxglove_messages import (
    colour,
    colours,
    nanoseconds,
    points,
    pose,
    quaternion,
    timestamp,
    turned_x_to,
    vector,
)
from llsrbm.formats.logs.logged import (
    GHOST,
    GROUND_SIZE,
    Logged,
    Series,
    ellipsoid_reference,
    logged,
    logged_plan,
    reference_series,
    standing_around,
)
from llsrbm.formats.sidecar import described
from llsrbm.look.palette import BLOCK, COM, FORCE, GROUND, PLANNED, Rgb
from llsrbm.look.visuals import link_visuals
from llsrbm.motion.link_paths import link_paths
from llsrbm.motion.rollout import Rollout
from llsrbm.motion.trajectory import Trajectory
from llsrbm.simulation.surroundings import Surroundings

if TYPE_CHECKING:
    from foxglove import Context

Array = NDArray[np.float64]
_Entry = tuple[int, Any, Any]  # ns, channel, message

WORLD = "world"
PLAN = "plan"
DESCRIPTION = "llsrbm.json"
_SHAFT, _HEAD = 0.016, 0.04  # m, diameters of an arrow
_HEAD_SHARE = 0.2  # of an arrow's length
_LEVEL = (1.0, 0.0, 0.0, 0.0)


def write_mcap(trajectory: Trajectory, path: Path, options: Options) -> None:
    """Write the log."""
    import foxglove

    motion = logged(trajectory, options.fps)
    plan = logged_plan(trajectory, options.fps)
    # Channels and file belong to a context of their own: nothing reaches a server of the caller's.
    context = foxglove.Context()
    with foxglove.open_mcap(path, context=context) as writer:
        entries = list(_scene(context, standing_around(trajectory, motion.robot)))
        entries += _robot(context, motion, "", None)
        if plan is not None:
            entries += _robot(context, plan, PLAN, PLANNED)
        if isinstance(trajectory, Rollout):
            series = reference_series(trajectory, motion)
            entries += _numbers(context, "/reference", motion.time, series)
        about = described(trajectory, MCAP.name, fps=options.fps, quaternion_order="xyzw")
        writer.write_metadata("llsrbm", _flat(about))
        writer.attach(
            log_time=0,
            create_time=0,
            name=DESCRIPTION,
            media_type="application/json",
            data=json.dumps(about, allow_nan=False).encode(),
        )
        for time, channel, message in sorted(entries, key=lambda entry: entry[0]):
            channel.log(message, log_time=time)


def _flat(data: dict[str, Any]) -> dict[str, str]:
    """Texts as they are, everything else as JSON: a metadata record holds nothing but texts."""
    return {key: v if isinstance(v, str) else json.dumps(v) for key, v in data.items()}


def _robot(context: Context, motion: Logged, name: str, ghost: Rgb | None) -> Iterator[_Entry]:
    """All topics of one robot, under `name`; drawn translucent in the colour `ghost`."""
    top = f"/{name}" if name else ""
    frames = f"{name}/" if name else ""
    yield from _transforms(context, motion, top, frames)
    yield from _meshes(context, motion, top, frames, ghost)
    yield from _joint_states(context, motion, top)
    yield from _poses(context, motion, top)
    yield from _inertia(context, motion, top)
    yield from _forces(context, motion, top)
    yield from _numbers(context, f"{top}/state", motion.time, motion.series)


def _transforms(context: Context, motion: Logged, top: str, frames: str) -> Iterator[_Entry]:
    from foxglove import channels
    from foxglove.messages import FrameTransform, FrameTransforms

    paths = list(link_paths(motion.robot, motion.body_position, motion.body_quat, WORLD))

    def message(k: int, time: int, *, moving: bool) -> FrameTransforms:
        return FrameTransforms(
            transforms=[
                FrameTransform(
                    timestamp=timestamp(time),
                    parent_frame_id=path.parent if path.parent == WORLD else frames + path.parent,
                    child_frame_id=frames + path.link,
                    translation=vector(path.position[k]),
                    rotation=quaternion(path.quat[k]),
                )
                for path in paths
                if path.moves is moving
            ]
        )

    still = channels.FrameTransformsChannel(f"{top}/tf_static", context=context)
    yield 0, still, message(0, 0, moving=False)
    channel = channels.FrameTransformsChannel(f"{top}/tf", context=context)
    for k, time in enumerate(nanoseconds(motion.time)):
        yield time, channel, message(k, time, moving=True)


def _meshes(
    context: Context, motion: Logged, top: str, frames: str, ghost: Rgb | None
) -> Iterator[_Entry]:
    from foxglove import channels
    from foxglove.messages import SceneEntity, SceneUpdate, TriangleListPrimitive

    channel = channels.SceneUpdateChannel(f"{top}/robot", context=context)
    entities = [
        SceneEntity(
            timestamp=timestamp(0),
            frame_id=frames + visual.link,
            id=visual.link,
            frame_locked=True,
            triangles=[
                TriangleListPrimitive(
                    pose=pose((0.0, 0.0, 0.0), _LEVEL),
                    points=points(visual.vertices.astype(np.float64)),
                    indices=visual.faces.ravel().tolist(),
                    colors=colours(visual.rgb) if ghost is None else None,
                    color=None if ghost is None else colour(ghost, GHOST),
                )
            ],
        )
        for visual in link_visuals(motion.robot, coarse=True)
    ]
    yield 0, channel, SceneUpdate(entities=entities)


def _joint_states(context: Context, motion: Logged, top: str) -> Iterator[_Entry]:
    from foxglove import channels
    from foxglove.messages import JointState, JointStates

    channel = channels.JointStatesChannel(f"{top}/joint_states", context=context)
    names, whole = motion.robot.joint_names, motion.motion
    position, velocity = whole.joint_position.tolist(), whole.joint_velocity.tolist()
    none = [[None] * len(names)] * len(position)
    torque = none if whole.joint_torque is None else whole.joint_torque.tolist()
    for k, time in enumerate(nanoseconds(motion.time)):
        joints = [
            JointState(name=name, position=q, velocity=v, effort=tau)
            for name, q, v, tau in zip(names, position[k], velocity[k], torque[k], strict=True)
        ]
        yield time, channel, JointStates(timestamp=timestamp(time), joints=joints)


def _poses(context: Context, motion: Logged, top: str) -> Iterator[_Entry]:
    from foxglove import channels
    from foxglove.messages import PoseInFrame

    whole = motion.motion
    _, turned = _ellipsoid(motion)
    for name, position, quat in (
        ("base", whole.base_position, whole.base_quat),
        ("com", whole.com, turned),
    ):
        channel = channels.PoseInFrameChannel(f"{top}/{name}", context=context)
        for k, time in enumerate(nanoseconds(motion.time)):
            placed = pose(position[k], quat[k])
            message = PoseInFrame(timestamp=timestamp(time), frame_id=WORLD, pose=placed)
            yield time, channel, message


def _inertia(context: Context, motion: Logged, top: str) -> Iterator[_Entry]:
    from foxglove import channels
    from foxglove.messages import SceneEntity, SceneUpdate, SpherePrimitive

    channel = channels.SceneUpdateChannel(f"{top}/inertia", context=context)
    axes, quat = _ellipsoid(motion)
    com, look = motion.motion.com, colour(COM, GHOST)
    for k, time in enumerate(nanoseconds(motion.time)):
        solid = SpherePrimitive(pose=pose(com[k], quat[k]), size=vector(2 * axes[k]), color=look)
        entity = SceneEntity(
            timestamp=timestamp(time), frame_id=WORLD, id="inertia", spheres=[solid]
        )
        yield time, channel, SceneUpdate(entities=[entity])


def _forces(context: Context, motion: Logged, top: str) -> Iterator[_Entry]:
    from foxglove import channels
    from foxglove.messages import ArrowPrimitive, SceneEntity, SceneUpdate

    pressed_at = motion.motion.pressed_at
    if pressed_at is None:
        return
    channel = channels.SceneUpdateChannel(f"{top}/contact_forces", context=context)
    arrows, look = motion.arrows, colour(FORCE)
    length, quat = np.linalg.norm(arrows, axis=2), turned_x_to(arrows)
    for k, time in enumerate(nanoseconds(motion.time)):
        drawn = [
            ArrowPrimitive(
                pose=pose(pressed_at[k, i], quat[k, i]),
                shaft_length=float((1 - _HEAD_SHARE) * length[k, i]),
                shaft_diameter=_SHAFT,
                head_length=float(_HEAD_SHARE * length[k, i]),
                head_diameter=_HEAD,
                color=look,
            )
            for i in np.flatnonzero(length[k])
        ]
        # Without arrows it takes away those of the message before.
        entity = SceneEntity(timestamp=timestamp(time), frame_id=WORLD, id="forces", arrows=drawn)
        yield time, channel, SceneUpdate(entities=[entity])


def _scene(context: Context, around: Surroundings) -> Iterator[_Entry]:
    """A message at the beginning and one whenever something comes or goes, each with everything:
    who jumps to an instant in a viewer gets the last one before it, no more.
    """
    from foxglove import channels
    from foxglove.messages import (
        CubePrimitive,
        SceneEntity,
        SceneEntityDeletion,
        SceneEntityDeletionType,
        SceneUpdate,
    )

    def entity(
        time: int, name: str, centre: Array, size: Array, yaw: float, rgb: Rgb
    ) -> SceneEntity:
        turned = (np.cos(yaw / 2), 0.0, 0.0, np.sin(yaw / 2))
        cube = CubePrimitive(pose=pose(centre, turned), size=vector(size), color=colour(rgb))
        return SceneEntity(timestamp=timestamp(time), frame_id=WORLD, id=name, cubes=[cube])

    channel = channels.SceneUpdateChannel("/scene", context=context)
    floor = np.array([0.0, 0.0, around.ground - GROUND_SIZE[2] / 2])
    changes = {0.0, *(b.from_s for b in around.blocks), *(b.until_s for b in around.blocks)}
    for seconds in sorted(changes - {np.inf}):
        (time,) = nanoseconds(np.array([seconds]))
        there = [b for b in around.blocks if b.from_s <= seconds < b.until_s]
        kind = SceneEntityDeletionType.MatchingId
        message = SceneUpdate(
            deletions=[
                SceneEntityDeletion(timestamp=timestamp(time), type=kind, id=block.name)
                for block in around.blocks
                if block not in there
            ],
            entities=[
                entity(time, "ground", floor, np.array(GROUND_SIZE), 0.0, GROUND),
                *(entity(time, b.name, b.centre, b.size, b.yaw, BLOCK) for b in there),
            ],
        )
        yield time, channel, message


def _numbers(
    context: Context, topic: str, times: Array, series: Sequence[Series]
) -> Iterator[_Entry]:
    """Named numbers as JSON, which plotters address as com.x."""
    from foxglove import Channel

    schema = {"title": topic.strip("/"), **_schema(_tree((each.name, each) for each in series))}
    schema["properties"]["time"] = {"type": "number", "description": "s"}
    channel = Channel(topic, schema=schema, message_encoding="json", context=context)
    rows = [(each.name, each.parts, each.values.tolist()) for each in series]
    for k, time in enumerate(nanoseconds(times)):
        named = ((name, dict(zip(parts, row[k], strict=True))) for name, parts, row in rows)
        yield time, channel, {"time": float(times[k]), **_tree(named)}


def _tree(named: Iterable[tuple[str, Any]]) -> dict[str, Any]:
    """Names with slashes as nested objects."""
    tree: dict[str, Any] = {}
    for path, value in named:
        *above, last = path.split("/")
        at = tree
        for name in above:
            at = at.setdefault(name, {})
        at[last] = value
    return tree


def _schema(node: Series | dict[str, Any]) -> dict[str, Any]:
    if isinstance(node, Series):
        number = {"type": "number", "description": node.unit}
        return {"type": "object", "properties": dict.fromkeys(node.parts, number)}
    return {"type": "object", "properties": {name: _schema(part) for name, part in node.items()}}


def _ellipsoid(motion: Logged) -> tuple[Array, Array]:
    whole = motion.motion
    return ellipsoid(whole.inertia, motion.mass, ellipsoid_reference(whole))


MCAP = Format(
    name="mcap",
    title="a log for Foxglove and other viewers: joint states, transforms, forces, numbers to plot",
    suffix=".mcap",
    write=write_mcap,
    conventions=__doc__,
    options=("fps",),
    defaults=Options(fps=200.0),
    extra=Extra("mcap", ("foxglove",)),
)
