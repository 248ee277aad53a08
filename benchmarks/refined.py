"""The whole body's plans on random requests: convergence, effort, certificates, landings.

    python -m benchmarks.refined --robots go2,anymal,slider,g1 --requests 40 --seed 7200

Requests are those of `benchmarks.range`. Each is planned from a table or the analytic guess,
without a search for the nearest one, and what is planned is refined in the same process. Times are
those in the solvers, compiled where there is a compiler (`--compiled` waits for it), in CasADi's
virtual machine with LLSRBM_COMPILE=0; "processor" is the processor's time for the whole body's
plan over that for the first one, whole calls. Stops, inverse dynamics and standing feet are
Pinocchio's, at 1 kHz: RMS and worst difference of its torques from the planned ones, as shares of
the drives'. Certificates are those of `llsrbm.certify`; strict, of the first and of the whole
body's plan, simulated with everything disturbed, as in `benchmarks.range`.
"""

import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import pinocchio as pin
import typer

import llsrbm
from benchmarks.counting import write_lines
from benchmarks.range import COMPONENTS, requests
from llsrbm.body.efforts import efforts
from llsrbm.body.joint_loads import joint_loads
from llsrbm.body.knot_motion import KnotMotion
from llsrbm.body.peak_loads import torque_share
from llsrbm.planning.answer.planner import planner_of
from llsrbm.planning.whole_body.motion import Motion
from llsrbm.planning.whole_body.refine import refiner_of
from llsrbm.request.jump_types import with_defaults
from llsrbm.robots import load_robot
from llsrbm.robots.drives.torques import torque_in_direction
from llsrbm.robots.robot import Robot

STEP = 1e-3  # s


def one(
    request: dict[str, Any], kind: str, share: float, *, settle: bool = False
) -> dict[str, Any]:
    """Plan and refine one request, `share` of its displacement; `settle`: by compiled solvers."""
    motion = {name: share * request[name] for name in COMPONENTS if name in request}
    jump = with_defaults(llsrbm.Jump(robot=request["robot"], type=kind, **motion))
    try:
        planner = planner_of(jump)
        if settle:
            planner.formulation.solver.settle()
        begun = time.process_time()
        first = llsrbm.plan(jump, patient=False, explains=False, draft=True)
    except (llsrbm.NotConverged, llsrbm.InputError) as error:
        return {**request, "planned": False, "why": str(error)}
    planned = time.process_time()
    refiner = refiner_of(first)
    if settle:
        refiner.solver.settle()
    built = time.process_time()
    second = refiner.refine(first)
    processor = (time.process_time() - built) / (planned - begun)
    report = second.refinement
    assert report is not None
    result = {
        **request,
        "planned": True,
        "refined": second.refined,
        "iterations": report.iterations,
        "first_s": first.report.solve_time_s,
        "second_s": report.solve_time_s,
        "total_s": report.total_time_s,
        "compiled": not report.compiling,
        "processor": processor,
        "strict_before": strict(first, request["seed"]),
    }
    if not second.refined:
        return result
    certificate = llsrbm.certify(second)
    assert refiner.last is not None
    return (
        result
        | looked_at(first, second, refiner.last)
        | {
            "holds": certificate.holds,
            "broken": [(each.name, each.worst) for each in certificate.broken],
            "strict": strict(second, request["seed"]),
        }
    )


def strict(plan: llsrbm.Plan, seed: int) -> bool:
    """Whether a plan lands strictly with everything disturbed."""
    return llsrbm.simulate(plan, seed=seed).outcome.strict


def looked_at(first: llsrbm.Plan, second: llsrbm.Plan, motion: Motion) -> dict[str, Any]:
    """Figures of both plans by Pinocchio."""
    robot = load_robot(first.jump.robot)
    weight = robot.mass * 9.81
    lacking = np.abs(joint_loads(robot, KnotMotion.of_plan(first)).base_residual)
    middles = motion.at((second.time[1:] + second.time[:-1]) / 2)
    left = np.abs(efforts(robot, middles.q, middles.v, middles.a, middles.force)[:, :6])
    instants = np.arange(0.0, second.time[-1], STEP)
    at = motion.at(instants)
    needed = efforts(robot, at.q, at.v, at.a, at.force)
    planned = motion.between(second.joint_torque[:-1], instants)
    off = (needed[:, 6:] - planned) / robot.torque_limit
    available = torque_in_direction(robot, at.v[:, 6:], needed[:, 6:])
    return {
        "stop_before": beyond_stops(robot, first.joint_position),
        "stop_after": beyond_stops(robot, at.q[:, 7:]),
        "force_after": left[:, :3].max() / weight,
        "moment_before": lacking[:, 3:].max() / (0.2 * weight),
        "moment_after": left[:, 3:].max() / (0.2 * weight),
        "torque_rms": float(np.sqrt(np.mean(off**2))),
        "torque_worst": float(np.abs(off).max()),
        "drive_share": float(torque_share(needed[:, 6:], available).max()),
        **standing_feet(robot, second, instants, at),
    }


