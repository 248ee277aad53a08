"""The log that Foxglove, rerun and other viewers of MCAP read: `llsrbm.formats.logs.MCAP`."""

import json
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from foxglove import Channel, Context, channels, open_mcap
from foxglove import messages as fm
from numpy.typing import NDArray

from llsrbm.arrays import Array
from llsrbm.formats.logs.series import (
    GHOST,
    GROUND_SIZE,
    Series,
    logged,
    logged_plan,
    reference_series,
    series_of,
)
from llsrbm.look.palette import BLOCK, COM, FORCE, GROUND, PLANNED, Rgb
from llsrbm.look.shown_motion import ShownMotion, surroundings_of
from llsrbm.look.visuals import link_visuals
from llsrbm.mechanics import turned_to
from llsrbm.motion.block import Block
from llsrbm.motion.bodies import link_paths, urdf_joints
from llsrbm.motion.rollout import Rollout
from llsrbm.motion.surroundings import Surroundings
from llsrbm.motion.trajectory import Trajectory

Entry = tuple[int, Any, Any]
"""Ns, channel, message."""

WORLD, PLAN, DESCRIPTION = "world", "plan", "llsrbm.json"
_SHAFT, _HEAD = 0.016, 0.04  # m, diameters of an arrow
_HEAD_SHARE = 0.2  # of an arrow's length
_LEVEL = (1.0, 0.0, 0.0, 0.0)


def write(trajectory: Trajectory, path: Path, fps: float, about: dict[str, Any]) -> None:
    """Write the log; `about` is its description."""
    motion = logged(trajectory, fps)
    plan = logged_plan(trajectory, fps)
    # Channels and file belong to a context of their own: nothing reaches a server of the caller's.
    context = Context()
    with open_mcap(path, context=context) as writer:
        entries = list(_scene(context, surroundings_of(trajectory, motion.robot)))
        entries += _robot(context, motion, "", None)
        if plan is not None:
            entries += _robot(context, plan, PLAN, PLANNED)
        if isinstance(trajectory, Rollout):
            series = reference_series(trajectory, motion)
            entries += numbers(context, "/reference", motion.time, series)
        writer.write_metadata("llsrbm", flat(about))
        writer.attach(
            log_time=0,
            create_time=0,
            name=DESCRIPTION,
            media_type="application/json",
            data=json.dumps(about, allow_nan=False).encode(),
        )
        for time, channel, message in sorted(entries, key=lambda entry: entry[0]):
            channel.log(message, log_time=time)


def flat(data: dict[str, Any]) -> dict[str, str]:
    """Texts as they are, everything else as JSON: a metadata record holds nothing but texts."""
    return {key: v if isinstance(v, str) else json.dumps(v) for key, v in data.items()}


def _robot(context: Context, motion: ShownMotion, name: str, ghost: Rgb | None) -> Iterator[Entry]:
    """All topics of one robot, under `name`; drawn translucent in the colour `ghost`."""
    top = f"/{name}" if name else ""
    frames = f"{name}/" if name else ""
    yield from _transforms(context, motion, top, frames)
    yield from _meshes(context, motion, top, frames, ghost)
    yield from _joint_states(context, motion, top)
    yield from _poses(context, motion, top)
    yield from _inertia(context, motion, top)
    yield from _forces(context, motion, top)
    yield from numbers(context, f"{top}/state", motion.time, list(series_of(motion)))


