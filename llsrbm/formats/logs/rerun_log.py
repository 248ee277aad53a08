"""The recording that the rerun viewer reads: `llsrbm.formats.logs.RRD`."""

import json
import tempfile
from collections.abc import Iterable
from functools import lru_cache
from pathlib import Path
from typing import Any
from uuid import uuid4

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
import rerun_bindings

from llsrbm.arrays import Array
from llsrbm.errors import InputError
from llsrbm.formats.logs.series import (
    GHOST,
    GROUND_SIZE,
    Series,
    logged,
    logged_plan,
    reference_series,
    series_of,
)
from llsrbm.look.palette import BLOCK, COM, FOOT, FORCE, GROUND, PLANNED, Rgb
from llsrbm.look.shown_motion import ShownMotion, surroundings_of
from llsrbm.look.visuals import link_visuals
from llsrbm.motion.rollout import Rollout
from llsrbm.motion.surroundings import Surroundings
from llsrbm.motion.trajectory import Trajectory

APPLICATION = "llsrbm"
TIMELINE = "time"
_COM_RADIUS = 0.018  # m
_TRAIL_RADIUS = 0.003
_ARROW_RADIUS = 0.008

_OWN, _PLANNED, _TRACKED = "plots", "planned", "tracked"
_LIGHTER = {_OWN: 0.0, _PLANNED: 0.55, _TRACKED: 0.75}  # share of the way to white
_LINE_COLOURS: tuple[Rgb, ...] = (
    (214, 51, 60),
    (60, 150, 60),
    (44, 100, 229),
    (222, 140, 16),
    (120, 60, 190),
    (20, 150, 160),
)
_PLOTS = (
    ("com", "linear_momentum", "angular_momentum", "principal_moments"),
    ("foot_force", "contact", "torque_share", "joint_position"),
)
_MANY = _PLOTS[1]
_CAMERA = np.array([2.6, -3.4, 1.6])  # from the base, in heights of it


def write(trajectory: Trajectory, path: Path, fps: float, about: dict[str, Any]) -> None:
    """Write the recording; `about` is its description."""
    motion = logged(trajectory, fps)
    plan = logged_plan(trajectory, fps)
    # One of its own: the caller may be recording something else.
    recording = rr.RecordingStream(APPLICATION, recording_id=uuid4(), send_properties=False)
    if not rr.is_enabled(recording):
        raise InputError("rerun is switched off by the environment variable RERUN; expected on")
    try:
        recording.save(path)
        series = list(series_of(motion))
        shown = frozenset(each.name.split("/")[0] for each in series)
        layout = _layout(shown, float(motion.robot.base_position[2]))
        recording.log_file_from_contents("layout.rbl", layout, static=True)
        recording.send_recording_name(f"{about['robot'].get('name', '')} {about['kind']}")
        recording.log("world", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True, strict=True)
        _log_description(recording, about)
        _log_surroundings(recording, surroundings_of(trajectory, motion.robot))
        _log_robot(recording, "world/robot", motion, None)
        _log_with_robot(recording, motion)
        _log_series(recording, _OWN, motion.time, series)
        if plan is not None:
            _log_robot(recording, "world/plan", plan, PLANNED)
            _log_series(recording, _PLANNED, plan.time, series_of(plan))
        if isinstance(trajectory, Rollout):
            tracked = reference_series(trajectory, motion)
            _log_series(recording, _TRACKED, motion.time, tracked)
    finally:
        recording.flush()
        recording.disconnect()  # closes the file
        del recording
        # As `rerun.init` does: otherwise two threads wait for more until the process ends.
        rerun_bindings.flush_and_cleanup_orphaned_recordings()


def _log_description(recording: rr.RecordingStream, about: dict[str, Any]) -> None:
    text = json.dumps(about, indent=1, allow_nan=False)
    request = ", ".join(f"{name} {value}" for name, value in about["request"].items())
    lines = [
        f"# {about['robot'].get('name', '')}: {about['kind']}",
        "",
        f"- request: {request}",
        f"- model: {about['model']}",
        *(f"- {name}: {_status(about[name])}" for name in ("solver", "outcome") if name in about),
        f"- world frame: {about['world_frame']}",
        f"- units: {about['units']}",
        f"- llsrbm {about['package_version']}",
    ]
    markdown = rr.TextDocument("\n".join(lines), media_type=rr.MediaType.MARKDOWN)
    recording.log("description", markdown, static=True, strict=True)
    recording.log(
        "description/json", rr.TextDocument(text, media_type="application/json"), static=True
    )


def _status(part: dict[str, Any]) -> str:
    return part["status"] + (f", {part['reason']}" if part.get("reason") else "")


def _log_surroundings(recording: rr.RecordingStream, around: Surroundings) -> None:
    floor = rr.Boxes3D(
        centers=[[0.0, 0.0, around.ground - GROUND_SIZE[2] / 2]],
        sizes=[GROUND_SIZE],
        colors=[GROUND],
        fill_mode=rr.components.FillMode.Solid,
    )
    recording.log("world/ground", floor, static=True, strict=True)
    for block in around.blocks:
        columns = rr.Boxes3D.columns(
            centers=[block.centre],
            half_sizes=[block.size / 2],
            quaternions=[_xyzw(block.quat)],
            colors=[BLOCK],
            fill_mode=[rr.components.FillMode.Solid],
        )
        comes_and_goes = np.array([block.from_s, block.until_s])
        there = np.isfinite(comes_and_goes)
        shown = columns.partition(np.array([1, 0])[there])
        # A path has no spaces of its own: "box-1".
        entity = f"world/blocks/{block.name.replace(' ', '-')}"
        _send(recording, entity, comes_and_goes[there], shown)


