"""How long each format takes, and how large its files are: `python -m benchmarks.exports`.

Of a simulated twist of every robot that comes with the project; meshes are cached before. The first
export of a process, which imports what a format needs, and the second one.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

import llsrbm
from llsrbm.formats import FORMATS
from llsrbm.look.visuals import link_visuals
from llsrbm.robots import load_robot, names

TWIST = 1.57  # rad


def main() -> None:
    """Print a line for each robot and format."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--formats", nargs="*", choices=FORMATS, default=list(FORMATS))
    parser.add_argument("--robots", nargs="*", choices=names(), default=names())
    arguments = parser.parse_args()
    print(f"{'robot':10}{'format':24}{'first s':>10}{'then s':>10}{'kB':>10}")
    for robot in arguments.robots:
        link_visuals(load_robot(robot))
        link_visuals(load_robot(robot), coarse=True)
        rollout = llsrbm.simulate(llsrbm.plan(llsrbm.Jump(robot=robot, twist=TWIST)))
        for name in arguments.formats:
            if FORMATS[name].extra is not None and FORMATS[name].extra.missing:
                continue
            first, _ = timed(rollout, name)
            then, size = timed(rollout, name)
            print(f"{robot:10}{name:24}{first:10.2f}{then:10.2f}{size / 1e3:10.0f}", flush=True)


def timed(rollout: llsrbm.Rollout, name: str) -> tuple[float, int]:
    """Seconds, and bytes of all that was written."""
    with tempfile.TemporaryDirectory() as folder:
        start = time.perf_counter()
        llsrbm.export(rollout, Path(folder) / f"x{FORMATS[name].suffix}", format=name)
        seconds = time.perf_counter() - start
        return seconds, sum(f.stat().st_size for f in Path(folder).rglob("*") if f.is_file())


if __name__ == "__main__":
    main()
