"""Planners for the process under test; twist, or seed, says how they shall behave."""

import math
import os
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from app.workers.file_reading import open_file
from app.workers.opened_file import OpenedFile, States
from app.workers.worker import exported
from llsrbm import errors
from llsrbm.certificate import Certificate, Finding
from llsrbm.errors import InputError
from llsrbm.largest_jump import DIRECTIONS, Largest
from llsrbm.library import shipped
from llsrbm.motion.whole_body import motion_of_states
from llsrbm.repairing.phases import ContactPhase
from llsrbm.repairing.result import Moved, Repair
from llsrbm.request.jump import Jump
from llsrbm.request.schedule import together
from llsrbm.robots import load_robot
from tests.app.synthetic_plan import refined_plan, synthetic_plan
from tests.app.synthetic_replans import with_replans
from tests.llsrbm.synthetic_rollout import followed, synthetic_rollout

SLOW = math.radians(51)  # works one second (a search: a minute), asks whether to stop
STUBBORN = math.radians(52)  # works for a minute and never asks
CRASH = math.radians(53)  # the process dies
DEFECT = math.radians(54)  # an exception that is no llsrbm.Error
UNSOLVABLE = math.radians(55)  # NotConverged, and no nearest
REFUSED = math.radians(56)  # InputError
ITERATING = math.radians(57)  # works one second, telling every iteration, asks whether to stop
FARTHEST = math.radians(-150)  # NotConverged beyond, with this twist as the nearest

# Seeds of simulations:
SLOWLY = 51  # takes five seconds, asks whether to stop
STUBBORNLY = 52  # takes a minute and never asks
FALLING = 53  # the robot falls
IMPOSSIBLE = 54  # InputError
TRIPPING = 55  # the robot falls before it has left the ground

SLOW_PAD = 9.9  # s before and after, of an export that takes a minute and never asks


NO_FLIGHT = "No foot leaves the ground for a flight of all feet."
STOPS_MORE = "RH_KFE is at its limit of 30.1 rad/s at lift-off"

CERTIFICATE = Certificate(
    (
        Finding("joint_speed", 1.164, 30.1, "rad/s", "FL_calf_joint", 0.74, False, 1.01),
        Finding("slip", 0.0004, 0.01, "m", "RL", 0.3, True, 0.01),
        Finding("dynamics", None, None, "N", "", None, None, why="pushes act beside the contacts"),
    )
)

REPAIRED = Certificate(
    (
        Finding("joint_speed", 0.871, 30.1, "rad/s", "FL_calf_joint", 0.74, True, 1.01),
        Finding("slip", 0.0002, 0.01, "m", "RL", 0.3, True, 0.01),
        Finding("dynamics", 0.04, 1.0, "N", "moment", 0.6, True, 1.01),
    )
)


