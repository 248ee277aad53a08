"""The classifiers of jumps that can be planned (`llsrbm.atlas.feasible`): samples, fit and check.

    python -m benchmarks.feasible sample --robots anymal --seconds 240 --into build/feasible
    python -m benchmarks.feasible from-range --rows FILE [--unseen] --into build/feasible
    python -m benchmarks.feasible fit --samples build/feasible [--onto-shipped]
    python -m benchmarks.feasible sample --robots anymal --unseen --into build/feasible
    python -m benchmarks.feasible check --samples build/feasible

Samples are planned with patience: what is not planned at once may be found on the way to the
nearest jump. `from-range` takes those that `benchmarks.range --out` kept. `fit` writes
`assets/feasible.json`, anew or, after a change of robots or planner, as a correction of the weights
that ship. Once there is a fit, further samples to learn from are drawn where it is least sure.
"""

import csv
import json
import time
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from llsrbm.atlas.feasible import (
    LIMITS,
    Feasible,
    ends_of,
    feasible_of,
    features,
    made,
    values_of,
)
from llsrbm.errors import InputError, NotConverged
from llsrbm.installed import assets_directory
from llsrbm.planning.answer.planner import planner_of
from llsrbm.request.jump import COMPONENTS, Jump
from llsrbm.robots import load_robot
from llsrbm.robots.numbers_key import numbers_key
from llsrbm.robots.robot import Robot

ROBOTS = "anymal,go2,slider,a1,go1,anymal_c,solo12,g1"
UNSEEN = 100_000  # first seed of samples that nothing is fitted to
CANDIDATES = 12  # of which the least sure one is sampled
# Samples: half of them along some of the sliders alone, a quarter under the robot's own limits.
FACES, OWN, CHANGED = 0.5, 0.25, 0.5
# Of weights that all robots share, and of each robot's own beyond these.
RIDGES = (0.3, 1.0)
STEPS = 60

app = typer.Typer()
Robots = Annotated[str, typer.Option(help="Names, with commas.")]
Folder = Annotated[Path, typer.Option(help="With a table of samples a robot.")]


def drawn(robot: Robot, seed: int) -> np.ndarray:
    """(D,) SI values of a request."""
    rng = np.random.default_rng(seed)
    low, high = ends_of(robot)
    values = values_of(Jump(robot=robot.name), {}, robot)
    many = len(COMPONENTS)
    request = rng.uniform(low[:many], high[:many])
    some = rng.random(many) < 0.5 if rng.random() < FACES else np.full(many, True)
    values[:many] = np.where(some, request, 0.0)
    if rng.random() > OWN:
        limits = rng.uniform(low[many:], high[many:])
        values[many:] = np.where(rng.random(len(limits)) < CHANGED, limits, values[many:])
    return values


def planned(robot: Robot, values: np.ndarray) -> bool | None:
    """Whether a request can be planned; None: it contradicts itself."""
    own = values_of(Jump(robot=robot.name), {}, robot)
    jump = Jump(robot=robot.name, **dict(zip(COMPONENTS, map(float, values), strict=False)))
    pairs = zip(LIMITS, values[len(COMPONENTS) :], own[len(COMPONENTS) :], strict=True)
    limits = {name: float(value) for name, value, default in pairs if value != default}
    try:
        planner_of(jump).plan(jump, limits=limits, explains=False)
    except NotConverged:
        return False
    except InputError:
        return None
    return True


