"""Motions made foreign and repaired (`llsrbm repair`), and contact phases of simulated ones.

    python -m benchmarks.repair score --robots go2,anymal,g1 --count 10 --seed 21000 --out F
    python -m benchmarks.repair edges --robots go2,anymal,g1 --count 10 --seed 21000

Plans of random requests over 0.8 of a robot's range, every third a draft by `srbm`, are written as
other tools' files and made foreign: played 0.8 to 1.3 times as long, lifted or sunk by up to 3 cm,
somewhere else in the world with another heading, every joint of every frame off by a standard
deviation of 0.01 rad, the joints in another order. `score` repairs them; `edges` simulates plans
with everything disturbed, writes them at 50 frames/s, and compares the flights that are found with
the simulator's contacts. With `--out` what is done is not done again. Requests and what makes them
foreign follow from the seed alone; phases were tuned on seed 777 of requests.
"""

import json
import math
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

import llsrbm
from benchmarks.range import COMPONENTS, requests
from llsrbm.formats import load_motion
from llsrbm.mechanics import quaternion_product, quaternions_about_z, turns_about_z
from llsrbm.motion.flights import flights
from llsrbm.motion.plan import Plan
from llsrbm.repairing.phases import contact_phases

SHARE = 0.8  # of the ranges of robots' files
STRETCH, LIFT, NOISE, AWAY = (0.8, 1.3), 0.03, 0.01, 3.0  # m and rad
JOINTS, LANDING, EDGE = 0.15, 0.03, 0.02  # rad, m, s: what is asked of repairs and of phases
RATES = {"motion-npz": 50.0, "unitree-csv": 30.0}
ROBOTS = "go2,anymal,g1"

app = typer.Typer()


def sources(robot: str, count: int, seed: int, kept: Path | None) -> Iterator[tuple[int, Plan]]:
    """Plans of random requests, those that were found, with the numbers of their requests."""
    found = 0
    for index, request in enumerate(requests(robot, 4 * count, seed)):
        if found == count:
            return
        motion = {name: SHARE * request[name] for name in COMPONENTS if name in request}
        model = "srbm" if index % 3 == 2 else "llsrbm-plus"
        jump = llsrbm.Jump(robot=robot, model=model, **motion)
        plan = _planned(jump, kept and kept / f"{robot}-{seed}-{index}.npz")
        if plan is not None:
            found += 1
            yield index, plan


def _planned(jump: llsrbm.Jump, path: Path | None) -> Plan | None:
    """The plan of a jump, kept in a file; None, and an empty file: there is none."""
    if path is not None and path.exists():
        return llsrbm.load(path) if path.stat().st_size else None
    try:
        plan = llsrbm.plan(jump, patient=False, explains=False, draft=jump.model == "srbm")
    except llsrbm.NotConverged:
        plan = None
    if plan is not None and not plan.certified and jump.model != "srbm":
        plan = None
    if path is not None:
        path.parent.mkdir(exist_ok=True)
        path.touch() if plan is None else plan.save(path)
    return plan


def foreign(plan: Plan, folder: Path, rng: np.random.Generator) -> tuple[Path, dict[str, Any]]:
    """A file of another tool with the plan's motion made foreign, and how it was."""
    format_ = str(rng.choice(list(RATES)))
    made = {
        "format": format_,
        "stretch": float(rng.uniform(*STRETCH)),
        "lift": float(rng.uniform(-LIFT, LIFT)),
        "yaw": float(rng.uniform(-math.pi, math.pi)),
        "away": rng.uniform(-AWAY, AWAY, 2).tolist(),
    }
    path = folder / f"foreign{'.npz' if format_ == 'motion-npz' else '.csv'}"
    llsrbm.export(plan, path, format=format_, fps=RATES[format_])
    write = _as_npz if format_ == "motion-npz" else _as_csv
    write(path, made, rng)
    return path, made


def _as_npz(path: Path, made: dict[str, Any], rng: np.random.Generator) -> None:
    with np.load(path) as file:
        arrays = {name: file[name] for name in file.files if name != "meta"}
    slower = made["stretch"]
    arrays["fps"] = arrays["fps"] / slower
    turn = turns_about_z(made["yaw"]).T
    for name in ("body_lin_vel_w", "body_ang_vel_w"):
        arrays[name] = arrays[name] @ turn / slower
    arrays["joint_vel"] = arrays["joint_vel"] / slower
    arrays["body_pos_w"] = arrays["body_pos_w"] @ turn + [*made["away"], made["lift"]]
    arrays["body_quat_w"] = _turned(arrays["body_quat_w"], made)
    order = rng.permutation(arrays["joint_pos"].shape[1])
    arrays["joint_pos"] = _noisy(arrays["joint_pos"], rng)[:, order]
    arrays["joint_vel"] = arrays["joint_vel"][:, order]
    arrays["joint_names"] = arrays["joint_names"][order]
    np.savez(path, **arrays)


def _as_csv(path: Path, made: dict[str, Any], rng: np.random.Generator) -> None:
    rows, beside = np.loadtxt(path, delimiter=","), Path(f"{path}.meta.json")
    meta = json.loads(beside.read_text("utf-8"))
    place = rows[:, :3] @ turns_about_z(made["yaw"]).T + [*made["away"], made["lift"]]
    quat = _turned(rows[:, [6, 3, 4, 5]], made)[:, [1, 2, 3, 0]]
    order = rng.permutation(rows.shape[1] - 7)
    joints = _noisy(rows[:, 7:], rng)[:, order]
    np.savetxt(path, np.hstack([place, quat, joints]), fmt="%.9f", delimiter=",")
    meta["fps"] /= made["stretch"]
    meta["joint_order"] = [meta["joint_order"][k] for k in order]
    beside.write_text(json.dumps(meta), "utf-8")


