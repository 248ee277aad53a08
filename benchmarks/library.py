"""The library's motions, replayed by their torques and gains, and simulated with fresh seeds.

    python -m benchmarks.library replay --a-robot 8 --seeds 0:2
    python -m benchmarks.library strict --a-robot 8 --seeds 7000:7002
    python -m benchmarks.library outside --a-robot 8

`replay` exports each motion for MuJoCo and runs the script of that folder, which knows neither this
package nor which feet touch, and disturbs trunk, friction, contacts and delay by its seed; a motion
stands if the script says so. `strict` simulates each with everything disturbed that
`llsrbm.simulation.disturbance` disturbs; motions were kept because they were strict with two other
seeds. `outside` checks each as `benchmarks.outside` does, by its exports alone. The motions of a
robot are evenly taken from its list, all kinds among them.
"""

import subprocess
import sys
import tempfile
from collections import defaultdict
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

import llsrbm
from benchmarks.counting import seeds_of
from benchmarks.outside import exported, findings
from benchmarks.outside import outside as robot_outside
from llsrbm.library import Card, Library, shipped

app = typer.Typer(help=__doc__, add_completion=False)

Folder = Annotated[Path | None, typer.Option("--dir", help="A library; the one that ships.")]
ARobot = Annotated[int, typer.Option("--a-robot", help="Motions of each robot; 0: all.")]


def taken(library: Library, a_robot: int) -> Iterator[Card]:
    robots = defaultdict(list)
    for card in library.found():
        robots[card.robot].append(card)
    for cards in robots.values():
        count = min(a_robot or len(cards), len(cards))
        yield from (cards[k] for k in np.linspace(0, len(cards) - 1, count).astype(int))


def counted(
    folder: Path | None,
    a_robot: int,
    seeds: range,
    done: Callable[[llsrbm.Plan, range], list[bool]],
) -> None:
    """Print how often what is `done` with each plan and seed goes well, by robot and by kind."""
    library = shipped() if folder is None else Library(folder)
    counts: dict[tuple[str, str], list[bool]] = defaultdict(list)
    for card in taken(library, a_robot):
        found = done(library.open(card.name, check=False), seeds)
        counts["robot", card.robot] += found
        counts["kind", card.kind] += found
        counts["all", "all"] += found
        print(f"{card.name:28} {sum(found)} of {len(found)}", flush=True)
    for (_, name), found in sorted(counts.items()):
        print(f"{name:28} {sum(found):4} of {len(found):4}  {100 * np.mean(found):5.1f} %")


@app.command()
def replay(folder: Folder = None, a_robot: ARobot = 0, seeds: str = "0:2") -> None:
    """How often motions stand that are replayed by torques and gains alone."""

    def stands(plan: llsrbm.Plan, drawn: range) -> list[bool]:
        with tempfile.TemporaryDirectory() as place:
            path = Path(place) / "motion"
            llsrbm.export(llsrbm.with_feedback(plan), path, format="mujoco")
            run = [sys.executable, "-I", "replay.py"]
            return [
                subprocess.run([*run, str(seed)], cwd=path, capture_output=True).returncode == 0
                for seed in drawn
            ]

    counted(folder, a_robot, seeds_of(seeds), stands)


@app.command()
def strict(folder: Folder = None, a_robot: ARobot = 0, seeds: str = "7000:7002") -> None:
    """How often motions land strictly with seeds that they were not kept for."""
    counted(
        folder,
        a_robot,
        seeds_of(seeds),
        lambda plan, drawn: [llsrbm.simulate(plan, seed=seed).outcome.strict for seed in drawn],
    )


@app.command()
def outside(folder: Folder = None, a_robot: ARobot = 0) -> None:
    """How many motions hold for a checker of others; what does not hold is printed."""

    def holds(plan: llsrbm.Plan, _: range) -> list[bool]:
        robot = robot_outside(plan.jump.robot)
        broken = [found for found in findings(exported(plan, robot), robot) if not found[-1]]
        for check, worst, _held in broken:
            print(f"  {check} {worst:.3f}", flush=True)
        return [not broken]

    counted(folder, a_robot, range(1), holds)


if __name__ == "__main__":
    app()
