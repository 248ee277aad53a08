"""The share of a robot's whole range that lands: random requests, judged strictly.

    python -m benchmarks.range --robots anymal,slider,go2 --requests 120 --seed 500
    python -m benchmarks.range --requests 60 --seed 9001 --estimators truth,imu
    python -m benchmarks.range --robots go2 --requests 60 --seed 9001 --draft

Half of the requests ask for one component alone, half for all four at once, uniform over the robot
file's [task]. Each is planned as `llsrbm.plan` does by itself and simulated once with everything
disturbed that `llsrbm.simulation.disturbance` disturbs; strict success is defined in
`llsrbm.simulation.verdict`; "holds" counts plans whose certificate holds, which the page calls
feasible, and "of these" those of them that are strict.
Requests and disturbances follow from the seed alone. Controller and planner were tuned on seeds
below 500, and seed 500 has been looked at since. The column "moved" counts boxes that come or go in
mid-flight for want of room at the start (`llsrbm.motion.surroundings`).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from itertools import chain
from multiprocessing import get_context
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from scipy.spatial.transform import Rotation

import llsrbm
from benchmarks.counting import count, write_lines
from llsrbm.look.shown_motion import surroundings_of
from llsrbm.mechanics import tilt
from llsrbm.robots import load_robot

COMPONENTS = ("twist", "forward", "lateral", "height")
KINDS = ("one component", "combined")
SIMULATION_SEEDS = 10_000  # requests of different seeds get different disturbances


def requests(robot: str, count: int, seed: int) -> list[dict[str, Any]]:
    """Random requests of a robot, the same for the same seed."""
    task = load_robot(robot).file.task
    rng = np.random.default_rng(seed)
    made = []
    for index in range(count):
        kind = KINDS[index % 2]
        values = {name: float(rng.uniform(*getattr(task, name))) for name in COMPONENTS}
        alone = COMPONENTS[rng.integers(len(COMPONENTS))]
        motion = values if kind == "combined" else {alone: values[alone]}
        made.append(
            {"robot": robot, "kind": kind, "seed": seed * SIMULATION_SEEDS + index, **motion}
        )
    return made


@dataclass(frozen=True)
class Ways:
    """How requests are planned and simulated."""

    model: str
    once: bool  # no search for nearer jumps
    draft: bool
    estimators: tuple[str, ...]


def one(request: dict[str, Any], ways: Ways) -> list[dict[str, Any]]:
    """Plan one request and simulate it with each estimator."""
    motion = {name: request[name] for name in COMPONENTS if name in request}
    jump = llsrbm.Jump(robot=request["robot"], model=ways.model, **motion)
    try:
        plan = llsrbm.plan(jump, patient=not ways.once, explains=False, draft=ways.draft)
    except llsrbm.NotConverged as error:
        unplanned = {**request, "planned": False, "why": str(error)}
        return [{**unplanned, "estimator": estimator} for estimator in ways.estimators]
    return [simulated(request, plan, estimator) for estimator in ways.estimators]


def simulated(request: dict[str, Any], plan: Any, estimator: str) -> dict[str, Any]:
    """Simulate one request's plan."""
    jump = plan.jump
    rollout = llsrbm.simulate(plan, seed=request["seed"], estimator=estimator)
    around = surroundings_of(rollout, load_robot(jump.robot))
    return {
        **request,
        "estimator": estimator,
        "planned": True,
        "moved": bool(around.in_mid_flight),
        "certified": plan.certified,
        "iterations": plan.effort.iterations,
        "from_table": plan.report.attempts == 0,
        "solve_time_s": plan.effort.solve_time_s,
        "durations": np.diff(plan.phase_start).tolist(),
        **asdict(rollout.outcome),
        **tracking(plan, rollout),
    }


