"""Random jumps on ground that is not level: planned, certified, strict with everything disturbed.

    python -m benchmarks.ground --kinds slopes,stones,stairs --requests 60
    python -m benchmarks.ground --kinds routes --robots go2,anymal --requests 20 --seed 41

Slopes: +-20 degrees of pitch and +-15 of roll under the take-off or the landing. Stones: each foot
lands up to 10 cm aside and 10 cm above its place. Stairs: steps of 25 cm by 12 cm, up or down, the
first edge 3 to 20 cm before the front feet; a jump of 15 to 45 cm, each foot on the step that it
comes to, 5 cm off the edges. Routes: three to five landings of 10 to 35 cm, +-15 cm in height,
+-60 degrees in all of turn. Other components are uniform over half of the file's ranges. Requests
and disturbances follow from the seed alone.
"""

from __future__ import annotations

import json
import math
import time
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

import llsrbm
from llsrbm.errors import Error
from llsrbm.request.route import Landing
from llsrbm.robots import load_robot
from llsrbm.robots.robot import Robot

HALF = 0.5  # of the file's ranges
SIMULATION_SEEDS = 10_000
STEP, RISE = 0.25, 0.12  # m
STAIRS_FORWARD = (0.15, 0.45)  # m
FIRST_EDGE = (0.03, 0.2)  # m, before the front hips
OFF_EDGES = 0.05  # m


def _moves(rng: np.random.Generator, robot: Robot) -> dict[str, Any]:
    task = robot.file.task
    return {
        name: HALF * float(rng.uniform(*getattr(task, name)))
        for name in ("twist", "forward", "lateral")
    }


def slopes(rng: np.random.Generator, robot: Robot) -> dict[str, Any]:
    """One surface that slopes."""
    where = "takeoff_" if rng.random() < HALF else ""
    angles = np.radians([rng.uniform(-20, 20), rng.uniform(-15, 15)])
    found = zip((f"{where}slope", f"{where}cross_slope"), angles.tolist(), strict=True)
    return _moves(rng, robot) | dict(found)


def stones(rng: np.random.Generator, robot: Robot) -> dict[str, Any]:
    """Every foot elsewhere."""
    places = {
        leg: [*rng.uniform(-0.1, 0.1, 2).tolist(), float(rng.uniform(0.0, 0.1))]
        for leg in robot.leg_names
    }
    return _moves(rng, robot) | {"stones": places}


def stairs(rng: np.random.Generator, robot: Robot) -> dict[str, Any]:
    """A flight of stairs ahead, up or down: every foot lands on the step that it comes to."""
    up = 1 if rng.random() < HALF else -1
    forward = float(rng.uniform(*STAIRS_FORWARD))
    feet = dict(zip(robot.leg_names, robot.hips[:, 0].tolist(), strict=True))
    edge = max(feet.values()) + float(rng.uniform(*FIRST_EDGE))
    landing = {}
    for leg, foot in feet.items():
        count = max(0, math.ceil((foot + forward - edge) / STEP))
        place = foot + forward
        if count:
            tread = edge + (count - 1) * STEP
            place = float(np.clip(place, tread + OFF_EDGES, tread + STEP - OFF_EDGES))
        landing[leg] = (place - foot - forward, up * count * RISE)
    lowest = min(height for _, height in landing.values())
    stones = {leg: [dx, 0.0, height - lowest] for leg, (dx, height) in landing.items()}
    return {"forward": forward, "height": lowest, "stones": stones}


def routes(rng: np.random.Generator, _robot: Robot) -> dict[str, Any]:
    """Several landings, not higher nor lower than 15 cm by themselves."""
    count = int(rng.integers(3, 6))
    rows, height = [], 0.0
    for _ in range(count):
        to = float(rng.uniform(-0.15, 0.15))
        turn = math.radians(float(rng.uniform(-60, 60))) / count
        rows.append(Landing(float(rng.uniform(0.1, 0.35)), 0.0, to - height, turn))
        height = to
    return {"route": tuple(rows)}


KINDS: dict[str, Callable[[np.random.Generator, Robot], dict[str, Any]]] = {
    each.__name__: each for each in (slopes, stones, stairs, routes)
}


def one(robot: str, kind: str, seed: int, index: int) -> dict[str, Any]:
    """Draw one request, plan it and simulate it."""
    rng = np.random.default_rng([seed, index])
    jump = llsrbm.Jump(robot=robot, **KINDS[kind](rng, load_robot(robot)))
    began = time.perf_counter()
    row = {"robot": robot, "kind": kind, "index": index, "request": jump.as_dict()}
    try:
        plan = llsrbm.plan(jump, patient=False, explains=False)
    except Error as error:
        return row | {"planned": False, "why": str(error)}
    row |= {"seconds": time.perf_counter() - began, "planned": True, "certified": plan.certified}
    broken = [name for name, each in (plan.certificate or {}).items() if each["holds"] is False]
    outcome = llsrbm.simulate(plan, seed=seed * SIMULATION_SEEDS + index).outcome
    return row | {"strict": outcome.strict, "broken": broken, "why": outcome.reason}


def main(
    kinds: str = ",".join(KINDS),
    robots: str = "anymal,go2,slider",
    requests: Annotated[int, typer.Option(help="For each kind and robot.")] = 60,
    seed: Annotated[int, typer.Option(help="Draws requests and disturbances.")] = 40,
    out: Annotated[Path | None, typer.Option(help="All results, JSON lines.")] = None,
) -> None:
    """Print a line a request, then one for each robot and kind."""
    results, table = [], []
    for robot in robots.split(","):
        for kind in kinds.split(","):
            rows = []
            for index in range(requests):
                rows.append(one(robot, kind, seed, index))
                typer.echo(json.dumps(rows[-1]))
            results += rows
            planned = [row for row in rows if row["planned"]]
            held = [row for row in planned if row["certified"]]
            seconds = np.median([row["seconds"] for row in planned]) if planned else math.nan
            table.append(
                f"{robot:8} {kind:8} asked {len(rows)} planned {len(planned)} certified "
                f"{len(held)} strict {sum(row['strict'] for row in planned)}, of certified "
                f"{sum(row['strict'] for row in held)}, {seconds:.1f} s at the median"
            )
    typer.echo("\n".join(table))
    if out is not None:
        out.write_text("".join(json.dumps(row) + "\n" for row in results), "utf-8")


if __name__ == "__main__":
    typer.run(main)
