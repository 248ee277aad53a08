"""How closely disturbed simulations follow their plans, and whether they keep stops and speeds.

    python -m benchmarks.following --robots anymal,go2,slider --requests 60 --seed 7100 --plans P

Requests and disturbances are those of `benchmarks.range` for the seed, one simulation a plan. Plans
are kept in the folder P: another version that is given the same folder follows the same plans, and
one that is run `--against` the file of results that another wrote prints both. `--draft` follows
those of the first stage, `--delay-unknown` with a controller that does not find out how
late its drives are.
The controller was tuned on seeds below 500.

Columns, over all plans: simulations that stand, strict ones; share with a yaw within 5 deg at the
first contact; those beyond a joint's stop by more than 0.1 % of its range and the largest such
share (of the plans in brackets); those beyond a joint's largest speed, and the largest share of it;
medians of the RMS errors until touchdown of base, joints (take-off, flight) and torque (take-off,
share of the limit, against the plan's straight between the middles of its intervals); medians of
the CoM's velocity's and the angular momentum's errors just after lift-off, of delayed simulations
alone; the controller's tick.
"""

import json
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

import llsrbm
from benchmarks.counting import write_lines
from benchmarks.range import COMPONENTS, requests
from llsrbm.control import delay
from llsrbm.motion.sampling import sampled
from llsrbm.planning.answer.planner import planner_for
from llsrbm.planning.whole_body.refine import refined
from llsrbm.robots import load_robot

_TOUCHED = 1e-3  # of a joint's range: a stop is pressed, not passed
_YAW = 5.0  # deg
_AFTER = 0.02  # s after the planned lift-off, when no foot pushes any more


def plan_of(request: dict[str, Any], folder: Path) -> llsrbm.Plan | None:
    """The plan of a request, from the folder if it is there; None: there is none."""
    path = folder / f"{request['robot']}-{request['seed']}.npz"
    missing = path.with_suffix(".none")
    if missing.exists():
        return None
    if not path.exists():
        motion = {name: request[name] for name in COMPONENTS if name in request}
        jump = llsrbm.Jump(robot=request["robot"], **motion)
        try:
            planner_for(jump.robot, jump.model).plan(jump).save(path)
        except llsrbm.NotConverged:
            missing.touch()
            return None
    plan = llsrbm.load(path)
    assert isinstance(plan, llsrbm.Plan)
    return plan


def follow(plan: llsrbm.Plan, seed: int) -> dict[str, Any]:
    """Figures of one simulation."""
    rollout = llsrbm.simulate(plan, seed=seed)
    robot = load_robot(plan.jump.robot)
    planned = [plan.joint_names.index(name) for name in rollout.joint_names]
    own = [robot.joint_names.index(name) for name in rollout.joint_names]
    lower, upper = robot.joint_stops[:, own]
    beyond = {
        name: float((np.maximum(lower - q, q - upper) / (upper - lower)).max())
        for name, q in (
            ("stop", rollout.joint_position),
            ("planned_stop", plan.joint_position[:, planned]),
        )
    }
    outcome = rollout.outcome
    end = min(outcome.touchdown_true_s or np.inf, plan.touchdown)
    before = rollout.time < end
    rising = rollout.time < plan.lift_off
    flying = before & ~rising
    wanted = sampled(plan, rollout.time[before], ("base_position", "joint_position"))
    joint = np.full_like(rollout.joint_position, np.nan)
    joint[before] = rollout.joint_position[before] - wanted["joint_position"][:, planned]
    yaw = outcome.yaw_error_at_touchdown
    velocity, momentum = lift_off_errors(plan, rollout)
    return {
        "delayed": rollout.disturbance.torque_delay_ticks > 0,
        "lift_off_velocity": velocity,
        "lift_off_momentum": momentum,
        "status": outcome.status,
        "strict": outcome.strict,
        "yaw_deg": 180.0 if yaw is None else float(np.degrees(yaw)),
        "lift_off_yaw_deg": float(np.degrees(outcome.yaw_error_at_lift_off or 0.0)),
        **beyond,
        "speed": outcome.peak_speed_ratio,
        "base_mm": 1e3 * rms(rollout.base_position[before] - wanted["base_position"], axis=1),
        "joint_rising": rms(joint[rising]),
        "joint_flying": rms(joint[flying]) if flying.any() else 0.0,
        "torque": torque_error(plan, rollout, planned, own),
        "unsolved": outcome.unsolved_ticks,
        "median_s": outcome.tick_median_s,
        "p99_s": outcome.tick_p99_s,
    }


