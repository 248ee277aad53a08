"""Plans played without this project's controller: as torques alone, by joint gains, by feedback.

    python -m benchmarks.played --robots anymal,go2,slider,g1 --requests 20 --seed 7600

Requests are those of `benchmarks.range` on level ground, their plans refined. Each is played in
MuJoCo at 1 kHz with everything disturbed but what is measured, from the planned torques and states:
nothing knows which feet touch. Joint gains are the same for all joints, per torque limit. Columns:
plays that end on their feet within 50 mm and 5 deg of the plan, half a second after its end; median
and worst of where the base ends, of those that do.
"""

from typing import Annotated

import numpy as np
import pinocchio as pin
import typer
from numpy.typing import NDArray

import llsrbm
from benchmarks.range import COMPONENTS, requests
from llsrbm.motion.rollout import Disturbance
from llsrbm.motion.surroundings import surroundings
from llsrbm.motion.whole_body import motion_at, pinocchio_states
from llsrbm.planning.whole_body.feedback import in_order
from llsrbm.request.scenario import Scenario
from llsrbm.robots import load_robot
from llsrbm.simulation.world import Diverged, World

Array = NDArray[np.float64]

TICK = 1e-3  # s
AFTER = 0.5  # s that it is played on after the plan's end
STIFFNESS, DAMPING = 1.7, 0.02  # of joint gains: shares of the torque limit per rad and per rad/s
WITHIN, LEVEL = 0.05, np.radians(5.0)
WAYS = ("torques", "joint gains", "feedback")


def play(plan: llsrbm.Plan, way: str, seed: int, push: Array | None = None) -> tuple[float, float]:
    """Distance (m) and angle (rad) of the base from where the plan ends; `push`: N s at 0.1 s."""
    robot = load_robot(plan.jump.robot)
    rng = np.random.default_rng(seed)
    disturbance = Disturbance(
        trunk_mass_factor=rng.uniform(0.95, 1.05),
        friction=rng.uniform(0.6, 0.9),
        contact_time=rng.uniform(0.004, 0.01),
        torque_delay_ticks=int(rng.integers(0, 3)),
    )
    world = World(robot, surroundings(robot, plan, Scenario()), disturbance, TICK)
    time = np.arange(0.0, plan.duration, TICK)
    motion = motion_at(plan, time)
    assert motion.joint_torque is not None
    q, v = pinocchio_states(motion.qpos, motion.qvel)
    knot = np.searchsorted(plan.time, time + 1e-9, side="right") - 1
    assert plan.feedback_gain is not None
    gain = in_order(plan.feedback_gain, plan.joint_names, robot.joint_names)
    limit, joints = robot.torque_limit, slice(6, None)
    world.reset(q[0], v[0])
    off = np.zeros(robot.model.nv)
    for tick in range(len(time) + round(AFTER / TICK)):
        at = min(tick, len(time) - 1)
        now, speed = world.state()
        off, fast = pin.difference(robot.model, q[at], now), speed - v[at]
        torque = motion.joint_torque[at]
        if way == "joint gains":
            torque = torque - limit * (STIFFNESS * off[joints] + DAMPING * fast[joints])
        elif way == "feedback":
            over = tick >= len(time)
            torque = torque - gain[-1 if over else knot[at]] @ np.concatenate([off, fast])
        if push is not None and tick == round(0.1 / TICK):
            world.push(push / TICK, np.zeros(3))
        try:
            world.advance(torque)
        except Diverged:
            return np.inf, np.pi
    return float(np.linalg.norm(off[:3])), float(np.linalg.norm(off[3:6]))


def main(
    robots: str = "anymal,go2,slider,g1",
    count: Annotated[int, typer.Option("--requests", help="A robot.")] = 20,
    seed: Annotated[int, typer.Option(help="Draws requests and disturbances.")] = 7600,
) -> None:
    """Print a row a robot and way."""
    print("robot     way          plays  stand  median    worst")
    for robot in robots.split(","):
        ends: dict[str, list[tuple[float, float]]] = {way: [] for way in WAYS}
        for request in requests(robot, count, seed):
            level = {n: request[n] for n in COMPONENTS if n in request and n != "height"}
            jump = llsrbm.Jump(robot=robot, **level)
            try:
                plan = llsrbm.plan(jump, patient=False, explains=False)
            except llsrbm.NotConverged:
                continue
            if plan.refined:
                plan = llsrbm.with_feedback(plan)
                for way in WAYS:
                    ends[way].append(play(plan, way, request["seed"]))
        for way, found in ends.items():
            good = [far for far, turned in found if far < WITHIN and turned < LEVEL]
            where = f"{1e3 * np.median(good):6.1f} {1e3 * max(good):8.1f} mm" if good else ""
            print(f"{robot:9} {way:12} {len(found):5} {len(good):6} {where}", flush=True)


if __name__ == "__main__":
    typer.run(main)
