"""Commands and readings at 500 Hz between two processes over DDS on the loopback.

    python benchmarks/wire_rate.py [--seconds 60] [--robot go2] [--fifo]

A player's process sends numbered commands, a robot's numbered readings, each on a clock of its own
and with what is done beside: packing, checksums, conversion. Prints for each direction: messages
sent, received and lost, and the period between messages as they were received. Whatever else the
machine does decides the worst ones; `--fifo` runs both before it (SCHED_FIFO, needs root).
"""

import json
import os
import subprocess
import sys
import time
from typing import Annotated

import numpy as np
import typer

from llsrbm.control.motor_command import MotorCommand
from llsrbm.control.readings import Readings
from llsrbm.processors import usable_processors
from llsrbm.robots import load_robot
from llsrbm.wire.dds import DdsLink, DdsRobot
from llsrbm.wire.real_time import go_first

PERIOD = 0.002  # s
DOMAIN = 210  # nobody else's
SETTLES = 1.0  # s after the last message in which all that is under way arrives


def robot_side(name: str, count: int) -> dict[str, list[float]]:
    """Publish readings by the clock, and note when which command comes in between."""
    robot = load_robot(name)
    end, joints = DdsRobot(robot, "lo", DOMAIN), len(robot.joint_names)
    still = np.zeros(joints)
    quat, up = np.array([1.0, 0, 0, 0]), np.array([0.0, 0, 9.81])
    numbers, times = [], []

    def take(until: float) -> None:
        while (left := until - time.perf_counter()) > 0:
            for command in end.commands(left):
                numbers.append(round(float(command.q[0])))
                times.append(time.perf_counter())

    while not end.commands(0.5):  # the player is there, and sends
        pass
    start = time.perf_counter()
    for k in range(count):
        take(start + k * PERIOD)
        end.publish(Readings(k / 1000, quat, still[:3], up, still, still, still, None), 1.0)
    take(time.perf_counter() + SETTLES)
    return {"numbers": numbers, "times": times}


def player_side(name: str, count: int) -> tuple[dict[str, list[float]], list[float]]:
    """Send commands by the clock, and note which reading comes when; when commands were sent."""
    robot = load_robot(name)
    link, joints = DdsLink(robot, "lo", DOMAIN), len(robot.joint_names)
    still = np.zeros(joints)
    numbers, times, sent = [], [], []

    def take(until: float) -> None:
        while (left := until - time.perf_counter()) > 0:
            reading = link.receive(left)
            if reading is not None:
                numbers.append(round(1000 * reading.time))
                times.append(time.perf_counter())

    while not link._ends.matched():
        time.sleep(0.01)
    time.sleep(0.5)  # the other side finds this one's reader as well
    link.send(MotorCommand.of_torque(still - 1))
    start = time.perf_counter()
    for k in range(count):
        take(start + k * PERIOD)
        sent.append(time.perf_counter())
        link.send(MotorCommand(still + k, still, still, still, still))
    take(time.perf_counter() + SETTLES)
    return {"numbers": numbers, "times": times}, sent


def show(what: str, count: int, seen: dict[str, list[float]]) -> None:
    """One line of figures."""
    numbers, times = np.array(seen["numbers"]), np.array(seen["times"])
    own = numbers >= 0
    received = len(set(numbers[own].tolist()))
    period = 1e3 * np.diff(times[own])
    p50, p99 = np.percentile(period, [50, 99])
    print(
        f"{what:9} sent {count}, received {received}, lost {count - received}; period p50 "
        f"{p50:.2f} ms, p99 {p99:.2f} ms, worst {period.max():.2f} ms"
    )


def main(
    seconds: float = 60.0,
    robot: str = "go2",
    fifo: Annotated[bool, typer.Option("--fifo", help="Before all else.")] = False,
    side: Annotated[str, typer.Option(hidden=True)] = "player",
) -> None:
    """Measure, and print."""
    if fifo:
        go_first()
    count = round(seconds / PERIOD)
    if side == "robot":
        print(json.dumps(robot_side(robot, count)))
        return
    options = ["--seconds", str(seconds), "--robot", robot, "--side", "robot"]
    process = subprocess.Popen(
        [sys.executable, __file__, *options, *(["--fifo"] if fifo else [])],
        stdout=subprocess.PIPE,
        text=True,
    )
    load = os.getloadavg()[0]
    readings, sent = player_side(robot, count)
    commands = json.loads(process.communicate(timeout=60 + seconds)[0])
    show("commands", count, commands)
    show("readings", count, readings)
    late = 1e3 * (np.array(sent) - sent[0] - PERIOD * np.arange(count))
    print(f"commands were sent late by {np.median(late):.2f} ms, at worst {late.max():.2f} ms")
    print(f"load before {load:.1f}, after {os.getloadavg()[0]:.1f} on {usable_processors()} cores")


if __name__ == "__main__":
    typer.run(main)
