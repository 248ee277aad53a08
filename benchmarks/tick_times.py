"""Time of a controller tick and of a whole simulated one, against an older commit.

    python benchmarks/tick_times.py [--against HEAD~1] [--repeats 7] [--robots anymal,slider,go2]

Both versions simulate the same plans, made by the older one, in processes that take turns, so that
whatever else the machine does slows both down; the fastest repeat of each counts. Torques of both
rollouts are compared until they are 1e-3 of the largest apart. Parts of a tick are timed in further
runs of this version, whose timers cost a little.
"""

import argparse
import functools
import inspect
import io
import json
import math
import os
import statistics
import subprocess
import sys
import tarfile
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import llsrbm

HERE = Path(__file__).resolve()
REPOSITORY = HERE.parents[1]
JUMPS = {
    "anymal": {"twist": math.radians(90.0)},
    "slider": {"forward": 0.2},
    "go2": {"forward": 0.3},
}


# --- In a process of either version: `llsrbm` is that version's. ---


def make_plan(robot: str, path: str) -> None:
    """Save the plan that both versions follow: a draft, which is all that older ones made."""
    quick = {"draft": True} if "draft" in inspect.signature(llsrbm.plan).parameters else {}
    llsrbm.plan(llsrbm.Jump(robot=robot, **JUMPS[robot]), **quick).save(path)


def follow(plan_path: str, torque_path: str) -> dict[str, float]:
    """Simulate; torques are saved, times returned, s: of a controller tick, and all a tick.

    The latter is processor time, with what comes before the first tick and after the last.
    """
    plan = llsrbm.load(plan_path)
    llsrbm.simulate(plan)  # the first reads meshes and warms caches
    start = time.process_time()
    rollout = llsrbm.simulate(plan)
    whole = time.process_time() - start
    np.save(torque_path, rollout.torque)
    return {
        "controller": rollout.outcome.tick_median_s,
        "whole": whole / len(rollout.time),
    }


def parts(plan_path: str) -> dict[str, float]:
    """Mean times of a tick's parts, s, inner ones taken off the outer."""
    from llsrbm.control.contact_schedule import ContactSchedule
    from llsrbm.control.controller import WholeBodyController
    from llsrbm.control.detection import ResidualDetector
    from llsrbm.control.inverse_dynamics import InverseDynamics
    from llsrbm.control.qp import Qp
    from llsrbm.control.whole_body import WholeBody

    spent: dict[str, float] = {}
    inside: list[float] = []  # time in timed functions called by those that are running

    def timed(owner: type, name: str, part: str) -> None:
        function: Callable[..., Any] = getattr(owner, name)
        spent[part] = spent.get(part, 0.0)

        @functools.wraps(function)
        def wrapped(*arguments: Any, **named: Any) -> Any:
            inside.append(0.0)
            start = time.perf_counter()
            try:
                return function(*arguments, **named)
            finally:
                duration = time.perf_counter() - start
                spent[part] += duration - inside.pop()
                if inside:
                    inside[-1] += duration

        setattr(owner, name, wrapped)

    timed(WholeBody, "update", "dynamics")
    timed(InverseDynamics, "_set_costs", "tasks")
    timed(InverseDynamics, "solve", "QP, setting up")
    timed(Qp, "solve", "QP, solving")
    timed(ResidualDetector, "update", "detection")
    timed(ContactSchedule, "find_contacts", "detection")
    step = "step" if hasattr(WholeBodyController, "step") else "tick"
    timed(WholeBodyController, step, "rest")
    rollout = llsrbm.simulate(llsrbm.load(plan_path))
    return {part: total / len(rollout.time) for part, total in spent.items()}


# --- In the process that was started. ---


def checked_out(commit: str, folder: Path) -> Path:
    """The repository as it was, in a folder."""
    packed = subprocess.run(
        ["git", "archive", commit], cwd=REPOSITORY, check=True, capture_output=True
    ).stdout
    with tarfile.open(fileobj=io.BytesIO(packed)) as archive:
        archive.extractall(folder, filter="data")
    return folder


def run(version: Path, *arguments: str) -> Any:
    """Result of one of the functions above in a process of a version."""
    environment = {**os.environ, "PYTHONPATH": str(version)}
    done = subprocess.run(
        [sys.executable, str(HERE), "--inside", *arguments],
        cwd=version,
        env=environment,
        check=True,
        capture_output=True,
        text=True,
    )
    return json.loads(done.stdout.splitlines()[-1])


def difference(one: Path, other: Path) -> str:
    """Largest relative difference of torques until they are 1e-3 apart, and when that is."""
    a, b = np.load(one), np.load(other)
    ticks = min(len(a), len(b))
    apart = np.abs(a[:ticks] - b[:ticks]).max(axis=1) / np.abs(b).max()
    beyond = np.flatnonzero(apart > 1e-3)
    until = beyond[0] if len(beyond) else ticks
    if until == 0:
        return "apart from the first tick"
    words = "to the end" if until == ticks else f"until tick {until} of {ticks}"
    return f"{apart[:until].max():.0e} {words}"


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--against", default="HEAD~1", metavar="COMMIT")
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument("--robots", default=",".join(JUMPS))
    parser.add_argument("--inside", nargs="+", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.inside:
        name, *rest = arguments.inside
        functions = {"make_plan": make_plan, "follow": follow, "parts": parts}
        print(json.dumps(functions[name](*rest)))
        return
    robots = arguments.robots.split(",")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        old = checked_out(arguments.against, folder / "old")
        print(f"microseconds; here / {arguments.against}; fastest of {arguments.repeats}")
        print("| robot | controller tick | ratio | simulation a tick | ratio | torques differ by |")
        print("|---|---|---|---|---|---|")
        for robot in robots:
            plan = str(folder / f"{robot}.npz")
            run(old, "make_plan", robot, plan)
            torques = {
                version: folder / f"{robot}-{version.name}.npy" for version in (REPOSITORY, old)
            }
            times: dict[Path, list[dict[str, float]]] = {REPOSITORY: [], old: []}
            for _ in range(arguments.repeats):
                for version, done in times.items():
                    done.append(run(version, "follow", plan, str(torques[version])))
            row = [robot]
            for kind in ("controller", "whole"):
                here, there = (min(one[kind] for one in done) for done in times.values())
                row += [f"{1e6 * here:.0f} / {1e6 * there:.0f}", f"{here / there:.2f}"]
            print("| " + " | ".join([*row, difference(*torques.values())]) + " |", flush=True)
        print()
        header: list[str] = []
        for robot in robots:
            runs = [run(REPOSITORY, "parts", str(folder / f"{robot}.npz")) for _ in range(3)]
            spent = {part: statistics.median(one[part] for one in runs) for part in runs[0]}
            if not header:
                header = ["robot", *spent]
                print("| " + " | ".join(header) + " |")
                print("|" + "---|" * len(header))
            total = sum(spent.values())
            shares = [f"{1e6 * s:.0f} ({s / total:.0%})" for s in spent.values()]
            print("| " + " | ".join([robot, *shares]) + " |", flush=True)


if __name__ == "__main__":
    sys.exit(main())
