"""One page that plays the motion from disk: no server, no network, no installation.

Robot, contact forces, inertia ellipsoid, trails, ground and boxes; of a rollout also its plan as a
ghost, where the file holds it, and the board. A timeline with phases and events; space plays,
arrows step, mouse or fingers turn, move and zoom. The ellipsoid is that of the uniform solid with
the robot's mass and inertia, of a plan the model's, of a rollout the whole body's. An arrow as long
as the standing robot's CoM is high is a force as large as its weight; of a rollout, forces are
means from frame to frame. World frame, x forward, y left, z up, m.

Needs WebGL2 and DecompressionStream: browsers of 2023 and later. It draws with WebGL2 itself: a
scene of viser's has no timeline and no layers, three.js would be 0.7 MB of foreign code to keep.
"""

from __future__ import annotations

import base64
import gzip
import hashlib
import json
import math
from html import escape
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Any

import numpy as np
from numpy.typing import NDArray

from llsrbm.formats.base import Format, Options
from llsrbm.formats.pictures.drawing import (
    FIELD_OF_VIEW,
    LEAST_FORCE,
    Bodies,
    Drawing,
    draw,
    view_of,
)
from llsrbm.installed import package_version
from llsrbm.look import palette
from llsrbm.look.palette import Rgb, css
from llsrbm.look.timeline import Timeline
from llsrbm.look.visuals import LinkVisual
from llsrbm.mechanics import sign_continuous
from llsrbm.motion.plan import Plan
from llsrbm.motion.trajectory import Trajectory, description

_ASPECT = 16 / 9  # of the window that the camera is placed for
_BARS = 1.2  # of the distance: title and timeline cover a part of the picture
_PAGE = "replay_page"
_SCRIPTS = ("renderer.js", "replay.js")
_ALIGNED = 4  # bytes, at which typed arrays may begin


def write_html(trajectory: Trajectory, path: Path, options: Options) -> None:
    """Write the page."""
    drawing = draw(trajectory, options.fps, with_instants=True)
    numbers, listed = _packed(_arrays(drawing))
    facts = _facts(drawing, trajectory, options.camera) | {"arrays": listed}
    style, script = _asset("style.css"), "\n".join(_asset(name) for name in _SCRIPTS)
    page = Template(_asset("page.html")).substitute(
        # Whatever a file may bring along, nothing but this script runs and nothing is asked for.
        policy=(
            "default-src 'none'; connect-src 'none'; img-src data:; "
            f"script-src {_digest(script)}; style-src {_digest(style)}"
        ),
        version=escape(package_version()),
        title=escape(drawing.title),
        style=style,
        facts=_json(facts),
        numbers=numbers,
        script=script,
    )
    path.write_text(page, encoding="utf-8")


def _facts(
    drawing: Drawing, trajectory: Trajectory, camera: tuple[float, float, float] | None
) -> dict[str, Any]:
    """What the page's script reads besides the arrays."""
    view = view_of(drawing, _ASPECT, camera)
    size = float(drawing.robot.com[2])
    good = trajectory.solved if isinstance(trajectory, Plan) else trajectory.landed
    return {
        "title": drawing.title,
        "told": drawing.told,
        "bad": not good,
        "rollout": not isinstance(trajectory, Plan),
        "legs": len(drawing.robot.legs),
        "bodies": [
            {
                "name": fine.link,
                "fine": {"points": len(fine.vertices), "faces": len(fine.faces)},
                "coarse": {"points": len(coarse.vertices), "faces": len(coarse.faces)},
            }
            for fine, coarse in zip(drawing.visuals, drawing.coarse_visuals, strict=True)
        ],
        "meshUnit": _mesh_unit(drawing.visuals),
        "ground": drawing.surroundings.ground,
        "span": 2.2 * size + 0.3,
        "blocks": [
            {
                "centre": block.centre.tolist(),
                "size": block.size.tolist(),
                "yaw": block.yaw,
                "from": block.from_s,
                "until": block.until_s if math.isfinite(block.until_s) else None,
            }
            for block in drawing.surroundings.blocks
        ],
        "camera": {
            "target": view.target.tolist(),
            "azimuth": view.azimuth,
            "elevation": view.elevation,
            "distance": view.distance * (1.0 if camera else _BARS),
            "fieldOfView": math.radians(FIELD_OF_VIEW),
            "aspect": _ASPECT,
        },
        "arrow": {
            "perNewton": drawing.arrow_per_newton,
            "least": LEAST_FORCE,
            "thickness": 0.016 * size,
        },
        "colours": {
            "planned": _share(palette.PLANNED),
            "ellipsoid": _share(drawing.colour),
            "force": _share(palette.FORCE),
            "com": _share(palette.COM),
            "foot": _share(palette.FOOT),
            "block": _share(palette.BLOCK),
        },
        "timeline": _timeline(drawing.timeline),
        "description": description(trajectory),
    }


