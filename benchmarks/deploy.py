"""Plans played through a simulated robot's wire, in lock-step, and judged by the true motion.

    python -m benchmarks.deploy --plans P --seeds 9300:9320 --jobs 2

Between player and motors are the delay (2 ± 1 ms), encoders' steps and zeros, an inertial unit with
noise and biases, torque estimates that err, a battery that sags; the closed loop stands behind its
own estimator. Nothing here depends on how fast the machine is. Plans, as
`llsrbm plan` makes them, are kept in the folder P. The player was tuned on seeds 9200 to 9249.
`--disturbed`: each seed also draws the trunk's mass, friction, the ground's softness and now and
then 2 ms more of delay, as `llsrbm simulate --seed` does.

Columns: of all seeds strict ones (`llsrbm.simulation.verdict`, of the true motion), those that
stand, those that the player stopped by itself; medians of the feet's error and of the yaw's at the
end; causes of those that are not strict.
"""

import math
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

import llsrbm
from benchmarks.counting import seeds_of, write_lines
from llsrbm.motion.outcome import FEET_WITHIN, FINAL_TILT, PEAK_TILT, SECOND_FLIGHT
from llsrbm.motion.rollout import Disturbance
from llsrbm.player.played import play
from llsrbm.robots import load_robot
from llsrbm.simulation.disturbance import draw_disturbance

JUMPS = {
    "go2-twist90": {"robot": "go2", "twist": math.pi / 2},
    "go2-forward30": {"robot": "go2", "forward": 0.3},
    "go2-forward50": {"robot": "go2", "forward": 0.5},
    "anymal-twist90": {"robot": "anymal", "twist": math.pi / 2},
    "anymal-forward50": {"robot": "anymal", "forward": 0.5},
    "g1-twist90": {"robot": "g1", "twist": math.pi / 2},
}


def plan_of(name: str, folder: Path) -> llsrbm.Plan:
    """The refined plan of a jump, from the folder if it is there."""
    path = folder / f"{name}.npz"
    if not path.exists():
        llsrbm.plan(llsrbm.Jump(**JUMPS[name])).save(path)
    plan = llsrbm.load(path)
    assert isinstance(plan, llsrbm.Plan)
    return plan


def figures(name: str, folder: Path, tier: str, disturbed: bool, seed: int) -> dict[str, Any]:
    """Figures of one play."""
    plan = plan_of(name, folder)
    robot = load_robot(plan.jump.robot)
    drawn = draw_disturbance(robot, llsrbm.Scenario(seed=seed)) if disturbed else Disturbance()
    played = play(plan, robot, tier, seed, disturbance=drawn)
    row: dict[str, Any] = {"jump": name, "tier": tier, "seed": seed, "line": played.ended.line}
    if played.rollout is None:
        return {**row, "status": "fell", "strict": False, "reason": "stopped before its jump"}
    outcome = played.rollout.outcome
    kept = (
        *("status", "strict", "reason", "final_yaw_error", "foot_error", "final_tilt", "peak_tilt"),
        *("second_flight_s", "unsolved_ticks", "touched", "touchdown_planned_s"),
        *("touchdown_true_s", "yaw_error_at_touchdown", "foot_error_at_touchdown"),
    )
    values = {key: getattr(outcome, key) for key in kept}
    return {**row, **values, "stopped": played.ended.reason}


def causes(row: dict[str, Any]) -> list[str]:
    """Why a play is not strict."""
    if row["strict"]:
        return []
    if row["status"] == "fell":
        return [row["reason"].split(":")[0][:40]]
    limits = {
        "foot_error": FEET_WITHIN,
        "final_tilt": FINAL_TILT,
        "peak_tilt": PEAK_TILT,
        "second_flight_s": SECOND_FLIGHT,
        "unsolved_ticks": 1,
    }
    found = [name for name, limit in limits.items() if row[name] >= limit]
    return [*found, "touched"] if row["touched"] else found


def line(name: str, tier: str, rows: list[dict[str, Any]]) -> str:
    """Line of the table."""
    standing = [row for row in rows if row["status"] == "landed"]
    strict = sum(row["strict"] for row in rows)
    stopped = sum(bool(row.get("stopped")) for row in rows)
    feet = 1e3 * float(np.median([row["foot_error"] for row in standing] or [math.nan]))
    yaw = math.degrees(np.median([abs(row["final_yaw_error"]) for row in standing] or [math.nan]))
    why = Counter(cause for row in rows for cause in causes(row))
    return (
        f"{name:16} {tier:12} {strict:3} strict {len(standing):3} stand {stopped:3} stopped of "
        f"{len(rows)}  feet {feet:4.0f} mm  yaw {yaw:4.1f} deg  {dict(why) or ''}"
    )


def main(
    plans: Annotated[Path, typer.Option(help="Folder of plans.")],
    seeds: str = "9300:9320",
    jumps: str = "go2-twist90,go2-forward30,go2-forward50",
    tiers: str = "closed-loop,table",
    disturbed: bool = False,
    jobs: int = 1,
    out: Path | None = None,
) -> None:
    plans.mkdir(parents=True, exist_ok=True)
    results = []
    for name in jumps.split(","):
        plan_of(name, plans)
        for tier in tiers.split(","):
            of_seed = partial(figures, name, plans, tier, disturbed)
            with ProcessPoolExecutor(jobs) as pool:
                rows = list(pool.map(of_seed, seeds_of(seeds)))
            print(line(name, tier, rows), flush=True)
            results += rows
    if out is not None:
        write_lines(out, results)


if __name__ == "__main__":
    typer.run(main)