class SyntheticPlanner:
    """Quick and made up; tells a file, if there is one at PLANNED_LOG, what it planned."""

    most_memory = math.inf

    def prepare(self, robot, progress):
        progress(f"preparing {robot}")
        if robot == "nosuch":
            raise InputError('no robot "nosuch"')

    def plan(self, task, progress, cancelled):
        jump = task.jump
        progress("solving")
        if is_(jump, SLOW):
            work(1.0, cancelled)
        elif is_(jump, ITERATING):
            for i in range(100):
                progress("solving", iteration=i, residual=10.0**-i)
                work(0.01, cancelled)
        elif is_(jump, STUBBORN):
            time.sleep(60)
        elif is_(jump, CRASH):
            os._exit(9)
        elif is_(jump, DEFECT):
            raise ZeroDivisionError("a defect")
        elif is_(jump, UNSOLVABLE):
            raise errors.NotConverged(
                "no convergence: reach violated in flight by 0.02 m",
                synthetic_plan(jump, "not-converged"),
            )
        elif jump.twist < FARTHEST:
            nearest = replace(synthetic_plan(replace(jump, twist=FARTHEST)), tuning=task.tuning)
            raise errors.NotConverged(
                "no convergence: leg_drives violated",
                synthetic_plan(jump, "not-converged"),
                nearest=nearest,
                reason="RH_HAA needs 107 Nm at lift-off, it has 34",
            )
        elif is_(jump, REFUSED):
            raise InputError("twist: expected -1 to 1 rad, got more")
        if log := os.environ.get("PLANNED_LOG"):
            with Path(log).open("a") as file:
                file.write(f"{os.getpid()} {jump.model}\n")
        return replace(synthetic_plan(jump), tuning=task.tuning)

    def refine(self, task, progress, cancelled):
        progress("refining", iteration=3, residual=0.1)
        return refined_plan(task.plan)

    def largest(self, task, progress, cancelled):
        """70 cm, or degrees, of anything."""
        progress("0.65 m holds, trying 0.70 m")
        if is_(task.jump, SLOW):
            work(60.0, cancelled)
        direction = DIRECTIONS[task.towards]
        plan = refined_plan(synthetic_plan(direction.of(task.jump, 70)))
        return Largest(task.towards, direction.value(70), direction.unit, STOPS_MORE, plan)

    def simulate(self, task, progress, so_far, cancelled):
        seed = task.scenario.seed

        def percent(share):
            progress(f"simulating, {share:.0%}", share=share)

        percent(0.0)
        if seed == SLOWLY:
            for i in range(500):
                work(0.01, cancelled)
                percent(i / 500)
                if i % 20 == 0:
                    so_far(i / 500, *standing_motion(task.plan.jump.robot, i // 20 + 1))
        elif seed == STUBBORNLY:
            percent(0.01)
            time.sleep(60)
        elif seed == IMPOSSIBLE:
            raise InputError("board: expected 0 to 0.05 m, got more")
        percent(1.0)
        fell_at = {FALLING: 1.1, TRIPPING: 0.2}.get(seed)
        if task.plan.schedule == together(task.plan.leg_names):
            rollout = synthetic_rollout(task.plan, fell_at=fell_at, seed=seed)
        else:
            rollout = followed(task.plan)
        if task.scenario.replan:
            rollout = with_replans(rollout, task.plan)
        return replace(rollout, scenario=task.scenario)

    def open(self, task, progress):
        if task.name == "slow.zip":
            time.sleep(60)
        if task.name == "foreign.csv":
            return OpenedFile(task.name, turning_states(task.robot))
        return open_file(task.name, task.content, task.robot, task.fps)

    def open_motion(self, task, progress):
        return OpenedFile(task.name, shipped().open(task.name, check=False))

    def check(self, task, progress):
        progress("checking the motion at 1 kHz")
        return CERTIFICATE

    def repair(self, task, progress, cancelled):
        """Of a motion that ends where it begins there is none."""
        progress("the whole body's dynamics, near to the motion", iteration=3, residual=0.1)
        work(0.3, cancelled)
        return repair_of(task.motion)

    def export(self, task, progress):
        progress(f"writing {task.formats}")
        if task.options.get("pad") == SLOW_PAD:
            time.sleep(60)
        return exported(task)


class HeavyPlanner(SyntheticPlanner):
    """Each of its processes holds too much memory once it has planned."""

    most_memory = 0.0


def turning_states(robot, seconds=2.0, fps=50.0):
    """The robot in its default posture, turning and rising above the ground and back."""
    loaded = load_robot(robot)
    t = np.arange(round(seconds * fps) + 1) / fps
    share = np.clip((t - 0.5) / 0.5, 0, 1)
    qpos = np.tile(loaded.posture, (len(t), 1))
    qpos[:, 2] += 0.8 * share * (1 - share)
    qpos[:, 3:7] = Rotation.from_euler("z", (np.pi * share)[:, None]).as_quat(scalar_first=True)
    qvel = np.zeros((len(t), 6 + len(loaded.joint_names)))
    qvel[:, 2] = np.gradient(qpos[:, 2], t)
    qvel[:, 5] = np.gradient(np.pi * share, t)
    return States.of(motion_of_states(loaded, "unitree-csv", t, qpos, qvel, fps), robot)


def repair_of(states):
    """From 0.2 s on, where it stood elsewhere; of a motion that does not turn there is none."""
    legs = tuple(leg.name for leg in load_robot(states.robot).legs)
    phases = tuple(
        ContactPhase(name, feet, start, end)
        for name, feet, start, end in (
            ("take-off", legs, 0.2, 0.5),
            ("flight", (), 0.5, 1.0),
            ("landing", legs, 1.0, 1.6),
        )
    )
    if np.ptp(states.values["base_quat"][:, 3]) < 0.1:
        return Repair("failed", CERTIFICATE, why=NO_FLIGHT)
    plan = refined_plan(synthetic_plan(Jump(robot=states.robot, twist=math.pi)))
    by = Moved(0.052, 0.034, 0.012, (0.0, -0.1, 0.0))
    return Repair("repaired", CERTIFICATE, REPAIRED, by, phases, plan, 0.5, (1.0, 2.0, 0.0))


def standing_motion(robot, instants):
    """Instants and states of a robot that stands, 60 to a second."""
    loaded = load_robot(robot)
    q = loaded.posture
    qpos = np.concatenate([q[:3], q[6:7], q[3:6], q[7:]])
    return np.arange(instants) / 60, np.tile(qpos, (instants, 1))


def is_(jump, way):
    return math.isclose(jump.twist, way)


def work(seconds, cancelled):
    """Take time, asking whether to stop."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        time.sleep(0.01)
        if cancelled():
            raise errors.Cancelled("stopped")


def broken_factory():
    raise ModuleNotFoundError("no planner here")


def hanging_factory():
    time.sleep(60)
