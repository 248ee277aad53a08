"""A simulated robot behind its own topics, in step with the wall clock."""

import gc
import os
import time as wall_clock
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

from llsrbm.errors import InputError
from llsrbm.wire.dds import DdsRobot
from llsrbm.wire.simulated_robot import TICK, SimulatedRobot

BEHIND = 0.1  # s; a computer that is later than this is not caught up with, its robot's clock slips


_PRIORITY = 10  # of 1 to 99; the system's own real-time threads mostly have 50 and more


def go_first() -> None:
    """Let this process run before all ordinary ones. Raises `InputError`: the system forbids it."""
    if not hasattr(os, "sched_setscheduler"):
        raise InputError("fifo: this system has no real-time priority; expected Linux")
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(_PRIORITY))
    except PermissionError as error:
        raise InputError(
            f"fifo: expected a user who may use real-time priority {_PRIORITY} (ulimit -r)"
        ) from error


@dataclass
class Punctuality:
    """How well a simulation has kept step: ticks begin when they are due, or late.

    Attributes:
        late: ticks that began more than a tick late; worst: by how much at most, s.
        slipped: s by which the robot's clock has slipped behind the wall's for good.
        computing: s, of the simulation and messages of each of the last minute's ticks.
    """

    ticks: int = 0
    late: int = 0
    worst: float = 0.0
    slipped: float = 0.0
    computing: deque[float] = field(default_factory=lambda: deque(maxlen=round(60.0 / TICK)))


def run(
    robot: SimulatedRobot,
    end: DdsRobot,
    duration: float,
    stopped: Callable[[], bool] = lambda: False,
) -> Punctuality:
    """Let a robot live for so long, s, or until `stopped`; commands come and readings go by `end`.

    Commands are stamped as they arrive, between ticks, and take the robot's own delay from there.
    Raises `llsrbm.simulation.world.Diverged`.
    """
    gc.freeze()  # a collection of all that was loaded takes several ticks
    try:
        return _run(robot, end, duration, stopped)
    finally:
        gc.unfreeze()


def _run(
    robot: SimulatedRobot, end: DdsRobot, duration: float, stopped: Callable[[], bool]
) -> Punctuality:
    found, clock = Punctuality(), wall_clock.perf_counter
    start = clock() - robot.time
    until = robot.time + duration
    while robot.time < until - TICK / 2 and not stopped():
        due = start + robot.time
        while True:
            left = due - clock()
            for command in end.commands(max(0.0, left)):
                robot.send(command, min(robot.time, clock() - start))
            if clock() >= due:
                break
        began = clock()
        late = began - due
        found.worst = max(found.worst, late)
        found.late += late > TICK
        if late > BEHIND:
            start += late
            found.slipped += late
        robot.tick()
        for readings in robot.readings():
            end.publish(readings, robot.voltage)
        found.ticks += 1
        found.computing.append(clock() - began)
    return found