def _log_robot(
    recording: rr.RecordingStream, entity: str, motion: ShownMotion, ghost: Rgb | None
) -> None:
    """Meshes where the bodies are; translucent in the colour `ghost`, with fewer faces then."""
    for visual in link_visuals(motion.robot, coarse=ghost is not None):
        if ghost is None:
            look: dict[str, Any] = {"vertex_colors": visual.rgb}
        else:
            look = {"albedo_factor": [*ghost, round(255 * GHOST)]}
        mesh = rr.Mesh3D(
            vertex_positions=visual.vertices,
            vertex_normals=visual.normals,
            triangle_indices=visual.faces,
            **look,
        )
        recording.log(f"{entity}/{visual.link}", mesh, static=True, strict=True)
        poses = motion.poses([visual])[:, 0]
        columns = rr.Transform3D.columns(translation=poses[:, :3], quaternion=_xyzw(poses[:, 3:]))
        _send(recording, f"{entity}/{visual.link}", motion.time, columns)


def _log_with_robot(recording: rr.RecordingStream, motion: ShownMotion) -> None:
    whole, time = motion.motion, motion.time
    point = rr.Points3D([[0.0, 0.0, 0.0]], colors=[COM], radii=[_COM_RADIUS])
    recording.log("world/com", point, static=True, strict=True)
    _send(recording, "world/com", time, rr.Points3D.columns(positions=whole.com))

    axes, quat = motion.inertia_axes, motion.inertia_wxyz
    look = rr.Ellipsoids3D.from_fields(colors=[PLANNED if whole.origin == "plan" else COM])
    recording.log("world/inertia", look, static=True, strict=True)
    columns = rr.Ellipsoids3D.columns(half_sizes=axes, centers=whole.com, quaternions=_xyzw(quat))
    _send(recording, "world/inertia", time, columns)

    legs = motion.robot.leg_names
    arrows = motion.arrows
    for i, leg in enumerate(legs):
        thin = rr.Arrows3D.from_fields(colors=[FORCE], radii=[_ARROW_RADIUS])
        recording.log(f"world/forces/{leg}", thin, static=True, strict=True)
        pushing = arrows[:, i].any(axis=1)
        columns = rr.Arrows3D.columns(
            vectors=arrows[pushing, i], origins=motion.pressed_at[pushing, i]
        )
        # No arrow at the instants at which the foot does not push.
        _send(recording, f"world/forces/{leg}", time, columns.partition(pushing.astype(int)))

    paths = {"com": (whole.com, COM)}
    paths |= {leg: (whole.foot_position[:, i], FOOT) for i, leg in enumerate(legs)}
    for name, (points, colour) in paths.items():
        trail = rr.LineStrips3D([points], colors=[colour], radii=[_TRAIL_RADIUS])
        recording.log(f"world/trails/{name}", trail, static=True, strict=True)


def _log_series(
    recording: rr.RecordingStream, top: str, time: Array, series: Iterable[Series]
) -> None:
    suffix = "" if top == _OWN else f" {top}"
    palette = [
        tuple(round(c + _LIGHTER[top] * (255 - c)) for c in colour) for colour in _LINE_COLOURS
    ]
    for each in series:
        entity = f"{top}/{each.name}"
        lines = rr.SeriesLines(
            names=[f"{part}{suffix}" for part in each.parts],
            colors=[palette[i % len(palette)] for i in range(len(each.parts))],
        )
        recording.log(entity, lines, rr.AnyValues(unit=each.unit), static=True, strict=True)
        _send(recording, entity, time, rr.Scalars.columns(scalars=each.values))


@lru_cache
def _layout(shown: frozenset[str], height: float) -> bytes:
    """The views of a recording that has these series, as a file of rerun's.

    Made once and logged as a file: rerun keeps two threads for every layout that it makes.

    Args:
        shown: first words of the series' names.
        height: of the robot's base, m: tells how far the camera stands.
    """

    def plot(name: str) -> rrb.TimeSeriesView:
        # Where there is a line a leg or joint, a legend would hide them; the mouse tells names.
        legend = rrb.PlotLegend(rrb.Corner2D.RightTop, visible=name not in _MANY)
        contents = [f"/{top}/{name}/**" for top in (_OWN, _PLANNED)]
        title = name.replace("_", " ")
        return rrb.TimeSeriesView(origin="/", contents=contents, name=title, plot_legend=legend)

    columns = [rrb.Vertical(*(plot(name) for name in names if name in shown)) for names in _PLOTS]
    target = np.array([0.0, 0.0, height])
    eye = rrb.EyeControls3D(position=target + height * _CAMERA, look_target=target)
    scene = rrb.Spatial3DView(origin="/world", name="robot", eye_controls=eye)
    text = rrb.TextDocumentView(origin="/description", contents="$origin", name="description")
    layout = rrb.Blueprint(
        rrb.Horizontal(
            rrb.Vertical(scene, text, row_shares=[3, 1]), *columns, column_shares=[2, 1, 1]
        ),
        rrb.TimePanel(timeline=TIMELINE, state="collapsed", loop_mode="all"),
        collapse_panels=True,
    )
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "layout.rbl"
        layout.save(APPLICATION, str(file))
        return file.read_bytes()


def _send(
    recording: rr.RecordingStream, entity: str, time: Array, columns: Iterable[rr.ComponentColumn]
) -> None:
    ns = np.round(time * 1e9).astype("timedelta64[ns]")
    recording.send_columns(
        entity, indexes=[rr.TimeColumn(TIMELINE, duration=ns)], columns=columns, strict=True
    )


def _xyzw(quat: Array) -> Array:
    return quat[..., [1, 2, 3, 0]]