def beyond_stops(robot: Robot, joints: np.ndarray) -> float:
    """Largest way beyond a stop, rad or m; negative inside."""
    low, high = robot.joint_stops
    return float(np.maximum(low - joints, joints - high).max())


def standing_feet(robot: Robot, plan: llsrbm.Plan, time: np.ndarray, at: Any) -> dict[str, float]:
    """Largest distance, m, and speed, m/s, of feet that stand."""
    model, data = robot.model, robot.model.createData()
    knot = np.searchsorted(plan.time, time + 1e-9, side="right") - 1
    drift = slip = 0.0
    for k, q, v in zip(knot, at.q, at.v, strict=True):
        pin.forwardKinematics(model, data, q, v)
        pin.updateFramePlacements(model, data)
        for leg in np.flatnonzero(plan.contact[k]):
            frame = robot.legs[leg].foot_frame_id
            off = data.oMf[frame].translation - [0, 0, robot.foot_lift]
            off -= plan.foot_position[k, leg]
            speed = pin.getFrameVelocity(model, data, frame, pin.LOCAL_WORLD_ALIGNED).linear
            drift = max(drift, float(np.linalg.norm(off)))
            slip = max(slip, float(np.linalg.norm(speed)))
    return {"drift": drift, "slip": slip}


def table(results: list[dict[str, Any]]) -> Iterator[str]:
    """A row a robot and type."""
    yield (
        "robot     type           plans refined  iterations     first  second  times (p95)   "
        "stop [mrad]    base    moment   torque RMS worst  drive  drift  slip"
    )
    yield "                         hold  strict, before  processor (p95)  what does not hold"
    for robot, kind in dict.fromkeys((r["robot"], r["type"]) for r in results):
        rows = [r for r in results if (r["robot"], r["type"]) == (robot, kind) and r["planned"]]
        good = [r for r in rows if r["refined"]]
        head = f"{robot:9} {kind:14} {len(rows):5} {len(good):7}"
        if not good:
            yield head
            continue
        of = {name: np.array([r[name] for r in good]) for name in good[0] if name not in _TEXTS}
        times, it = of["second_s"] / of["first_s"], of["iterations"]
        yield (
            f"{head}  {np.median(it):3.0f} ({it.min():2.0f}-{it.max():3.0f}) "
            f"{np.median(of['first_s']):7.3f} {np.median(of['second_s']):7.3f} "
            f"{np.median(times):5.2f} ({np.percentile(times, 95):5.2f}) "
            f"{1e3 * of['stop_before'].max():6.0f} {1e3 * of['stop_after'].max():6.1f} "
            f"{of['force_after'].max():6.0e} "
            f"{of['moment_before'].max():6.2f} {of['moment_after'].max():6.0e} "
            f"{100 * np.median(of['torque_rms']):5.2f} ({100 * of['torque_rms'].max():4.2f}) "
            f"{100 * of['torque_worst'].max():5.1f} {of['drive_share'].max():5.2f} "
            f"{1e3 * of['drift'].max():5.1f} {of['slip'].max():5.2f}"
        )
        shares = of["processor"]
        broken = Counter(name for each in good for name, _ in each["broken"])
        yield (
            f"{'':24} {of['holds'].sum():4.0f} {of['strict'].sum():7.0f} "
            f"{sum(r['strict_before'] for r in rows):7} "
            f"{np.median(shares):10.2f} ({np.percentile(shares, 95):5.2f})  {dict(broken)}"
        )


_TEXTS = ("robot", "kind", "type", "seed", "planned", "refined", "compiled", "broken", *COMPONENTS)


def main(
    robots: str = "go2,anymal,slider,g1",
    types: Annotated[str, typer.Option(help="Jump types.")] = "together",
    count: Annotated[int, typer.Option("--requests", help="A robot and type.")] = 40,
    seed: Annotated[int, typer.Option(help="Draws requests.")] = 7200,
    share: Annotated[float, typer.Option(help="Share of the displacements.")] = 1.0,
    compiled: Annotated[bool, typer.Option(help="Wait for the compiler first.")] = False,
    out: Annotated[Path | None, typer.Option(help="All results, JSON lines.")] = None,
) -> None:
    """Print a line a request that is not refined, then the table."""
    results: list[dict[str, Any]] = []
    for robot in robots.split(","):
        for kind in types.split(","):
            for request in requests(robot, count, seed):
                result = one(request, kind, share, settle=compiled) | {"type": kind}
                results.append(result)
                if not result.get("refined", True):
                    print("not refined:", result, flush=True)
    print("\n".join(table(results)))
    if out is not None:
        write_lines(out, results)


if __name__ == "__main__":
    typer.run(main)