def lift_off_errors(plan: Any, rollout: Any) -> tuple[float, float]:
    """Sizes of the errors of velocity, m/s, and angular momentum, kg m2/s, just after lift-off."""
    k = int(np.searchsorted(rollout.time, plan.lift_off + _AFTER))
    wanted = sampled(plan, rollout.time[k : k + 1], ("com_velocity", "angular_momentum"))
    span = rollout.time[k + 1] - rollout.time[k - 1]
    velocity = (rollout.com[k + 1] - rollout.com[k - 1]) / span - wanted["com_velocity"][0]
    momentum = rollout.angular_momentum[k] - wanted["angular_momentum"][0]
    return float(np.linalg.norm(velocity)), float(np.linalg.norm(momentum))


def torque_error(plan: Any, rollout: Any, planned: list[int], own: list[int]) -> float:
    """RMS over the take-off, of the joints' limits; a tick is the flight's when it is flown so."""
    rising = rollout.phase == 0
    first = plan.phase[:-1] == 0
    middle = ((plan.time[1:] + plan.time[:-1]) / 2)[first]
    limit = load_robot(plan.jump.robot).torque_limit[own]
    torque = plan.joint_torque[:-1][first][:, planned]
    wanted = np.stack([np.interp(rollout.time[rising], middle, one) for one in torque.T], axis=1)
    return rms((rollout.torque[rising] - wanted) / limit)


def rms(error: np.ndarray, axis: int | None = None) -> float:
    """Root of the mean square; of vectors along `axis`, of their lengths."""
    square = error**2 if axis is None else (error**2).sum(axis=axis)
    return float(np.sqrt(np.mean(square)))


def row(name: str, results: list[dict[str, Any]]) -> str:
    """A line of the table."""

    def of(key: str) -> np.ndarray:
        return np.array([result[key] for result in results], dtype=float)

    stop, planned, speed = of("stop"), of("planned_stop"), of("speed")
    late = of("delayed") > 0
    stands = sum(result["status"] == "landed" for result in results)
    return (
        f"| {name} | {len(results)} | {stands} | {of('strict').sum():.0f} "
        f"| {100 * np.mean(abs(of('yaw_deg')) <= _YAW):.0f} % "
        f"| {np.sum(stop > _TOUCHED)} ({np.sum(planned > _TOUCHED)}), "
        f"{100 * max(stop.max(), 0):.1f} % ({100 * max(planned.max(), 0):.1f} %) "
        f"| {np.sum(speed > 1)}, {speed.max():.2f} | {np.median(of('base_mm')):.1f} mm "
        f"| {np.median(of('joint_rising')):.3f}, {np.median(of('joint_flying')):.3f} "
        f"| {100 * np.median(of('torque')):.1f} % "
        f"| {1e3 * np.median(of('lift_off_velocity')[late]):.1f} mm/s, "
        f"{1e3 * np.median(of('lift_off_momentum')[late]):.1f} g m2/s ({late.sum()}) "
        f"| {np.sum(of('unsolved') > 0)} "
        f"| {1e6 * np.median(of('median_s')):.0f}, {1e6 * np.median(of('p99_s')):.0f} us |"
    )


def main(
    plans: Annotated[Path, typer.Option(help="Folder of plans.")],
    robots: str = "anymal,go2,slider",
    count: Annotated[int, typer.Option("--requests", help="A robot.")] = 60,
    seed: Annotated[int, typer.Option(help="Draws requests and disturbances.")] = 7100,
    out: Annotated[Path | None, typer.Option(help="All results, JSON lines.")] = None,
    against: Annotated[Path | None, typer.Option(help="Results to print as well.")] = None,
    draft: Annotated[bool, typer.Option("--draft", help="The first stage alone.")] = False,
    delay_unknown: Annotated[
        bool,
        typer.Option("--delay-unknown", help="The controller does not know the drives' delay."),
    ] = False,
) -> None:
    """Print a row a robot."""
    if delay_unknown:
        delay.MOST = 0
    plans.mkdir(parents=True, exist_ok=True)
    print(
        "| robot | plans | stand | strict | yaw < 5 deg | beyond a stop (planned) | too fast "
        "| base | joints | torque | lift-off | unsolved | tick, p99 |"
    )
    print("|---" * 13 + "|")
    known = [json.loads(line) for line in against.read_text().splitlines()] if against else []
    every = []
    for robot in robots.split(","):
        results = []
        for request in requests(robot, count, seed):
            plan = plan_of(request, plans)
            if plan is not None:
                plan = plan if draft else refined(plan)
                results.append({**request, **follow(plan, request["seed"])})
        print(row(robot, results), flush=True)
        seeds = {result["seed"] for result in results}
        other = [one for one in known if one["robot"] == robot and one["seed"] in seeds]
        if other:
            print(row(f"{robot}, {against.stem}" if against else robot, other), flush=True)
        every += results
    if out is not None:
        write_lines(out, every)


if __name__ == "__main__":
    typer.run(main)
