"""How hard may a robot be pushed, with and without replanning?

    python -m benchmarks.pushes --out pushes.jsonl
    python -m benchmarks.pushes --random 200 --out pushes.jsonl
    python -m benchmarks.pushes --robots anymal@17,anymal@133 --random 12 --size 22.2 --out f.jsonl

A table of the largest impulse on the trunk that is recovered from (the strict measure without the
feet's place) in 18 of 20 seeds, by direction and moment. Impulses are the rungs of a fixed ladder;
each cell climbs or descends it from a first guess and then bisects, and a rung is given up at its
third failure. With `--random`, that many pushes of random direction and moment, of a size of which
half is recovered from without replanning, or of `--size`. `ROBOT@DEG` is a twist on the spot by so
many degrees in place of the robot's jump below. With `--replans`, how long so many of them take.

Everything is disturbed. Results are appended to the file, and not computed again.
"""

import itertools
import json
import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import asdict, dataclass
from functools import lru_cache
from multiprocessing import get_context
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

import llsrbm
from llsrbm.request.scenario import DURATION, LARGEST_IMPULSE
from llsrbm.robots import load_robot

JUMPS = {
    "anymal": llsrbm.Jump(robot="anymal", twist=math.radians(60)),
    "go2": llsrbm.Jump(robot="go2", forward=0.2),
    "slider": llsrbm.Jump(robot="slider", twist=math.radians(45)),
}
DIRECTIONS = {
    "+x": (1, 0, 0),
    "-x": (-1, 0, 0),
    "+y": (0, 1, 0),
    "-y": (0, -1, 0),
    "+z": (0, 0, 1),
    "-z": (0, 0, -1),
}
MOMENTS: dict[str, Callable[[Any], float]] = {
    "end of take-off": lambda plan: plan.lift_off - DURATION,
    "mid-flight": lambda plan: (plan.lift_off + plan.touchdown) / 2,
    "50 ms before touchdown": lambda plan: plan.touchdown - 0.05,
}
STEP = 1.25  # from rung to rung; two of them are the half more that replanning is to bring
LADDER = [0.5]  # N s
while LADDER[-1] * STEP <= LARGEST_IMPULSE:
    LADDER.append(LADDER[-1] * STEP)
FIRST_GUESS = 0.15  # m/s that the whole robot gains
FAILURES = 10  # one of so many seeds may fail: 18 of 20 recover
SIZING = 40  # seeds by which the size of random pushes is found


@dataclass(frozen=True)
class Cell:
    """One entry of the table."""

    robot: str
    moment: str
    direction: str
    replan: bool
    seeds: tuple[int, int]


def jump_of(robot: str) -> llsrbm.Jump:
    """Jump of a robot's name, or `ROBOT@DEG`."""
    name, _, twist = robot.partition("@")
    return llsrbm.Jump(robot=name, twist=math.radians(float(twist))) if twist else JUMPS[name]


@lru_cache
def plan_of(robot: str) -> Any:
    return llsrbm.plan(jump_of(robot), draft=True)


def recovered(robot: str, scenario: llsrbm.Scenario) -> bool:
    return bool(llsrbm.simulate(plan_of(robot), scenario).outcome.recovered)


def largest(passes: Callable[[int], bool], guess: int) -> int:
    """The highest rung that passes, below the lowest that is found to fail; -1: none does."""
    low, high, step = -1, len(LADDER), 1
    rung = guess
    while high - low > 1:
        if passes(rung):
            low = rung
            rung = min(rung + step, high - 1) if high == len(LADDER) else (low + high) // 2
        else:
            high = rung
            rung = max(rung - step, low + 1) if low == -1 else (low + high) // 2
        step *= 2
    return low


def guess_for(robot: str) -> int:
    size = FIRST_GUESS * load_robot(jump_of(robot).robot).mass
    return min(range(len(LADDER)), key=lambda rung: abs(math.log(LADDER[rung] / size)))


def allowed_failures(seeds: int) -> int:
    """Number of seeds that may fail on a rung that passes."""
    return seeds // FAILURES


def search(cell: Cell) -> dict[str, Any]:
    """The largest impulse of a cell, N s, and on each rung that was tried how many recovered."""
    plan, tried = plan_of(cell.robot), {}

    def passes(rung: int) -> bool:
        impulse = tuple(LADDER[rung] * part for part in DIRECTIONS[cell.direction])
        push = llsrbm.Push(MOMENTS[cell.moment](plan), impulse)
        good = bad = 0
        count = cell.seeds[1] - cell.seeds[0]
        allowed = allowed_failures(count)
        for seed in range(*cell.seeds):
            scenario = llsrbm.Scenario(seed=seed, pushes=(push,), replan=cell.replan)
            if recovered(cell.robot, scenario):
                good += 1
            else:
                bad += 1
            if bad > allowed or good >= count - allowed:
                break
        tried[f"{LADDER[rung]:.3g}"] = [good, good + bad]
        return bad <= allowed

    best = largest(passes, guess_for(cell.robot))
    return {
        **asdict(cell),
        "kind": "largest",
        "seeds": list(cell.seeds),
        "impulse": LADDER[best] if best >= 0 else 0.0,
        "tried": tried,
    }


def one_random(work: tuple[str, float, bool, int]) -> bool:
    robot, size, replan, seed = work
    return recovered(robot, llsrbm.Scenario(seed=seed, random_push=size, replan=replan))