def _timeline(events: Timeline) -> dict[str, Any]:
    return {
        "told": events.told,
        "rows": [
            {
                "name": row.name,
                "pieces": [
                    {
                        "name": piece.name,
                        "start": piece.start,
                        "end": piece.end,
                        "colour": css(piece.colour),
                        "low": piece.low,
                        "feet": piece.feet,
                    }
                    for piece in row.pieces
                ],
            }
            for row in events.rows
        ],
        "marks": [
            {
                "name": mark.name,
                "time": mark.time,
                "colour": css(mark.colour),
                "simulated": mark.colour != palette.PLANNED,
            }
            for mark in events.marks
        ],
    }


def _arrays(drawing: Drawing) -> dict[str, NDArray[Any]]:
    """Meshes and motion; what the script sends to the graphics processor has rows of four."""
    visuals = drawing.visuals
    single = np.float32
    arrays: dict[str, NDArray[Any]] = {
        "time": drawing.time.astype(single),
        "solid": _poses(drawing.solid, visuals),
        "com": drawing.solid.com.astype(single),
        "ellipsoid": np.hstack([drawing.axes, sign_continuous(drawing.axes_quat)]).astype(single),
        "foot": drawing.foot.astype(single),
        "flight": drawing.flight.astype(np.uint8),
        "force": np.concatenate([drawing.pressed_at, drawing.force], axis=2).astype(single),
    }
    unit = _mesh_unit(visuals)
    # The coarse ones are ghosts, cast shadows, and are all that is drawn without a graphics card.
    arrays |= _meshes("fine", visuals, unit) | _meshes("coarse", drawing.coarse_visuals, unit)
    if drawing.ghost is not None:
        arrays["ghost"] = _poses(drawing.ghost, visuals)
        arrays["ghost_com"] = drawing.ghost.com.astype(single)
    return arrays


def _meshes(name: str, visuals: tuple[LinkVisual, ...], unit: float) -> dict[str, NDArray[Any]]:
    faces = np.concatenate([np.zeros((0, 3)), *(visual.faces for visual in visuals)])
    return {
        f"{name}_points": _four(visuals, "vertices", np.int16, 1 / unit),
        f"{name}_normals": _four(visuals, "normals", np.int8, 127.0),
        f"{name}_paint": _four(visuals, "rgb", np.uint8, 1.0),
        f"{name}_faces": faces.astype(np.uint32),
    }


def _mesh_unit(visuals: tuple[LinkVisual, ...]) -> float:
    """m: points are 16 bit shares of it, which are a few hundredths of a millimetre apart."""
    return max((float(np.abs(visual.vertices).max()) for visual in visuals), default=1.0)


def _four(
    visuals: tuple[LinkVisual, ...], name: str, kind: type[np.integer[Any]], factor: float
) -> NDArray[Any]:
    """(V, 4) whole numbers; floats are taken as shares of the largest there is."""
    rows = np.concatenate([np.zeros((0, 3)), *(getattr(visual, name) for visual in visuals)])
    scale = np.iinfo(kind).max if kind is np.int16 else 1
    result = np.full((len(rows), 4), 255 if kind is np.uint8 else 0, dtype=kind)
    limits = np.iinfo(kind)
    result[:, :3] = np.clip(np.round(rows * factor * scale), limits.min, limits.max)
    return result


def _poses(bodies: Bodies, visuals: tuple[LinkVisual, ...]) -> NDArray[np.float32]:
    """(K, bodies with meshes, 7): position and quaternion, signs so that they can be mixed."""
    index = [visual.joint_id - 1 for visual in visuals]
    quat = np.stack([sign_continuous(bodies.quat[:, body]) for body in index], axis=1)
    return np.concatenate([bodies.position[:, index], quat], axis=2).astype(np.float32)


def _packed(arrays: dict[str, NDArray[Any]]) -> tuple[str, dict[str, Any]]:
    """Base64 of a gzip of the arrays' bytes, and where in them each array is."""
    listed, parts, start = {}, [], 0
    for name, array in arrays.items():
        little = np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("<"))
        listed[name] = {"kind": little.dtype.str, "start": start, "length": little.size}
        padding = -little.nbytes % _ALIGNED
        parts += [little.tobytes(), bytes(padding)]
        start += little.nbytes + padding
    # No time in the head: the same motion gives the same file.
    return base64.b64encode(gzip.compress(b"".join(parts), 9, mtime=0)).decode("ascii"), listed


def _json(value: Any) -> str:
    """JSON that may stand in an element of a page: nothing in it ends the element."""
    text = json.dumps(value, allow_nan=False, separators=(",", ":"))
    return text.replace("&", "\\u0026").replace("<", "\\u003c").replace(">", "\\u003e")


def _digest(text: str) -> str:
    digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode("ascii")
    return f"'sha256-{digest}'"


def _share(colour: Rgb) -> list[float]:
    return [round(part / 255, 4) for part in colour]


def _asset(name: str) -> str:
    return files("llsrbm.formats.pictures").joinpath(_PAGE, name).read_text(encoding="utf-8")


HTML = Format(
    name="html",
    title="one page that plays the motion in any browser, without a server or a network",
    suffix=".html",
    write=write_html,
    conventions=__doc__,
    options=("fps", "camera"),
    defaults=Options(fps=120.0),
)