def table(folder: Path, robot: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(n,) seeds, (n,) whether they could be planned, (n, D) SI values."""
    path = folder / f"{robot}.csv"
    rows = (
        np.loadtxt(path, delimiter=",", ndmin=2)
        if path.exists() and path.stat().st_size
        else np.empty((0, 3 + len(COMPONENTS) + len(LIMITS)))
    )
    return rows[:, 0].astype(int), rows[:, 1] > 0, rows[:, 3:]


def next_values(robot: Robot, seed: int, unseen: bool) -> np.ndarray:
    feasible = None if unseen else feasible_of(robot)
    if feasible is None or seed % 4 == 0:
        return drawn(robot, seed)
    candidates = np.array([drawn(robot, seed * 1000 + k) for k in range(CANDIDATES)])
    scores = feasible.scores(feasible.scaled(candidates))
    return candidates[np.abs(scores).argmin()]


@app.command()
def sample(
    into: Folder,
    robots: Robots = ROBOTS,
    seconds: Annotated[float, typer.Option(help="To spend on each robot.")] = 240.0,
    most: Annotated[int, typer.Option(help="Samples of each robot.")] = 10_000,
    unseen: Annotated[bool, typer.Option(help="For `check`, not to be fitted to.")] = False,
) -> None:
    into.mkdir(parents=True, exist_ok=True)
    for name in robots.split(","):
        robot = load_robot(name)
        planner_of(Jump(robot=name))
        seeds, _, _ = table(into, name)
        mine = seeds[(seeds >= UNSEEN) == unseen]
        seed = int(mine.max(initial=UNSEEN * unseen - 1)) + 1
        end, count, good = time.perf_counter() + seconds, len(mine), 0
        with (into / f"{name}.csv").open("a") as file:
            while time.perf_counter() < end and count < most:
                values, start = next_values(robot, seed, unseen), time.perf_counter()
                found = planned(robot, values)
                if found is not None:
                    took = round(time.perf_counter() - start, 3)
                    csv.writer(file).writerow([seed, int(found), took, *values.tolist()])
                    file.flush()
                    count, good = count + 1, good + found
                seed += 1
        print(
            f"{name}: {count} samples, {good} of {count - len(mine)} new ones planned", flush=True
        )


def fitted(
    blocks: list[tuple[np.ndarray, np.ndarray]], ridges: tuple[float, float], known: np.ndarray
) -> np.ndarray:
    """(R, F) weights of each robot, of its features (n, F) and whether they were planned (n,).

    `known` (R, F) are what the ridges draw them to.

    Logistic regression by Newton's method: w_r = w + d_r with a ridge on w and a larger one on d_r,
    so that robots with few samples borrow from the others.
    """
    size, many = blocks[0][0].shape[1], len(blocks)
    rows = []
    for place, (phi, _) in enumerate(blocks):
        row = np.zeros((len(phi), size * (many + 1)))
        row[:, :size] = phi
        row[:, size * (place + 1) : size * (place + 2)] = phi
        rows.append(row)
    A, y = np.vstack(rows), np.concatenate([y for _, y in blocks]).astype(float)
    before = np.concatenate([phi @ w for (phi, _), w in zip(blocks, known, strict=True)])
    ridge = np.repeat([ridges[0], *[ridges[1]] * many], size)
    ridge[0] = 1e-3
    w = np.zeros(A.shape[1])
    for _ in range(STEPS):
        chance = 1 / (1 + np.exp(-np.clip(before + A @ w, -30, 30)))
        hessian = (A.T * np.maximum(chance * (1 - chance), 1e-6)) @ A + np.diag(ridge)
        step = np.linalg.solve(hessian, A.T @ (y - chance) - ridge * w)
        w += step * min(1.0, 3.0 / max(np.abs(A @ step).max(), 1e-9))
        if np.abs(step).max() < 1e-6:
            break
    return known + w[:size] + w[size:].reshape(many, size)


def scaled(robot: Robot, values: np.ndarray) -> np.ndarray:
    return made(robot, np.empty(0)).scaled(values)


@app.command()
def from_range(
    into: Folder,
    rows: Annotated[Path, typer.Option(help="JSON lines of `benchmarks.range`.")],
    unseen: Annotated[bool, typer.Option(help="For `check`, not to be fitted to.")] = False,
) -> None:
    into.mkdir(parents=True, exist_ok=True)
    for line in rows.read_text(encoding="utf-8").splitlines():
        row = json.loads(line)
        robot = load_robot(row["robot"])
        jump = Jump(robot=robot.name, **{name: row.get(name, 0.0) for name in COMPONENTS})
        values = values_of(jump, {}, robot).tolist()
        seed = row["seed"] % UNSEEN + UNSEEN * unseen
        with (into / f"{robot.name}.csv").open("a") as file:
            csv.writer(file).writerow([seed, int(row["planned"]), 0.0, *values])


@app.command()
def fit(
    samples: Folder,
    robots: Robots = ROBOTS,
    onto_shipped: Annotated[bool, typer.Option("--onto-shipped")] = False,
) -> None:
    path = assets_directory() / "feasible.json"
    shipped = json.loads(path.read_text(encoding="utf-8")) if onto_shipped else {}
    names = robots.split(",")
    blocks, known = [], []
    for name in names:
        seeds, can, values = table(samples, name)
        mine = seeds < UNSEEN
        blocks.append((features(scaled(load_robot(name), values[mine])), can[mine]))
        none = np.zeros(blocks[-1][0].shape[1])
        known.append(np.array(shipped[name]["weights"]) if onto_shipped else none)
    weights = fitted(blocks, RIDGES, np.array(known))
    found = {
        name: {
            "robot": numbers_key(load_robot(name)),
            "samples": len(can) + (shipped[name]["samples"] if onto_shipped else 0),
            "weights": [float(f"{w:.4g}") for w in row],
        }
        for name, (_, can), row in zip(names, blocks, weights, strict=True)
    }
    lines = ",\n".join(f"{json.dumps(name)}: {json.dumps(data)}" for name, data in found.items())
    path.write_text(f"{{\n{lines}\n}}\n", encoding="utf-8")


@app.command()
def check(samples: Folder, robots: Robots = ROBOTS) -> None:
    for name in robots.split(","):
        robot = load_robot(name)
        feasible = feasible_of(robot)
        seeds, can, values = table(samples, name)
        unseen = seeds >= UNSEEN
        if feasible is None or not unseen.any():
            continue
        own = values_of(Jump(robot=name), {}, robot)[len(COMPONENTS) :]
        usual = (values[unseen][:, len(COMPONENTS) :] == own).all(axis=1)
        print_shares(name, feasible, can[unseen], values[unseen])
        print_shares(f"{name}, own limits", feasible, can[unseen][usual], values[unseen][usual])


def print_shares(title: str, feasible: Feasible, can: np.ndarray, values: np.ndarray) -> None:
    guess = feasible.scores(feasible.scaled(values)) > 0
    right, no = (guess == can).mean(), ~can
    recall = f"{(~guess[no]).sum()} of {no.sum()}"
    precision = f"{can[~guess].sum()} of {(~guess).sum()}"
    print(
        f"{title}: {len(can)} unseen, {can.mean():.1%} planned; right {right:.1%}; of the refused "
        f"found {recall}; said no wrongly {precision}"
    )


if __name__ == "__main__":
    app()