def _transforms(context: Context, motion: ShownMotion, top: str, frames: str) -> Iterator[Entry]:
    paths = list(link_paths(motion.robot, motion.body_position, motion.body_wxyz))

    def message(k: int, time: int, *, moving: bool) -> fm.FrameTransforms:
        return fm.FrameTransforms(
            transforms=[
                fm.FrameTransform(
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
    context: Context, motion: ShownMotion, top: str, frames: str, ghost: Rgb | None
) -> Iterator[Entry]:
    channel = channels.SceneUpdateChannel(f"{top}/robot", context=context)
    entities = [
        fm.SceneEntity(
            timestamp=timestamp(0),
            frame_id=frames + visual.link,
            id=visual.link,
            frame_locked=True,
            triangles=[
                fm.TriangleListPrimitive(
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
    yield 0, channel, fm.SceneUpdate(entities=entities)


def _joint_states(context: Context, motion: ShownMotion, top: str) -> Iterator[Entry]:
    channel = channels.JointStatesChannel(f"{top}/joint_states", context=context)
    # Held joints too, or a viewer would draw those of its own URDF at zero.
    order, whole = urdf_joints(motion.robot), motion.motion
    position, velocity = order.position(whole).tolist(), order.velocity(whole).tolist()
    torque = whole.joint_torque
    for k, time in enumerate(nanoseconds(motion.time)):
        effort = [None if torque is None or at < 0 else float(torque[k, at]) for at in order.index]
        joints = [
            fm.JointState(name=name, position=q, velocity=v, effort=tau)
            for name, q, v, tau in zip(order.joints, position[k], velocity[k], effort, strict=True)
        ]
        yield time, channel, fm.JointStates(timestamp=timestamp(time), joints=joints)


def _poses(context: Context, motion: ShownMotion, top: str) -> Iterator[Entry]:
    whole = motion.motion
    base, com = (whole.base_position, whole.base_quat), (whole.com, motion.inertia_wxyz)
    for name, (position, quat) in {"base": base, "com": com}.items():
        channel = channels.PoseInFrameChannel(f"{top}/{name}", context=context)
        for k, time in enumerate(nanoseconds(motion.time)):
            placed = pose(position[k], quat[k])
            message = fm.PoseInFrame(timestamp=timestamp(time), frame_id=WORLD, pose=placed)
            yield time, channel, message


def _inertia(context: Context, motion: ShownMotion, top: str) -> Iterator[Entry]:
    channel = channels.SceneUpdateChannel(f"{top}/inertia", context=context)
    axes, quat = motion.inertia_axes, motion.inertia_wxyz
    com, look = motion.com, colour(COM, GHOST)
    for k, time in enumerate(nanoseconds(motion.time)):
        solid = fm.SpherePrimitive(pose=pose(com[k], quat[k]), size=vector(2 * axes[k]), color=look)
        yield time, channel, fm.SceneUpdate(entities=[_entity(time, "inertia", spheres=[solid])])


def _forces(context: Context, motion: ShownMotion, top: str) -> Iterator[Entry]:
    pressed_at = motion.pressed_at
    channel = channels.SceneUpdateChannel(f"{top}/contact_forces", context=context)
    arrows, look = motion.arrows, colour(FORCE)
    length, quat = np.linalg.norm(arrows, axis=2), turned_to(arrows, 0)
    for k, time in enumerate(nanoseconds(motion.time)):
        drawn = [
            fm.ArrowPrimitive(
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
        yield time, channel, fm.SceneUpdate(entities=[_entity(time, "forces", arrows=drawn)])


def _scene(context: Context, around: Surroundings) -> Iterator[Entry]:
    """A message at the beginning and one whenever something comes or goes, each with everything:
    who jumps to an instant in a viewer gets the last one before it, no more.
    """

    def cube(time: int, block: Block, rgb: Rgb) -> fm.SceneEntity:
        placed, size = pose(block.centre, block.quat), vector(block.size)
        shape = fm.CubePrimitive(pose=placed, size=size, color=colour(rgb))
        return _entity(time, block.name, cubes=[shape])

    channel = channels.SceneUpdateChannel("/scene", context=context)
    below = np.array([0.0, 0.0, around.ground - GROUND_SIZE[2] / 2])
    floor = Block("ground", below, np.array(GROUND_SIZE), 0.0)
    changes = {0.0, *(b.from_s for b in around.blocks), *(b.until_s for b in around.blocks)}
    for seconds in sorted(changes - {np.inf}):
        (time,) = nanoseconds(np.array([seconds]))
        there = [b for b in around.blocks if b.from_s <= seconds < b.until_s]
        kind = fm.SceneEntityDeletionType.MatchingId
        message = fm.SceneUpdate(
            deletions=[
                fm.SceneEntityDeletion(timestamp=timestamp(time), type=kind, id=block.name)
                for block in around.blocks
                if block not in there
            ],
            entities=[cube(time, floor, GROUND), *(cube(time, b, BLOCK) for b in there)],
        )
        yield time, channel, message


def _entity(time: int, name: str, **shapes: Any) -> fm.SceneEntity:
    return fm.SceneEntity(timestamp=timestamp(time), frame_id=WORLD, id=name, **shapes)


def numbers(
    context: Context, topic: str, times: Array, series: Sequence[Series]
) -> Iterator[Entry]:
    """Messages of named numbers as JSON, which plotters address as com.x; `times`: (K,) s."""
    schema = {"title": topic.strip("/"), **_schema(_tree((each.name, each) for each in series))}
    schema["properties"]["time"] = {"type": "number", "description": "s"}
    channel = Channel(topic, schema=schema, message_encoding="json", context=context)
    rows = [(each.name, each.parts, each.values.tolist()) for each in series]
    for k, time in enumerate(nanoseconds(times)):
        named = ((name, dict(zip(parts, row[k], strict=True))) for name, parts, row in rows)
        yield time, channel, {"time": float(times[k]), **_tree(named)}


def _tree(named: Iterable[tuple[str, Any]]) -> dict[str, Any]:
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


# ---- numbers as the parts that messages are made of


def nanoseconds(seconds: Array) -> list[int]:
    """Instants (K,) s as logs count them."""
    return np.round(seconds * 1e9).astype(np.int64).tolist()


def timestamp(time: int) -> fm.Timestamp:
    """An instant, ns."""
    return fm.Timestamp(*divmod(time, 1_000_000_000))


def vector(xyz: Iterable[float]) -> fm.Vector3:
    """(3,) of anything."""
    x, y, z = map(float, xyz)
    return fm.Vector3(x=x, y=y, z=z)


def points(xyz: Array) -> list[fm.Point3]:
    """(V, 3) m."""
    return [fm.Point3(x=x, y=y, z=z) for x, y, z in xyz.tolist()]


def quaternion(wxyz: Iterable[float]) -> fm.Quaternion:
    """(4,) w, x, y, z."""
    w, x, y, z = map(float, wxyz)
    return fm.Quaternion(x=x, y=y, z=z, w=w)


def pose(xyz: Iterable[float], wxyz: Iterable[float]) -> fm.Pose:
    """A place (3,) m and an attitude (4,) w, x, y, z."""
    return fm.Pose(position=vector(xyz), orientation=quaternion(wxyz))


def colour(rgb: Iterable[int], opacity: float = 1.0) -> fm.Color:
    """Foxglove's colour of parts from 0 to 255."""
    r, g, b = (float(part) / 255 for part in rgb)
    return fm.Color(r=r, g=g, b=b, a=opacity)


def colours(rgb: NDArray[np.uint8]) -> list[fm.Color]:
    """(V, 3) of 0 to 255; few of a mesh's differ."""
    distinct, which = np.unique(rgb, axis=0, return_inverse=True)
    palette = [colour(each) for each in distinct.tolist()]
    return [palette[i] for i in which.ravel().tolist()]
