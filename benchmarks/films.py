"""The README's moving pictures: `python -m benchmarks.films [NAME ...]`, all of them without names.

They are made by the exporter that anybody has. Each is an example (`llsrbm designs`), planned,
simulated and exported into `docs/`.
"""

from __future__ import annotations

import sys
from pathlib import Path

import llsrbm
from llsrbm.request.design import find_design

FOLDER = Path(__file__).parents[1] / "docs"
FILMS = {  # file -> example
    "half_turn": "anymal-half-turn",
    "box": "slider-box",
    "back_flip": "go2-back-flip",
    "pirouette": "g1-pirouette",
}


def main() -> None:
    """Make those that are named, or all."""
    for name, example in FILMS.items():
        if sys.argv[1:] and name not in sys.argv[1:]:
            continue
        design = find_design(example)
        rollout = llsrbm.simulate(llsrbm.plan(design.jump), design.scenario)
        assert rollout.landed
        path = FOLDER / f"{name}.gif"
        llsrbm.export(rollout, path, format="gif", size=(480, 270), fps=20)
        path.with_name(path.name + ".meta.json").unlink(missing_ok=True)
        print(f"{path.relative_to(FOLDER.parent)}  {path.stat().st_size / 1e3:.0f} kB", flush=True)


if __name__ == "__main__":
    main()