def tracking(plan: Any, rollout: Any) -> dict[str, Any]:
    """Momenta at lift-off and the base's attitude at touchdown, planned and simulated."""
    lift, touch = plan.lift_off, plan.touchdown
    knots = np.searchsorted(plan.time, [lift - 1e-9, touch - 1e-9])
    end = rollout.outcome.touchdown_true_s
    # To the nearest tick: one later it has fallen for 2.5 ms.
    at = np.searchsorted(rollout.time, np.array([lift, touch if end is None else end]))
    at = np.minimum(at, len(rollout.time) - 1)
    at -= rollout.time[at] - [lift, touch if end is None else end] > np.diff(rollout.time[:2]) / 2
    figures = {
        "lift_off_momentum_planned": plan.angular_momentum[knots[0]].tolist(),
        "lift_off_momentum": rollout.angular_momentum[at[0]].tolist(),
        "lift_off_velocity_planned": plan.com_velocity[knots[0]].tolist(),
        "lift_off_velocity": (
            rollout.linear_momentum[at[0]] / rollout.disturbance.mass(load_robot(plan.jump.robot))
        ).tolist(),
        "turn_error_at_lift_off_deg": turn_deg(plan.base_quat[knots[0]], rollout.base_quat[at[0]]),
        "turn_error_at_touchdown_deg": turn_deg(plan.base_quat[knots[1]], rollout.base_quat[at[1]]),
        "tilt_at_touchdown_planned_deg": math.degrees(tilt(plan.base_quat[[knots[1]]])[0]),
        "tilt_at_touchdown_deg": math.degrees(tilt(rollout.base_quat[[at[1]]])[0]),
    }
    if hasattr(plan, "joint_torque"):
        figures["torque_rms"] = torque_rms(plan, rollout)
    share = np.abs(rollout.torque) / np.maximum(rollout.torque_limit, 1e-9) >= 0.99
    figures["saturated"] = []
    for phase, name in enumerate(plan.schedule.names):
        ticks = rollout.phase == phase
        busy = share[ticks].mean(axis=0) if ticks.any() else np.zeros(share.shape[1])
        worst = int(busy.argmax())
        figures["saturated"].append([name, rollout.joint_names[worst], busy[worst]])
    return figures


def torque_rms(plan: Any, rollout: Any) -> float:
    """RMS of simulated minus planned joint torque over the take-off, share of the limit."""
    limit = load_robot(plan.jump.robot).torque_limit
    order = [plan.joint_names.index(name) for name in rollout.joint_names]
    # A tick that begins at lift-off has the flight's torques.
    ticks = rollout.time < plan.lift_off - rollout.time[1] / 2
    knot = np.searchsorted(plan.time, rollout.time[ticks], side="right") - 1
    error = (rollout.torque[ticks] - plan.joint_torque[knot][:, order]) / limit[order]
    return float(np.sqrt(np.mean(error**2)))


def turn_deg(planned: np.ndarray, simulated: np.ndarray) -> list[float]:
    """Rotation vector from a planned to a simulated attitude, world axes."""
    turn = (
        Rotation.from_quat(simulated, scalar_first=True)
        * Rotation.from_quat(planned, scalar_first=True).inv()
    )
    return np.degrees(turn.as_rotvec()).tolist()


