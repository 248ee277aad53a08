"""Whole clips made foreign and repaired (`llsrbm repair --clip`): how they are joined.

    python -m benchmarks.repair_clips --robots go2,anymal,g1 --count 4 --seed 1 --noise 0.003

Each clip is two motions of the library, of jumps from both feet or all four, with standing, a
crouch and standing before, between and after them, at 50 frames/s. It is made foreign: played 0.9
to 1.2 times as long, lifted or sunk by up to 3 cm, somewhere else with another heading, every
joint of every frame off by a standard deviation of `--noise` rad. Clips follow from the seed alone.
A line a clip: how many jumps were repaired or stay as they are, the checks that are broken before
and after; at joins the largest step of a joint from frame to frame, as a share of what its speed
limit allows, and how far standing feet move, horizontally and vertically, in mm.
"""

from typing import Annotated, Any

import numpy as np
import typer

import llsrbm
from llsrbm.body.momentum import centroidal_states
from llsrbm.body.postures import solve_postures
from llsrbm.library import shipped
from llsrbm.mechanics import quaternion_product, quaternions_about_z, slerp, turns_about_z, yaw
from llsrbm.motion.whole_body import (
    WholeBodyMotion,
    motion_of_states,
    pinocchio_states,
    velocities,
    whole_body_motion,
)
from llsrbm.repairing.feet import feet_of
from llsrbm.repairing.result import ClipRepair
from llsrbm.robots.robot import Robot

FPS = 50.0
STRETCH, LIFT, AWAY, DEEP = (0.9, 1.2), 0.03, 3.0, 0.04  # m
KINDS = ("together", "pirouette")

app = typer.Typer()


def clip(robot: str, noise: float, rng: np.random.Generator) -> WholeBodyMotion:
    """Two motions of a robot, drawn from the library, made one foreign clip."""
    library, slower = shipped(), float(rng.uniform(*STRETCH))
    names = [card.name for kind in KINDS for card in library.found([robot, kind])]
    chosen = rng.choice(len(names), 2, replace=False)
    motions = [whole_body_motion(library.open(names[k]), FPS * slower) for k in chosen]
    mover = motions[0].robot
    first = motions[0].qpos
    second = _from(motions[1].qpos, first[-1])
    beside = ((first[0], first[0]), (first[-1], second[0]), (second[-1], second[-1]))
    stood = [_crouching(mover, *ends) for ends in beside]
    qpos = np.concatenate([stood[0], first, stood[1], second, stood[2]])
    turn = float(rng.uniform(-np.pi, np.pi))
    away = [*rng.uniform(-AWAY, AWAY, 2), rng.uniform(-LIFT, LIFT)]
    qpos[:, :3] = qpos[:, :3] @ turns_about_z(turn).T + away
    qpos[:, 3:7] = _turned(qpos[:, 3:7], turn)
    qpos[:, 7:] += rng.normal(scale=noise, size=qpos[:, 7:].shape)
    time = np.arange(len(qpos)) / FPS
    return motion_of_states(mover, "foreign", time, qpos, velocities(time, qpos), FPS)


def _turned(quat: np.ndarray, turn: float) -> np.ndarray:
    return quaternion_product(np.broadcast_to(quaternions_about_z(turn), quat.shape), quat)


def _from(qpos: np.ndarray, pose: np.ndarray) -> np.ndarray:
    """The states, turned about the vertical and shifted such that they begin where a pose is."""
    turn = float(yaw(pose[None, 3:7])[0] - yaw(qpos[:1, 3:7])[0])
    place = (qpos[:, :3] - qpos[0, :3]) @ turns_about_z(turn).T + pose[:3]
    return np.hstack([place, _turned(qpos[:, 3:7], turn), qpos[:, 7:]])


def _crouching(robot: Robot, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """At rest for 0.8 s, lower and up to another posture within a second, and at rest again.

    Feet that stand elsewhere in the other slide there meanwhile.
    """
    share = np.arange(1, round(FPS))[:, None] / round(FPS)
    ends = np.stack([start, end])
    q, v = pinocchio_states(ends, np.zeros((2, ends.shape[1] - 1)))
    com, feet = centroidal_states(robot.model, q, v)[0], feet_of(robot, ends)
    way = com[0] + share * (com[1] - com[0])
    way[:, 2] -= DEEP / 2 * (1 - np.cos(2 * np.pi * share[:, 0]))
    places = feet[0][0] + share[:, :, None] * (feet[0][1] - feet[0][0])
    soles = slerp(feet[1][:1], feet[1][1:], share)
    quat = slerp(start[None, 3:7], end[None, 3:7], share[:, 0])
    near = start[7:] + share * (end[7:] - start[7:])
    low = solve_postures(robot, way, quat, places, soles, near=near)
    crouch = np.hstack([low.base_position, quat, low.joint_position])
    before, after = (np.repeat(pose[None], round(0.8 * FPS), axis=0) for pose in (start, end))
    return np.concatenate([before, crouch, after])


def measured(given: WholeBodyMotion, found: ClipRepair) -> dict[str, Any]:
    """The figures that are printed of a clip."""
    result: dict[str, Any] = {
        "jumps": [jump.status for jump in found.jumps],
        "before": [check.name for check in found.before.broken],
        "after": None if found.after is None else [check.name for check in found.after.broken],
        "step": 0.0,
        "slid_mm": 0.0,
        "sunk_mm": 0.0,
    }
    if found.motion is None:
        return result
    limit = given.robot.model.velocityLimit[6:] / FPS
    for join in found.joins:
        first, last = round(join.start_s * FPS), round(join.end_s * FPS)
        own = slice(first, last + 1)
        steps = np.abs(np.diff(found.motion.joint_position[own], axis=0)) / limit
        feet, _ = feet_of(given.robot, found.motion.qpos[own])
        away = feet - feet[:1]
        flat = np.linalg.norm(away[..., :2], axis=-1).max()
        result["step"] = max(result["step"], float(steps.max()))
        result["slid_mm"] = max(result["slid_mm"], 1000 * float(flat))
        result["sunk_mm"] = max(result["sunk_mm"], 1000 * float(np.abs(away[..., 2]).max()))
    return result


@app.command()
def main(
    robots: str = "go2,anymal,g1",
    count: Annotated[int, typer.Option(help="Clips a robot.")] = 4,
    seed: int = 1,
    noise: Annotated[float, typer.Option(help="Standard deviation, rad.")] = 0.003,
) -> None:
    """Print a line a clip, then one of all."""
    results = []
    for robot in robots.split(","):
        for index in range(count):
            given = clip(robot, noise, np.random.default_rng([seed, index]))
            result = measured(given, llsrbm.repair_clip(given))
            results.append(result)
            print(f"{robot:7} {index:3} {result}", flush=True)
    jumps = [status for each in results for status in each["jumps"]]
    done = [each for each in results if each["after"] is not None]
    print(
        f"{len(results)} clips, {len(jumps)} jumps, {jumps.count('failed')} of them failed; "
        f"{sum(not each['after'] for each in done)} clips with no check broken, before "
        f"{sum(not each['before'] for each in results)}; at joins at most "
        f"{max(each['step'] for each in results):.2f} of a joint's speed, feet "
        f"{max(each['slid_mm'] for each in results):.1f} mm along the ground and "
        f"{max(each['sunk_mm'] for each in results):.1f} mm up or down"
    )


if __name__ == "__main__":
    app()
