"""Jumps of real robots: drafts of their examples, each simulated once a run.

They are kept as files: `llsrbm.plan(example(robot), draft=True)` of `app.tab.start.initial_plan`.
"""

import csv
from dataclasses import replace
from functools import cache
from pathlib import Path

import mujoco
import numpy as np

import llsrbm
from llsrbm.installed import assets_directory
from llsrbm.motion.plan import Plan, load_plan
from llsrbm.motion.rollout import Disturbance, Rollout
from llsrbm.motion.surroundings import Surroundings
from llsrbm.request.schedule import Phase, Schedule
from llsrbm.robots import load_robot
from llsrbm.simulation.scene import build_scene

ROBOTS = ("anymal", "slider")


@cache
def planned(robot: str) -> Plan:
    """A draft of the robot's example: a twist of 90 or 45 degrees, SLIDER's jump onto a box."""
    return load_plan(Path(__file__).with_name("drafts") / f"{robot}.npz")


@cache
def shipped(robot: str) -> Plan:
    """The certified plan of the robot's example."""
    return load_plan(assets_directory() / "plans" / f"{robot}.npz")


@cache
def simulated(robot: str) -> Rollout:
    return llsrbm.simulate(planned(robot))


@cache
def relabelled(robot: str) -> Plan:
    """A planned jump that claims to be another: its landing is called a rebound, a flight and a
    landing, in each of which one foot more, or less, is said to stand. Numbers are as they were."""
    plan = planned(robot)
    legs = plan.leg_names
    schedule = Schedule(
        legs,
        (
            Phase("take-off", legs, "takeoff"),
            Phase("flight", (), "flight"),
            Phase("first foot", legs[:1], (0.05, 1.0), place=1),
            Phase("rebound", legs, (0.05, 1.0), place=1),
            Phase("flight", (), "flight", place=1),
            Phase("landing", legs, "landing", place=2),
        ),
    )
    landing = np.flatnonzero(plan.phase == 2)
    phase = plan.phase.copy()
    phase[landing] = 2 + np.arange(len(landing)) * 4 // len(landing)
    return replace(plan, phase=phase, schedule=schedule)


def ticks(rollout: Rollout, fps: float) -> np.ndarray:
    """Indices of the rollout's own instants that are frames: no sampling lies between."""
    step = rollout.outcome.control_rate_hz / fps
    assert step == round(step)
    return np.arange(0, len(rollout.time), round(step))


def by_name(names, wanted, values):
    """Columns `wanted` of `values`, whose columns are `names`."""
    return values[:, [list(names).index(name) for name in wanted]]


@cache
def mujoco_model(robot: str) -> mujoco.MjModel:
    ground = Surroundings(ground=0.0, blocks=())
    return build_scene(load_robot(robot), ground, Disturbance(), 1e-3).model


def depth_first(robot: str) -> list[str]:
    """Joints as MuJoCo has them."""
    model = mujoco_model(robot)
    return [model.joint(i + 1).name for i in range(12)]


def replayed(robot, joints, qpos, qvel, bodies):
    """What MuJoCo makes of states whose joints are in the order `joints`.

    Returns:
        positions, quaternions, velocities of origins, of centres of mass, angular velocities;
        (K, B, ...), world.
    """
    model = mujoco_model(robot)
    data = mujoco.MjData(model)
    q_at = [model.joint(name).qposadr[0] for name in joints]
    v_at = [model.joint(name).dofadr[0] for name in joints]
    ids = [model.body(name).id for name in bodies]
    found = [[], [], [], [], []]
    twist = np.empty(6)
    for q, v in zip(qpos, qvel, strict=True):
        data.qpos[:7], data.qvel[:6] = q[:7], v[:6]
        data.qpos[q_at], data.qvel[v_at] = q[7:], v[6:]
        mujoco.mj_forward(model, data)
        origin, com, turning = [], [], []
        for body in ids:
            kind = mujoco.mjtObj.mjOBJ_XBODY
            mujoco.mj_objectVelocity(model, data, kind, body, twist, 0)
            turning.append(twist[:3].copy())
            origin.append(twist[3:].copy())
            # Along the inertia's axes but for this: the world's.
            mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_BODY, body, twist, 0)
            com.append(twist[3:].copy())
        for values, new in zip(
            found,
            (data.xpos[ids].copy(), data.xquat[ids].copy(), origin, com, turning),
            strict=True,
        ):
            values.append(new)
    return tuple(np.array(values) for values in found)


def same_attitude(a, b, atol):
    """Quaternions (..., 4), whatever their signs."""
    np.testing.assert_allclose(np.abs(np.sum(a * b, axis=-1)), 1.0, atol=atol)


def check_frames(robot, fps, position, quat, joints, names):
    """Frames hold the simulator's own states: base (m, w first) and joints in the order `names`."""
    rollout = simulated(robot)
    at = ticks(rollout, fps)
    qpos, here = rollout.qpos[at], slice(0, len(at))
    np.testing.assert_allclose(position[here], qpos[:, :3], atol=1e-6)
    same_attitude(quat[here], qpos[:, 3:7], atol=1e-6)
    wanted = by_name(rollout.joint_names, names, qpos[:, 7:])
    np.testing.assert_allclose(joints[here], wanted, atol=1e-6)


def read_table(path: Path) -> dict[str, np.ndarray]:
    """Columns of a CSV file by their names in its header."""
    with path.open(newline="") as file:
        header, *rows = csv.reader(file)
    return dict(zip(header, np.array(rows, dtype=np.float64).T, strict=True))
