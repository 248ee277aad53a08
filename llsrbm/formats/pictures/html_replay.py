"""One page that plays the motion from disk: no server, no network, no installation.

Robot, contact forces, inertia ellipsoid, trails, ground and boxes; of a rollout also its plan as a
ghost, and the board. A timeline with phases and events; space plays, arrows step, mouse or fingers
turn, move and zoom. The ellipsoid is that of the uniform solid with the robot's mass and inertia,
of a plan the model's, of a rollout the whole body's. An arrow as long as the standing robot's CoM
is high is a force as large as its weight; of a rollout, forces are means from frame to frame. World
frame, x forward, y left, z up, m.

The scene is viser's own export, from a server on a free port of this machine alone that is stopped
at once; a script of ours lays a timeline over it and moves the nodes. Needs WebGL2 and
DecompressionStream: browsers of 2023 and later.
"""

from __future__ import annotations

import base64
import contextlib
import gzip
import io
import json
import math
from collections.abc import Iterator
from html import escape
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from llsrbm.formats.base import Format, Options
from llsrbm.formats.pictures.drawing import (
    FIELD_OF_VIEW,
    LEAST_FORCE,
    Drawing,
    draw,
    view_of,
)
from llsrbm.installed import package_version
from llsrbm.look import palette
from llsrbm.look.palette import Rgb, css
from llsrbm.look.visuals import link_visuals
from llsrbm.motion.plan import Plan
from llsrbm.motion.trajectory import Trajectory, description

if TYPE_CHECKING:
    import viser

_ASPECT = 16 / 9  # of the window that the camera is placed for
_BARS = 1.2  # of the distance: title and layers cover a part of the picture
_PALER = 0.7  # of the way to white, of trails that are to come
# Whatever a file may bring along, nothing is asked of the network.
_POLICY = (
    "default-src 'none'; connect-src data: blob:; img-src data: blob:; font-src data:; "
    "worker-src blob: data:; style-src 'unsafe-inline'; "
    "script-src 'unsafe-inline' 'unsafe-eval' 'wasm-unsafe-eval' blob: data:"
)


def _write(trajectory: Trajectory, path: Path, options: Options) -> None:
    drawing = draw(trajectory, options.fps, with_instants=True)
    nodes, exported = _exported_scene(drawing)
    numbers, listed = _packed(drawing.arrays)
    facts = _facts(drawing, trajectory, options.camera) | {"nodes": nodes, "arrays": listed}
    over = Template(_asset("replay.html")).substitute(
        facts=_json(facts), numbers=numbers, script=_asset("replay.js")
    )
    head = (
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">'
        f'<meta name="generator" content="llsrbm {escape(package_version())}">'
        f"<title>{escape(drawing.title)}</title>"
    )
    before, after = exported.split("<title>Viser</title>", 1)
    start, charset, rest = before.partition('<meta charset="utf-8" />')
    page = f"{start}{charset}{head}{rest}{after}"
    end = page.rindex("</body>")
    style = f"<style>{_asset('replay.css')}</style>"
    path.write_text(page[:end] + style + over + page[end:], encoding="utf-8")


# ---- the scene


def _exported_scene(drawing: Drawing) -> tuple[list[str], str]:
    """Names of the nodes that the script moves, and viser's page of the scene."""
    import viser

    with contextlib.redirect_stdout(io.StringIO()):  # viser prints whatever `verbose` says
        server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
        try:
            nodes = list(_add_nodes(server.scene, drawing))
            return nodes, server.get_scene_serializer().as_html()
        finally:
            server.stop()


def _add_nodes(scene: viser.SceneApi, drawing: Drawing) -> Iterator[str]:
    """Add everything where it is at the origin; yields the names of the nodes that are moved."""
    import trimesh

    ground = (0.0, 0.0, drawing.surroundings.ground)
    scene.add_grid("/ground", infinite_grid=True, position=ground, shadow_opacity=0.25)
    for layer in ("robot", "ghost", "forces", "trails", "blocks"):
        scene.add_frame(f"/{layer}", show_axes=False)
    for visual in drawing.visuals:
        name = f"/robot/{visual.link}"
        scene.add_glb(name, visual.glb())
        yield name
    pale: dict[str, Any] = {"color": palette.PLANNED, "opacity": 0.3, "cast_shadow": False}
    for visual in link_visuals(drawing.robot, coarse=True) if drawing.ghost is not None else ():
        name = f"/ghost/{visual.link}"
        scene.add_mesh_simple(name, visual.vertices, visual.faces, **pale)
        yield name
    yield from _add_ellipsoid(scene, drawing.colour)
    rod = trimesh.creation.cylinder(radius=1.0, height=1.0, sections=20)
    rod.apply_translation([0.0, 0.0, 0.5])
    tip = trimesh.creation.cone(radius=1.0, height=1.0, sections=20)
    for leg in drawing.robot.legs:
        scene.add_frame(f"/forces/{leg.name}", show_axes=False)
        for part, mesh in (("shaft", rod), ("head", tip)):
            name = f"/forces/{leg.name}/{part}"
            scene.add_mesh_simple(name, mesh.vertices, mesh.faces, color=palette.FORCE)
            yield name
    for name, points, colour, width in _trails(drawing):
        segments = np.stack([points[:-1], points[1:]], axis=1).astype(np.float32)
        for part, tint in (("to_come", palette.paler(colour, _PALER)), ("past", colour)):
            tints, trail = np.array(tint, dtype=np.uint8), f"/trails/{name}_{part}"
            scene.add_line_segments(
                trail, segments, tints, thickness=width, thickness_units="screen"
            )
        yield f"/trails/{name}_past"
    size = 0.026 * float(drawing.robot.com[2])
    scene.add_icosphere("/trails/com_now", size, palette.COM, opacity=0.9, cast_shadow=False)
    yield "/trails/com_now"
    for i, block in enumerate(drawing.surroundings.blocks):
        turn = (math.cos(block.yaw / 2), 0.0, 0.0, math.sin(block.yaw / 2))
        for part, opacity in (("there", None), ("to_come", 0.16)):
            look: dict[str, Any] = {"opacity": opacity, "position": block.centre, "wxyz": turn}
            name = f"/blocks/{i}/{part}"
            scene.add_box(name, palette.BLOCK, block.size, **look)
            yield name