def table(results: list[dict[str, Any]]) -> Iterator[str]:
    """One row a robot, estimator and kind."""
    yield (
        f"{'robot':8} {'estimator':9} {'kind':14} {'requests':>8} {'offered':>8} "
        f"{'holds':>6} {'of these':>8} {'stand':>6} {'strict':>6} {'of offered':>10} "
        f"{'of all':>7} {'yaw med':>8} {'worst':>6} {'<5deg':>6} {'sat med':>8} {'worst':>6} "
        f"{'torque':>7} {'unsolved':>8} {'moved':>6}"
    )
    for robot, estimator in dict.fromkeys((r["robot"], r["estimator"]) for r in results):
        for kind in (*KINDS, "all"):
            rows = [
                r
                for r in results
                if (r["robot"], r["estimator"]) == (robot, estimator) and kind in (r["kind"], "all")
            ]
            offered = [r for r in rows if r["planned"]]
            if not offered:
                yield f"{robot:8} {estimator:9} {kind:14} {len(rows):8} {0:8}"
                continue
            yaw = np.degrees(
                [abs(180.0 if (e := r["yaw_error_at_touchdown"]) is None else e) for r in offered]
            )
            saturated = 100 * np.array([r["saturated_fraction"] for r in offered])
            counts = count(rows)
            torque = [r["torque_rms"] for r in offered if "torque_rms" in r]
            shown = f"{100 * np.median(torque):6.1f}%" if torque else f"{'-':>7}"
            yield (
                f"{robot:8} {estimator:9} {kind:14} {counts.requests:8} {counts.planned:8} "
                f"{sum(r['certified'] for r in offered):6} "
                f"{sum(r['certified'] and r['strict'] for r in offered):8} "
                f"{counts.stand:6} {counts.strict:6} "
                f"{100 * counts.strict / counts.planned:9.1f}% "
                f"{100 * counts.strict / counts.requests:6.1f}% "
                f"{np.median(yaw):8.1f} {yaw.max():6.1f} {100 * np.mean(yaw <= 5):5.0f}% "
                f"{np.median(saturated):7.1f}% {saturated.max():5.1f}% {shown} "
                f"{sum(r['unsolved_ticks'] > 0 for r in offered):8} "
                f"{sum(r['moved'] for r in offered):6}"
            )


def describe(result: dict[str, Any]) -> str:
    """One line a request."""
    motion = " ".join(
        f"{name} {math.degrees(result[name]):.0f} deg"
        if name == "twist"
        else f"{name} {result[name]:+.2f}"
        for name in COMPONENTS
        if name in result
    )
    head = f"{result['robot']:7} {result['estimator']:6} {result['seed']:8} {motion:60}"
    if not result["planned"]:
        return f"{head} not planned: {result['why'][:150]}"
    phase, joint, share = max(result["saturated"], key=lambda item: item[2])
    yaw = result["yaw_error_at_touchdown"]
    return (
        f"{head} {'strict' if result['strict'] else result['status']:6} "
        f"yaw {math.degrees(yaw) if yaw is not None else math.nan:6.1f} "
        f"tilt at touchdown {result['tilt_at_touchdown_deg']:4.1f} of "
        f"{result['tilt_at_touchdown_planned_deg']:4.1f}, "
        f"most {math.degrees(result['peak_tilt']):4.1f} "
        f"foot {1e3 * result['foot_error']:4.0f} mm air {1e3 * result['second_flight_s']:3.0f} ms "
        f"saturated {100 * result['saturated_fraction']:4.1f} % "
        f"({joint} {100 * share:.0f} % in {phase}) "
        f"{result['iterations']} it {'' if result['certified'] else 'not certified '}"
        f"{result['reason'] or result['touched']}"
    )


def _work(item: tuple[dict[str, Any], Ways]) -> list[dict[str, Any]]:
    return one(*item)


def main(
    robots: str = "anymal,slider,go2",
    count: Annotated[int, typer.Option("--requests", help="A robot.")] = 120,
    seed: Annotated[int, typer.Option(help="Draws requests and disturbances.")] = 500,
    model: str = "llsrbm-plus",
    estimators: Annotated[str, typer.Option(help="Names; each simulates every plan.")] = "truth",
    once: Annotated[bool, typer.Option("--once", help="No search for nearer jumps.")] = False,
    draft: Annotated[bool, typer.Option("--draft", help="Drafts alone.")] = False,
    jobs: int = 2,
    failures: Annotated[bool, typer.Option(help="Only lines of failures.")] = False,
    out: Annotated[Path | None, typer.Option(help="All results, JSON lines.")] = None,
) -> None:
    """Print a line a request, then the table."""
    ways = Ways(model, once, draft, tuple(estimators.split(",")))
    work = [
        (request, ways) for robot in robots.split(",") for request in requests(robot, count, seed)
    ]
    results = []
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        for result in chain.from_iterable(pool.map(_work, work, chunksize=4)):
            results.append(result)
            if not (failures and result.get("strict")):
                print(describe(result), flush=True)
    print("\n".join(table(results)))
    if out is not None:
        write_lines(out, results)


if __name__ == "__main__":
    typer.run(main)
