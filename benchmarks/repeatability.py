"""Does the same simulation with replanning give the same rollout on an idle and a loaded machine?

    python -m benchmarks.repeatability --robots anymal,go2,slider --load 4

Each robot is pushed and plans anew in a process of its own: alone, beside `--load` busy processes,
and without compiled functions. Printed is whether every array of the rollouts is equal to the last
bit, and the computing times, which differ.
"""

import hashlib
import json
import math
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import fields
from typing import Annotated, Any

import numpy as np
import typer

import llsrbm

JUMPS: dict[str, dict[str, float]] = {
    "anymal": {"twist": math.radians(60)},
    "go2": {"forward": 0.2},
    "slider": {"twist": math.radians(45)},
}
PUSH = {"anymal": 14.0, "go2": 7.0, "slider": 3.5}  # N s
SEED = 3000
BUSY = "while True: pass"


def digests(rollout: Any) -> dict[str, str]:
    """A hash of every array of a rollout, and of all that its new plans hold but their time."""
    arrays = {f.name: getattr(rollout, f.name) for f in fields(rollout)}
    for index, replan in enumerate(rollout.replans):
        for field in fields(replan):
            if field.name != "computing_time":
                arrays[f"replan {index} {field.name}"] = np.asarray(getattr(replan, field.name))
    return {
        name: hashlib.sha256(np.ascontiguousarray(array).tobytes()).hexdigest()
        for name, array in arrays.items()
        if isinstance(array, np.ndarray)
    }


def one(robot: str, latency: str) -> dict[str, Any]:
    """Simulate one robot's jump: digests and computing times."""
    plan = llsrbm.plan(llsrbm.Jump(robot=robot, **JUMPS.get(robot, JUMPS["anymal"])), draft=True)
    push = llsrbm.Push(plan.lift_off - 0.02, (0.0, PUSH.get(robot, 3.5), 0.0))
    rollout = llsrbm.simulate(plan, seed=SEED, pushes=(push,), replan=True, replan_latency=latency)
    outcome = rollout.outcome
    return {
        "digests": digests(rollout),
        "median": outcome.replan_median_s,
        "p95": outcome.replan_p95_s,
        "followed": sum(math.isfinite(replan.applied) for replan in rollout.replans),
    }


@contextmanager
def busy(processes: int) -> Iterator[None]:
    """So many processes that do nothing but keep the machine busy."""
    running = [subprocess.Popen([sys.executable, "-c", BUSY]) for _ in range(processes)]
    try:
        yield
    finally:
        for process in running:
            process.kill()
            process.wait()


def run(robot: str, latency: str, *, compiled: bool) -> dict[str, Any]:
    """`one` in a process of its own."""
    environment = os.environ | ({} if compiled else {"LLSRBM_COMPILE": "0"})
    command = [sys.executable, "-m", "benchmarks.repeatability", "--one", robot]
    done = subprocess.run(
        [*command, "--latency", latency], env=environment, stdout=subprocess.PIPE, check=True
    )
    return dict(json.loads(done.stdout))


def differences(first: dict[str, str], other: dict[str, str]) -> list[str]:
    """Names of the arrays that are not equal, or missing on one side."""
    return sorted(n for n in first.keys() | other.keys() if first.get(n) != other.get(n))


def main(
    robots: str = ",".join(JUMPS),
    load: Annotated[int, typer.Option(help="Busy processes.")] = 4,
    latency: Annotated[str, typer.Option(help="fixed or measured.")] = "fixed",
    one_robot: Annotated[str, typer.Option("--one", hidden=True)] = "",
) -> None:
    """Print a line a robot and condition; exit 1 where any array differs."""
    if one_robot:
        print(json.dumps(one(one_robot, latency)))
        return
    equal = True
    for robot in robots.split(","):
        idle = run(robot, latency, compiled=True)
        with busy(load):
            loaded = run(robot, latency, compiled=True)
        plain = run(robot, latency, compiled=False)
        for name, result in (("idle", idle), (f"{load} busy", loaded), ("not compiled", plain)):
            differing = differences(idle["digests"], result["digests"])
            equal &= not differing
            verdict = f"differ: {', '.join(differing[:5])}" if differing else "equal"
            print(
                f"{robot:8} {name:13} {len(result['digests'])} arrays {verdict}; "
                f"{result['followed']} new plans followed, computing "
                f"{1e3 * result['median']:.1f} ms, p95 {1e3 * result['p95']:.1f} ms",
                flush=True,
            )
    raise typer.Exit(0 if equal else 1)


if __name__ == "__main__":
    typer.run(main)
