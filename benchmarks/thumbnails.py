"""Moving thumbnails of the examples: `python -m benchmarks.thumbnails [NAME ...]`, or all of them.

Each is a design's plan as the whole robot follows it, drawn by the exporter of videos, from
shortly before lift-off until the robot stands; a flip at half its speed. They ship in
`assets/thumbnails`.
"""

import argparse

from PIL import Image

import llsrbm
from app.gallery import FOLDER, thumbnail_file
from app.tab.start.initial_plan import example, shipped_plan
from llsrbm.errors import NotConverged
from llsrbm.formats.base import Options
from llsrbm.formats.pictures.video import pictures
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.request.design import Design, examples

SIZE = (192, 144)  # pixels
DRAWN = (288, 216)  # larger, for smooth edges, and too small for a caption
FPS = 15.0  # pictures/s of the thumbnail
BEFORE, AFTER = 0.25, 0.6  # s of the motion before lift-off and after touchdown
RESTS = 600  # ms for which the last picture stands
QUALITY = 42  # of WebP


def main() -> None:
    """Make those that are named, or all, and say how large they are."""
    designs = examples()
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", choices=[[], *designs])
    FOLDER.mkdir(exist_ok=True)
    for name in parser.parse_args().names or list(designs):
        path = thumbnail_file(name)
        frames = _frames(designs[name])
        durations = [round(1000 / FPS)] * (len(frames) - 1) + [RESTS]
        frames[0].save(
            path, save_all=True, append_images=frames[1:], duration=durations, loop=0,
            quality=QUALITY, method=6, minimize_size=True,
        )  # fmt: skip
        print(
            f"{path.name}  {len(frames)} pictures, {path.stat().st_size / 1e3:.0f} kB", flush=True
        )
    total = sum(path.stat().st_size for path in FOLDER.glob("*.webp"))
    print(f"{total / 1e3:.0f} kB in all")


def _frames(design: Design) -> list[Image.Image]:
    rollout = llsrbm.simulate(_plan(design), design.scenario)
    rate = FPS * (2 if rollout.jump.turns else 1)
    first, last = (round(rate * time) for time in _span(rollout))
    drawn = pictures(rollout, Options(fps=rate, size=DRAWN))
    kept = [picture for k, picture in enumerate(drawn) if first <= k <= last]
    return [Image.fromarray(each).resize(SIZE, Image.Resampling.LANCZOS) for each in kept]


def _plan(design: Design) -> Plan:
    """The plan that ships of it, its draft, or the nearest one, which the page shows."""
    jump, tuning = design.jump, design.tuning
    if jump == example(jump.robot) and not (tuning.weights or tuning.limits):
        shipped = shipped_plan(jump.robot)
        if shipped is not None:
            return shipped
    try:
        return llsrbm.plan(jump, weights=tuning.weights, limits=tuning.limits, draft=True)
    except NotConverged as error:
        if error.nearest is None:
            raise
        return error.nearest


def _span(rollout: Rollout) -> tuple[float, float]:
    """Beginning and end of what is shown, s."""
    plan = rollout.plan
    flights = plan.schedule.flights
    lift_off = float(plan.phase_start[flights[0]])
    return max(0.0, lift_off - BEFORE), float(plan.phase_start[flights[-1] + 1]) + AFTER


if __name__ == "__main__":
    main()
