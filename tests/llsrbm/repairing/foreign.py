"""Motions of feet in closed form, whose contacts are known."""

from dataclasses import replace
from functools import cache

import numpy as np

from llsrbm.body.postures import solve_postures
from llsrbm.mechanics import quaternion_product, quaternions_about_z, turns_about_z
from llsrbm.motion.whole_body import (
    WholeBodyMotion,
    motion_of_states,
    velocities,
    whole_body_motion,
)
from llsrbm.repairing.part import Part, parts
from llsrbm.repairing.phases import contact_phases
from llsrbm.robots import load_robot
from tests.llsrbm.player.stages import stored_plan

GO2 = load_robot("go2")


@cache
def jump(fps: float = 50.0) -> WholeBodyMotion:
    """Go2's quarter turn that comes with the project, as others would have it: states alone."""
    motion = whole_body_motion(stored_plan(), fps)
    return of_states(motion.time, motion.qpos)


def jumps(motion: WholeBodyMotion) -> list[Part]:
    """Those that are found in a motion."""
    return parts(motion, contact_phases(motion))


def of_states(time: np.ndarray, qpos: np.ndarray) -> WholeBodyMotion:
    return motion_of_states(GO2, "somebody's", time, qpos, velocities(time, qpos))


def stepping(
    lift, land, *, fps=50.0, until=2.0, rise=0.0, ground=0.0, noise=0.0
) -> WholeBodyMotion:
    """Feet that leave at `lift` and land at `land`, s (4,), 0.3 m ahead, on parabolas; and a CoM
    that falls freely from when the last one has left until the first one lands.

    `rise`: m that they land higher; `ground`: m of where they stand; `noise`: m.
    """
    time = np.arange(0.0, until + 1e-9, 1 / fps)
    place = np.tile(GO2.feet, (len(time), 1, 1))
    for foot, (start, end) in enumerate(zip(lift, land, strict=True)):
        share = np.clip((time - start) / (end - start), 0.0, 1.0)
        place[:, foot, 0] += 0.3 * share
        place[:, foot, 2] += 0.6 * share * (1 - share) + rise * share
    place[..., 2] += ground
    place += noise * np.random.default_rng(1).normal(size=place.shape)
    com = np.column_stack([0 * time, 0 * time, _height(time, max(lift), min(land), rise)])
    return replace(jump(), time=time, foot_position=place, com=com)


def _height(time, start, end, rise):
    """m: pushed off evenly for 0.3 s, in free fall, braked evenly for 0.3 s."""
    g, push, flight = 9.81, 0.3, end - start
    up = rise / flight + g * flight / 2
    down = up - g * flight
    speed = np.interp(time, [start - push, start, end, end + push], [0.0, up, down, 0.0])
    return 0.3 + np.concatenate([[0.0], np.cumsum(np.diff(time) * (speed[1:] + speed[:-1]) / 2)])


def twice(still: float, fps: float = 50.0) -> WholeBodyMotion:
    """The jump, `still` s of standing, and the jump again from where it ended."""
    first = jump(fps).qpos
    waits = np.repeat(first[-1:], round(still * fps), axis=0)
    qpos = np.concatenate([first, waits, moved_on(first)[1:]])
    return of_states(np.arange(len(qpos)) / fps, qpos)


def moved_on(qpos: np.ndarray) -> np.ndarray:
    """The states of the jump, from where it ended."""
    jump, again = stored_plan().jump, qpos.copy()
    shift = [jump.forward, jump.lateral, jump.height]
    again[:, :3] = again[:, :3] @ turns_about_z(jump.twist).T + shift
    turn = np.broadcast_to(quaternions_about_z(jump.twist), (len(again), 4))
    again[:, 3:7] = quaternion_product(turn, again[:, 3:7])
    return again


@cache
def clip(fps: float = 50.0) -> WholeBodyMotion:
    """Two of these jumps whose joints are a little off in each frame, somewhere in the world.

    The robot stands and crouches before, between and after them.
    """
    one = jump(fps).qpos
    off = np.random.default_rng(7).normal(scale=0.008, size=(2, len(one), 12))
    rough = [np.hstack([one[:, :7], one[:, 7:] + each]) for each in off]
    again = moved_on(one)
    rows = [
        *(_crouching(one[0], fps), rough[0], _crouching(one[-1], fps)),
        *(moved_on(rough[1]), _crouching(again[-1], fps)),
    ]
    qpos = np.concatenate(rows)
    qpos[:, :3] = qpos[:, :3] @ turns_about_z(2.0).T + [3.0, -1.0, -0.02]
    turn = np.broadcast_to(quaternions_about_z(2.0), (len(qpos), 4))
    qpos[:, 3:7] = quaternion_product(turn, qpos[:, 3:7])
    return replace(of_states(np.arange(len(qpos)) / fps, qpos), fps=fps)


def _crouching(pose: np.ndarray, fps: float) -> np.ndarray:
    """A posture at rest for a second, then 4 cm lower and back within another, and at rest."""
    still = np.repeat(pose[None], round(fps), axis=0)
    lower = 0.02 * (1 - np.cos(2 * np.pi * np.arange(1, round(fps)) / round(fps)))
    com = of_states(np.arange(2.0), still[:2]).com[0] - lower[:, None] * [0.0, 0.0, 1.0]
    quat, near = (np.repeat(values[None], len(com), axis=0) for values in (pose[3:7], pose[7:]))
    feet = np.repeat(of_states(np.arange(2.0), still[:2]).foot_position[:1], len(com), axis=0)
    found = solve_postures(GO2, com, quat, feet, near=near)
    low = np.hstack([found.base_position, quat, found.joint_position])
    return np.concatenate([still, low, still])