def _turned(quat: np.ndarray, made: dict[str, Any]) -> np.ndarray:
    turn = np.broadcast_to(quaternions_about_z(made["yaw"]), quat.shape)
    return quaternion_product(turn, quat)


def _noisy(joints: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    return joints + rng.normal(scale=NOISE, size=joints.shape)


def one(plan: Plan, rng: np.random.Generator) -> dict[str, Any]:
    """Make one plan foreign and repair it."""
    with tempfile.TemporaryDirectory() as folder:
        path, made = foreign(plan, Path(folder), rng)
        began, worked = time.perf_counter(), time.process_time()
        found = llsrbm.repair(path, robot=plan.jump.robot)
        took = time.perf_counter() - began, time.process_time() - worked
    moved = found.moved
    return {
        **made,
        "status": found.status,
        "why": found.why,
        "broken": [check.name for check in found.before.broken],
        "wall_s": took[0],
        "processor_s": took[1],
        **({} if moved is None else vars(moved)),
        **({} if found.plan is None else {"iterations": found.plan.effort.iterations}),
    }


@app.command()
def score(
    robots: str = ROBOTS,
    count: Annotated[int, typer.Option(help="Motions a robot.")] = 10,
    seed: int = 21000,
    out: Annotated[Path | None, typer.Option(help="Results, JSON lines; goes on there.")] = None,
    plans: Annotated[Path | None, typer.Option(help="Folder that keeps the plans.")] = None,
) -> None:
    """Print a line a motion, then how many were repaired."""
    results = _kept(out)
    done = {(each["robot"], each["seed"], each["request"]) for each in results}
    for robot in robots.split(","):
        for index, plan in sources(robot, count, seed, plans):
            if (robot, seed, index) in done:
                continue
            rng = np.random.default_rng([seed, index])
            key = {"robot": robot, "seed": seed, "request": index, "model": plan.jump.model}
            result = key | one(plan, rng)
            results.append(result)
            print(_line(result), flush=True)
            if out is not None:
                with out.open("a", encoding="utf-8") as file:
                    file.write(json.dumps(result) + "\n")
    print("\n".join(_table(results)))


def _kept(out: Path | None) -> list[dict[str, Any]]:
    if out is None or not out.exists():
        return []
    return [json.loads(line) for line in out.read_text("utf-8").splitlines()]


def _holds(result: dict[str, Any]) -> bool:
    return (
        result["status"] != "failed"
        and result["joint_rms_rad"] <= JOINTS
        and result["landing_m"] <= LANDING
    )


def _line(result: dict[str, Any]) -> str:
    head = (
        f"{result['robot']:7} {result['request']:3} {result['model']:12} {result['format']:11} "
        f"x {result['stretch']:.2f} {100 * result['lift']:+.1f} cm {result['status']:9}"
    )
    if "joint_rms_rad" in result:
        head += (
            f" joints {result['joint_rms_rad']:.3f} rad, base {100 * result['base_rms_m']:.1f} cm, "
            f"landing {100 * result['landing_m']:.1f} cm, {result['iterations']} it"
        )
    times = f"{result['wall_s']:.1f} s, of the processor {result['processor_s']:.1f}"
    return f"{head}; {times}; {result['why'] if result['status'] == 'failed' else ''}"


def _table(results: list[dict[str, Any]]) -> Iterator[str]:
    for robot in (*dict.fromkeys(each["robot"] for each in results), "all"):
        rows = [each for each in results if robot in (each["robot"], "all")]
        moved = [each for each in rows if "joint_rms_rad" in each]
        certified = sum(each["status"] != "failed" for each in rows)
        yield (
            f"{robot:7} {len(rows)} motions, {certified} certified, {sum(map(_holds, rows))} of "
            f"these within {JOINTS:g} rad and {100 * LANDING:g} cm; median joints "
            f"{np.median([each['joint_rms_rad'] for each in moved]):.3f} rad, landing "
            f"{100 * np.median([each['landing_m'] for each in moved]):.1f} cm, "
            f"{np.median([each['wall_s'] for each in rows]):.1f} s, of the processor "
            f"{np.median([each['processor_s'] for each in rows]):.1f} s"
        )


@app.command()
def edges(
    robots: str = ROBOTS,
    count: Annotated[int, typer.Option(help="Motions a robot.")] = 10,
    seed: int = 21000,
    plans: Annotated[Path | None, typer.Option(help="Folder that keeps the plans.")] = None,
) -> None:
    """Print a line a simulated motion: how far its flight's edges are from the contacts'."""
    worst = []
    for robot in robots.split(","):
        for index, plan in sources(robot, count, seed, plans):
            rollout = llsrbm.simulate(plan, seed=10_000 * seed + index)
            (truth,) = flights(rollout)
            with tempfile.TemporaryDirectory() as folder:
                path = Path(folder) / "rollout.npz"
                llsrbm.export(rollout, path, format="motion-npz")
                phases = contact_phases(load_motion(path, robot))
            found = [phase for phase in phases if not phase.feet]
            if truth.duration is None or len(found) != 1:
                worst.append(math.inf)
                print(f"{robot:7} {index:3} {len(found)} flights found", flush=True)
                continue
            off = (
                found[0].start_s - truth.lift_off + rollout.time[0],
                found[0].end_s - truth.touchdown + rollout.time[0],
            )
            worst.append(max(map(abs, off)))
            ms = " and ".join(f"{1e3 * each:+.1f} ms" for each in off)
            print(f"{robot:7} {index:3} lift-off and touchdown off by {ms}", flush=True)
    held = sum(each <= EDGE for each in worst)
    print(f"{len(worst)} motions, {held} with both edges within {1e3 * EDGE:g} ms")


if __name__ == "__main__":
    app()
