"""The designer's own picture and player as one page that plays a motion from disk.

Format `html`, found by `llsrbm.formats` as an entry point: the library does not know the page.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import replace
from html import escape
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

from llsrbm.formats.base import Format, Options, Purpose
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.motion.trajectory import Trajectory

if TYPE_CHECKING:
    from app.motion.clip import Clip
    from app.picture.picture import Picture
    from llsrbm.arrays import Array

_SCRIPTS = (
    *("graphics.js", "elements.js", "layout.js", "page.js", "player.js", "timeline.js"),
    *("transport.js", "camera.js", "replay_charts.js", "embedding.js", "accessibility.js"),
    "replay.js",
)
"""Of the page, in the order in which they need each other."""

# Whatever a file may bring along, nothing is asked of the network.
_POLICY = (
    "default-src 'none'; connect-src data: blob:; img-src data: blob:; font-src data:; "
    "worker-src blob: data:; style-src 'unsafe-inline'; "
    "script-src 'unsafe-inline' 'unsafe-eval' 'wasm-unsafe-eval' blob: data:"
)
# A page on disk has no handle to drag.
_LANDING = ("Landing marks", "Where the feet shall land.")


def _write(trajectory: Trajectory, path: Path, options: Options) -> None:
    path.write_text(_page(trajectory, options), encoding="utf-8")


def _write_many(
    trajectories: Iterable[tuple[str, Trajectory]], folder: Path, options: Options
) -> None:
    from app.shared_pages import SharedPages

    pages = SharedPages(folder)
    for name, trajectory in trajectories:
        pages.add(name, _page(trajectory, options))


def _page(trajectory: Trajectory, options: Options) -> str:
    from app.page_template import embedded
    from llsrbm.analysis.wording import outcome_words
    from llsrbm.installed import package_version
    from llsrbm.look.shown_motion import check_finite
    from llsrbm.look.timeline import timeline
    from llsrbm.look.titles import title
    from llsrbm.motion.trajectory import description

    check_finite(trajectory)
    plan, rollout = _plan_and_rollout(trajectory)
    picture = _picture(trajectory, options.fps)
    clip, page = _drawn(picture, options.camera)
    events = timeline(plan, rollout)
    header, numbers = clip.encoded
    facts: dict[str, Any] = {
        "title": title(trajectory),
        "outcome": outcome_words(trajectory),
        "good": trajectory.solved if isinstance(trajectory, Plan) else trajectory.landed,
        "clip": header,
        "numbers": numbers,
        "timeline": replace(events, end=max(events.end, clip.end)).plain(),
        "layers": _layers(picture),
        "charts": _charts(picture, clip.end),
        "description": description(trajectory),
    }
    head = (
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">'
        f'<meta name="generator" content="llsrbm {escape(package_version())}">'
        f"<title>{escape(facts['title'])}</title>"
        f'<script type="application/json" id="facts">{_json(facts)}</script>'
        f"{embedded(_SCRIPTS)}"
    )
    # The policy has to stand before all scripts, viser's own too.
    start, charset, rest = page.partition('<meta charset="utf-8" />')
    rest = rest.replace("<title>Viser</title>", "", 1)
    return f"{start}{charset}{head}{rest}"


def _plan_and_rollout(trajectory: Trajectory) -> tuple[Plan, Rollout | None]:
    return (trajectory, None) if isinstance(trajectory, Plan) else (trajectory.plan, trajectory)


def _picture(trajectory: Trajectory, rate: float) -> Picture:
    """As the page draws the same motion at first, `rate` frames a second."""
    from app.motion.baked import bake_plan, bake_rollout
    from app.picture.overlays import AT_FIRST
    from app.picture.picture import Picture
    from llsrbm.look.shown_motion import surroundings_of
    from llsrbm.look.visuals import link_visuals
    from llsrbm.motion.robot import robot_of
    from llsrbm.motion.sampling import check_rate

    check_rate(rate)
    plan, rollout = _plan_and_rollout(trajectory)
    robot = robot_of(plan)
    for coarse in (False, True):
        link_visuals(robot, coarse=coarse)  # in place of the stand-ins that a page begins with
    return Picture(
        robot=robot,
        planned=bake_plan(plan, robot, rate),
        simulated=None if rollout is None else bake_rollout(rollout, rate).frames,
        rollout=rollout,
        pushes=() if rollout is None else rollout.pushes,
        blocks=surroundings_of(trajectory, robot).blocks,
        layers=AT_FIRST,
        target=plan.jump,
        fine=True,
    )


def _drawn(picture: Picture, camera: tuple[float, float, float] | None) -> tuple[Clip, str]:
    """How everything moves, and viser's page of the scene, from a server that is stopped at once.

    The server is on a free port of this machine alone.
    """
    import viser

    from app.picture.lighting import configure_world
    from app.picture.overlays import OVERLAYS
    from app.picture.scene import Scene
    from app.viser_private import silent

    with silent():
        server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
        try:
            configure_world(server)
            for name in sorted(picture.layers):  # nodes by which the page hides layers
                server.scene.add_frame(OVERLAYS[name].root, show_axes=False)
            clip = Scene(server).draw(picture)
            assert clip is not None  # it is the first
            assert clip.camera_target is not None  # there is a robot
            target = replace(clip.camera_target, camera=camera)
            page = server.get_scene_serializer().as_html()
        finally:
            server.stop()
    return replace(clip, camera_target=target, request=picture.motion[1].plan.jump.as_dict()), page


def _layers(picture: Picture) -> list[dict[str, Any]]:
    """The overlays that have something to draw: title, hint, colours, node above theirs."""
    from app.motion import colours
    from app.picture.overlays import OVERLAYS

    found = []
    for name, overlay in OVERLAYS.items():
        tints = overlay.swatch(picture)
        if name not in picture.layers or not tints:
            continue
        title, hint = _LANDING if name == "landing" else (overlay.title, overlay.hint)
        swatches = [colours.css(tint) for tint in tints]
        found.append({"title": title, "hint": hint, "colours": swatches, "node": overlay.root})
    return found


def _charts(picture: Picture, end: float) -> dict[str, Any]:
    """The charts of what the jump is about, for static/replay_charts.js."""
    from app.motion import colours
    from app.plots.charts import shown_layers
    from app.plots.choice import DEFAULT, of_jump
    from app.plots.figure import figure

    planned = picture.planned
    assert planned is not None  # a replay has a plan
    plan = planned.plan
    drawn = figure(of_jump(DEFAULT, plan.jump), shown_layers(planned, picture.rollout), end)
    return {
        "time": _rounded(drawn.grid.time),
        "flights": [_rounded(plan.phase_start[[k, k + 1]]) for k in plan.schedule.flights],
        "charts": [
            {
                "title": chart.heading,
                "lines": [
                    {
                        "name": line.name,
                        "colour": colours.css(line.colour),
                        "dash": line.dash,
                        "values": _rounded(line.values),
                    }
                    for line in chart.lines
                ],
            }
            for chart in drawn.charts
        ],
    }


def _rounded(values: Array) -> list[float | None]:
    """Numbers as finely as a chart shows them; null where there is none."""
    return [float(f"{value:.5g}") if isfinite(value) else None for value in values]


def _json(value: Any) -> str:
    """JSON that may stand in an element of a page: nothing in it ends the element."""
    text = json.dumps(value, allow_nan=False, separators=(",", ":"))
    return text.replace("&", "\\u0026").replace("<", "\\u003c").replace(">", "\\u003e")


HTML = Format(
    name="html",
    title="one page that plays the motion in any browser, without a server or a network",
    purpose=Purpose.LOOKING,
    suffix=".html",
    write=_write,
    write_many=_write_many,
    conventions="""\
One page that plays the motion from disk: no server, no network, no installation.

The picture and the player are those of the designer's page: robot, contact forces, inertia
ellipsoids, trails, ground and boxes; of a rollout also its plan as a ghost where the two are apart,
pushes and the plans made in it. A timeline with phases and events; charts of plan and rollout; the
same keys, camera views and loop; layers to show and hide. A page that has it in a frame can control
it: play, pause, seek, load, and an event a frame (docs/embedding.md). An arrow of 0.8 m is a force
as large as the robot's weight; of a rollout, forces are means from frame to frame. World frame, x
forward, y left, z up, m.

`fps`: frames a second, between which the browser mixes; `camera`: azimuth (0 looks from ahead, 90
from the left), elevation [deg] and distance [m] from which it is looked at, as the page does if
left out. Needs WebGL2: browsers of 2023 and later.
""",
    options=("fps", "camera"),
)