def random_pushes(
    pool: Any,
    robot: str,
    count: int,
    first: int,
    modes: Iterable[bool],
    done: list[dict[str, Any]],
    size: float,
) -> Iterator[dict[str, Any]]:
    """How many of `count` random pushes of a size are recovered from; 0: that half of them are."""

    def survived(size: float, replan: bool, seeds: range) -> int:
        work = [(robot, size, replan, seed) for seed in seeds]
        return sum(pool.imap_unordered(one_random, work, chunksize=2))

    sizing, seeds = range(first, first + min(SIZING, count)), range(first, first + count)
    common = {"kind": "random", "robot": robot, "seeds": [first, first + count]}
    known = [row for row in done if common.items() <= row.items()]
    if known:
        size = known[0]["size"]
    elif not size:
        half = len(sizing) / 2
        rung = largest(lambda rung: survived(LADDER[rung], False, sizing) >= half, guess_for(robot))
        size = LADDER[max(rung, 0)]
    for replan in modes:
        if replan not in [row["replan"] for row in known]:
            number = survived(size, replan, seeds)
            yield {**common, "size": size, "replan": replan, "recovered": number, "of": count}


def replans_of(work: tuple[str, float, int]) -> list[tuple[float, bool, int]]:
    """Seconds, whether solved, and iterations, of a simulation with a random push."""
    robot, size, seed = work
    scenario = llsrbm.Scenario(seed=seed, random_push=size, replan=True)
    rollout = llsrbm.simulate(plan_of(robot), scenario)
    return [(r.computing_time, r.solved, r.iterations) for r in rollout.replans]


def timing(pool: Any, robot: str, count: int, first: int) -> str:
    """One line on at least `count` answers."""
    size, answers = LADDER[guess_for(robot)], []
    for seed in itertools.count(first, step=8):
        work = [(robot, size, seed + k) for k in range(8)]
        answers += [row for rows in pool.map(replans_of, work, chunksize=1) for row in rows]
        if len(answers) >= count:
            break
    seconds, solved, iterations = np.array(answers).T
    p50, p95 = np.percentile(1e3 * seconds, [50, 95])
    return (
        f"{robot:8}{len(answers)} replans, random pushes of {size:.3g} N s: {p50:.1f} ms, "
        f"p95 {p95:.1f} ms, {100 * solved.mean():.1f} % solved, {iterations.mean():.1f} iterations"
    )


def table(rows: list[dict[str, Any]]) -> Iterator[str]:
    """Largest impulses, N s: without replanning, with it, and how much more that is."""
    found = {
        (r["robot"], r["moment"], r["direction"], r["replan"]): r["impulse"]
        for r in rows
        if r["kind"] == "largest"
    }
    yield f"{'N s: off/on (x)':32}" + "".join(f"{direction:>19}" for direction in DIRECTIONS)
    for robot, moment in dict.fromkeys(key[:2] for key in found):
        cells = []
        for direction in DIRECTIONS:
            off, on = (found.get((robot, moment, direction, mode)) for mode in (False, True))
            ratio = f" ({on / off:.2f})" if off and on is not None else ""
            both = "/".join("-" if value is None else f"{value:.3g}" for value in (off, on))
            cells.append(f"{both + ratio:>19}")
        yield f"{robot:8}{moment:24}" + "".join(cells)
    for row in rows:
        if row["kind"] == "random":
            mode = "with" if row["replan"] else "without"
            yield (
                f"{row['robot']:8}{row['of']} random pushes of {row['size']:.3g} N s, "
                f"{mode} replanning: {row['recovered']} recovered"
            )


def read(path: Path) -> list[dict[str, Any]]:
    return (
        [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]
        if path.exists()
        else []
    )


def main(
    out: Annotated[Path, typer.Option(help="JSON lines; what is in it is not done again.")],
    robots: str = ",".join(JUMPS),
    seeds: Annotated[str, typer.Option(help="First:last+1.")] = "5000:5020",
    replan: Annotated[str, typer.Option(help="off, on, or both with a comma.")] = "off,on",
    moments: Annotated[str, typer.Option(help="Part of the names; all if empty.")] = "",
    directions: Annotated[str, typer.Option(help="Such as +x,-z; all if empty.")] = "",
    random: Annotated[int, typer.Option(help="So many random pushes instead.")] = 0,
    size: Annotated[float, typer.Option(help="Theirs, N s; 0: half are recovered from.")] = 0.0,
    replans: Annotated[int, typer.Option(help="So many replans are timed instead.")] = 0,
    jobs: int = 2,
) -> None:
    first, last = (int(part) for part in seeds.split(":"))
    modes, done = [mode == "on" for mode in replan.split(",")], read(out)
    rows = list(done)
    with get_context("spawn").Pool(jobs) as pool, out.open("a", encoding="utf-8") as file:

        def keep(results: Iterable[dict[str, Any]]) -> None:
            for result in results:
                rows.append(result)
                file.write(json.dumps(result) + "\n")
                file.flush()

        if replans:
            for robot in robots.split(","):
                print(timing(pool, robot, replans, first))
            return
        if random:
            for robot in robots.split(","):
                keep(random_pushes(pool, robot, random, first, modes, done, size))
        else:
            cells = [
                Cell(robot, moment, direction, mode, (first, last))
                for robot in robots.split(",")
                for moment in MOMENTS
                if moments in moment
                for direction in (directions.split(",") if directions else DIRECTIONS)
                for mode in modes
            ]
            keys = {json.dumps(asdict(cell)) for cell in cells}
            names = list(asdict(cells[0]))
            finished = keys & {
                json.dumps({name: row[name] for name in names})
                for row in done
                if row["kind"] == "largest"
            }
            keep(
                pool.imap_unordered(
                    search, [cell for cell in cells if json.dumps(asdict(cell)) not in finished]
                )
            )
    print("\n".join(table(rows)))


if __name__ == "__main__":
    typer.run(main)
