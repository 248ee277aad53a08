"""The moving pictures of README and pages: `python -m benchmarks.films [NAME ...]`, or all of them.

They are made by the exporter that anybody has, into `docs/`: examples (`llsrbm designs`), planned
and simulated, and `tuck`: plans of one back flip by two models, side by side at a quarter of their
speed.
"""

import math
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont, ImageSequence

import llsrbm
from llsrbm.mechanics import rotation_matrices
from llsrbm.motion.sampling import resample
from llsrbm.request.design import find_design

FOLDER = Path(__file__).parents[1] / "docs"
FILMS = {  # file -> example
    "half_turn": "slider-half-turn",
    "box": "slider-box",
    "back_flip": "go2-back-flip",
    "pirouette": "g1-pirouette",
    "course": "go2-course",
}
TUCK = "tuck"
MODELS = ("llsrbm-plus", "srbm")  # from the left
FPS, SLOWER = 50, 4  # pictures a second of the motion, and by how much they are shown later
FROM, UNTIL = 0.2, 1.25  # s of the motion: before and after there is little to see
SIZE = (360, 360)  # of each half, pixels
KEPT = 318  # pixels from the top: below is nothing but ground
CAMERA = (-60.0, 8.0, 2.6)  # azimuth and elevation, deg, and distance, m: from the robot's right
COLOURS = 200
INK = (29, 36, 48)


def main() -> None:
    """Make those that are named, or all."""
    for name, example in FILMS.items():
        if _wanted(name):
            design = find_design(example)
            rollout = llsrbm.simulate(llsrbm.plan(design.jump), design.scenario)
            assert rollout.landed
            path = FOLDER / f"{name}.gif"
            llsrbm.export(rollout, path, format="gif", size=(480, 270), fps=20)
            path.with_name(path.name + ".meta.json").unlink(missing_ok=True)
            _report(path)
    if _wanted(TUCK):
        path = FOLDER / f"{TUCK}.gif"
        write_tuck(path)
        _report(path)


def write_tuck(path: Path) -> None:
    """Go2's back flip as two models plan it, below each the model's inertia at that instant."""
    halves = []
    for model in MODELS:
        plan = llsrbm.plan(llsrbm.Jump("go2", model, type="flip", pitch=-math.tau), draft=True)
        halves.append(_captioned(plan, _exported(plan)))
    first, last = round(FROM * FPS), round(UNTIL * FPS)
    pictures = [
        Image.fromarray(np.hstack(pair)) for pair in list(zip(*halves, strict=False))[first:last]
    ]
    # One table of colours for all and no dither, as the exporter has it: the ground stays as it is.
    seen = np.vstack([np.asarray(picture) for picture in pictures[:: len(pictures) // 5]])
    colours = Image.fromarray(seen).quantize(COLOURS, Image.Quantize.MEDIANCUT)
    frames = [picture.quantize(palette=colours, dither=Image.Dither.NONE) for picture in pictures]
    frames[0].save(
        path,
        save_all=True,
        append_images=frames[1:],
        duration=1000 * SLOWER // FPS,
        loop=0,
    )


def _exported(plan: llsrbm.Plan) -> list[Image.Image]:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "half.gif"
        llsrbm.export(plan, path, format="gif", size=SIZE, fps=FPS, camera=CAMERA)
        with Image.open(path) as film:
            seen = (0, 0, SIZE[0], KEPT)
            return [each.convert("RGB").crop(seen) for each in ImageSequence.Iterator(film)]


def _captioned(plan: llsrbm.Plan, pictures: list[Image.Image]) -> list[np.ndarray]:
    """With the model's inertia about the body's lateral axis."""
    at = resample(plan, np.arange(len(pictures)) / FPS)
    lateral = rotation_matrices(at.base_quat)[:, :, 1]
    inertia = np.einsum("ki,kij,kj->k", lateral, at.inertia, lateral)
    font = ImageFont.load_default(14)
    for picture, value in zip(pictures, inertia, strict=True):
        words = f"lateral inertia {value:.2f} kg m2"
        ImageDraw.Draw(picture).text((10, KEPT - 24), words, INK, font)
    return [np.asarray(picture) for picture in pictures]


def _wanted(name: str) -> bool:
    return not sys.argv[1:] or name in sys.argv[1:]


def _report(path: Path) -> None:
    print(f"{path.relative_to(FOLDER.parent)}  {path.stat().st_size / 1e3:.0f} kB", flush=True)


if __name__ == "__main__":
    main()