def _add_ellipsoid(scene: viser.SceneApi, colour: Rgb) -> Iterator[str]:
    scene.add_frame("/ellipsoid", show_axes=False)
    yield "/ellipsoid"
    scene.add_icosphere("/ellipsoid/surface", 1.0, colour, opacity=0.27, cast_shadow=False)
    wires: dict[str, Any] = {"subdivisions": 2, "wireframe": True, "opacity": 0.35}
    scene.add_icosphere("/ellipsoid/wires", 1.004, colour, cast_shadow=False, **wires)


def _trails(drawing: Drawing) -> Iterator[tuple[str, NDArray[Any], Rgb, float]]:
    """Name, points, colour and pixels: the CoM over the whole motion, the feet in flight."""
    yield "com", drawing.motion.com, palette.COM, 2.6
    if drawing.flight.sum() > 1:
        for i, leg in enumerate(drawing.robot.legs):
            yield leg.name, drawing.motion.foot_position[drawing.flight, i], palette.FOOT, 1.8


# ---- numbers and words


def _facts(
    drawing: Drawing, trajectory: Trajectory, camera: tuple[float, float, float] | None
) -> dict[str, Any]:
    view = view_of(drawing, _ASPECT, camera)
    distance = view.distance * (1.0 if camera else _BARS)
    good = trajectory.solved if isinstance(trajectory, Plan) else trajectory.landed
    flying = drawing.time[drawing.flight]
    trails = [(name, drawing.time if name == "com" else flying) for name, *_ in _trails(drawing)]
    return {
        "title": drawing.title,
        "outcome": drawing.outcome,
        "bad": not good,
        "rollout": not isinstance(trajectory, Plan),
        "legs": [leg.name for leg in drawing.robot.legs],
        "bodies": [visual.link for visual in drawing.visuals],
        "blocks": [
            {"from": b.from_s, "until": b.until_s if math.isfinite(b.until_s) else None}
            for b in drawing.surroundings.blocks
        ],
        "trails": [
            {"name": f"/trails/{name}_past", "times": times[1:].round(4).tolist()}
            for name, times in trails
        ],
        "camera": {
            "target": view.target.tolist(),
            "eye": (view.target + distance * view.axes[:, 2]).tolist(),
            "fieldOfView": FIELD_OF_VIEW,
            "aspect": _ASPECT,
        },
        "arrow": {
            "perNewton": drawing.arrow_per_newton,
            "least": LEAST_FORCE,
            "thickness": 0.016 * float(drawing.robot.com[2]),
        },
        "colours": {
            "planned": css(palette.PLANNED),
            "ellipsoid": css(drawing.colour),
            "force": css(palette.FORCE),
            "com": css(palette.COM),
        },
        "timeline": drawing.timeline.plain(),
        "description": description(trajectory),
    }


def _packed(arrays: dict[str, NDArray[Any]]) -> tuple[str, dict[str, Any]]:
    """Base64 of a gzip of the arrays as floats, and where in its bytes each array is."""
    listed, content = {}, b""
    for name, array in arrays.items():
        listed[name] = {"start": len(content), "length": array.size}
        content += array.astype("<f4").tobytes()
    # No time in the head: the same motion gives the same file.
    return base64.b64encode(gzip.compress(content, 9, mtime=0)).decode("ascii"), listed


def _json(value: Any) -> str:
    """JSON that may stand in an element of a page: nothing in it ends the element."""
    text = json.dumps(value, allow_nan=False, separators=(",", ":"))
    return text.replace("&", "\\u0026").replace("<", "\\u003c").replace(">", "\\u003e")


def _asset(name: str) -> str:
    return files("llsrbm.formats.pictures").joinpath(name).read_text(encoding="utf-8")


HTML = Format(
    name="html",
    title="one page that plays the motion in any browser, without a server or a network",
    suffix=".html",
    write=_write,
    conventions=__doc__,
    options=("fps", "camera"),
    defaults=Options(fps=120.0),
)
