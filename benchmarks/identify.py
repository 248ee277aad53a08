"""Hidden drives of hung robots, identified from logs of the excitation.

    python -m benchmarks.identify --robots go2,anymal,g1 --draws 20

Armature +- 30 %, friction and damping 0.5 to 2 times the robot file's, each joint its own; a delay
of 0 to 4 ms; readings with the noise of `llsrbm.simulation.readings`. Torques are commanded from
the readings and change within the simulator's steps. Errors are the worst joint's.
"""

import argparse
import time
from dataclasses import dataclass, replace

import mujoco
import numpy as np

from llsrbm.control.readings import Readings
from llsrbm.identification import Log, identify
from llsrbm.identification.excitation import Excitation
from llsrbm.mechanics import GRAVITY
from llsrbm.motion.rollout import Disturbance
from llsrbm.robots import load_robot
from llsrbm.robots.drives.table import JointDrives
from llsrbm.simulation.readings import ENCODER_STEP, JOINT_ZERO, SPEED_NOISE
from llsrbm.simulation.scene import build_scene, hung_posture
from llsrbm.simulation.world import FLAT, STEP

GOALS = {"armature": 0.05, "friction": 0.1, "damping": 0.1}
LATEST = 0.004  # s


@dataclass(frozen=True)
class Hidden:
    """A robot whose drives are others than its file's, and their delay, s."""

    robot: object
    delay: float


def hidden(robot, seed):
    rng, joints = np.random.default_rng([seed, 7]), len(robot.joint_names)
    drawn = zip(
        robot.joint_names,
        robot.armature * rng.uniform(0.7, 1.3, joints),
        robot.friction * 2.0 ** rng.uniform(-1, 1, joints),
        robot.damping * 2.0 ** rng.uniform(-1, 1, joints),
        strict=True,
    )
    own = {name: dict(zip(GOALS, map(float, numbers), strict=True)) for name, *numbers in drawn}
    file = robot.file.model_copy(update={"drives": JointDrives(joints=own)})
    return Hidden(replace(robot, file=file), float(rng.uniform(0.0, LATEST)))


def recorded(drives, seconds, rate, seed, noise=1.0):
    """The log of an excitation, hung, commands at `rate`, Hz."""
    robot, period, rng = drives.robot, 1 / rate, np.random.default_rng([seed, 8])
    scene = build_scene(robot, FLAT, Disturbance(), STEP, hung=True)
    data, steps = mujoco.MjData(scene.model), round(period / STEP)
    nominal = load_robot(robot.name)
    excitation = Excitation(nominal, seconds)
    times = period * np.arange(round(seconds * rate))
    data.qpos[scene.q_order] = hung_posture(robot)
    joint, moves = scene.q_order[7:], scene.v_order[6:]
    data.qpos[joint] = excitation.first.joints
    q, dq, tau = np.zeros((3, len(times), len(joint)))
    at_rest = np.array([1.0, 0, 0, 0]), np.zeros(3), np.array([0, 0, GRAVITY])
    zero = noise * JOINT_ZERO * rng.standard_normal(len(joint))
    # Of a command, steps see the share of their time that it holds.
    late = drives.delay / STEP
    whole, part = int(late), late - int(late)
    sent = [excitation.first.torque] * (whole + 2)
    for k in range(len(times)):
        q[k] = ENCODER_STEP * np.round((data.qpos[joint] + zero) / ENCODER_STEP)
        dq[k] = data.qvel[moves] + noise * SPEED_NOISE * rng.standard_normal(len(joint))
        readings = Readings(times[k], *at_rest, q[k], dq[k], tau[k], None)
        tau[k] = excitation.command(times[k], readings).tau
        for _ in range(steps):
            sent.append(tau[k])
            data.ctrl[:] = (1 - part) * sent[-1 - whole] + part * sent[-2 - whole]
            mujoco.mj_step(scene.model, data)
    return Log("hung", period, q, dq, tau, np.zeros_like(tau), np.ones(len(times), dtype=bool))


def errors(drives, found):
    """Largest share by which any joint's number is off, name -> share."""
    names = drives.robot.joint_names
    return {
        number: max(
            abs(getattr(drive, number) / getattr(drives.robot, number)[names.index(name)] - 1)
            for name, drive in found.joints.items()
        )
        for number in GOALS
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--robots", default="go2")
    parser.add_argument("--draws", type=int, default=20)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--rate", type=int, default=500)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    print(
        f"{'robot':<10}{'seed':>5}{'armature %':>12}{'friction %':>12}{'damping %':>12}"
        f"{'delay ms':>10}{'left out':>10}{'s':>7}"
    )
    for name in given.robots.split(","):
        robot, met = load_robot(name), 0
        for seed in range(given.seed, given.seed + given.draws):
            drives = hidden(robot, seed)
            log = recorded(drives, given.seconds, given.rate, seed)
            start = time.monotonic()
            found = identify(robot, log)
            took, off = time.monotonic() - start, errors(drives, found)
            late = found.delay - drives.delay
            good = all(off[each] < GOALS[each] for each in GOALS) and abs(late) < 3e-4
            met += good and not found.undetermined
            shown = "".join(f"{100 * off[each]:12.2f}" for each in GOALS)
            print(
                f"{name:<10}{seed:5d}{shown}{1e3 * late:+10.3f}{len(found.undetermined):10d}"
                f"{took:7.1f}",
                flush=True,
            )
        print(
            f"{name}: armature within 5 %, friction and damping within 10 %, delay within 0.3 ms "
            f"in {met} of {given.draws}"
        )


if __name__ == "__main__":
    main()
