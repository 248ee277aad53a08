"""Does the diagnosis of a fall name what was put in its way?

    python -m benchmarks.falls --seeds 100:105

Every run has everything disturbed that `llsrbm.simulation.disturbance` disturbs, and one cause
that makes a robot fall. The table counts the first event of the falls: "named" are those of a kind
that the cause shows itself by. The rows without a cause tell how many landings show any event.
Thresholds were set on seeds below 100.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from typing import Any
from unittest.mock import patch

import numpy as np
import typer

import llsrbm
from llsrbm.analysis.diagnosis import diagnose
from llsrbm.robots import load_robot
from llsrbm.robots.drives import torque_in_direction
from llsrbm.simulation import simulate as loop
from llsrbm.simulation import world as surrounding
from llsrbm.simulation.surroundings import Block, surroundings

JUMPS = {
    "90 deg": llsrbm.Jump(twist=math.pi / 2),
    "30 cm": llsrbm.Jump(forward=0.3),
    "45 deg + 20 cm": llsrbm.Jump(twist=math.pi / 4, forward=0.2),
    "30 cm left": llsrbm.Jump(lateral=0.3),
}
PUSH = 0.05  # s

Patch = Any  # a context manager of unittest.mock
Cause = Callable[[float, Any, np.random.Generator], Patch]


def another_world(name: str) -> Cause:
    """The disturbance with one of its numbers put to `amount`."""
    draw = loop.draw_disturbance

    def cause(amount: float, _plan: Any, _rng: np.random.Generator) -> Patch:
        value = int(amount) if name == "torque_delay_ticks" else amount
        return patch.object(loop, "draw_disturbance", lambda c: replace(draw(c), **{name: value}))

    return cause


def weak_drives(amount: float, _plan: Any, _rng: np.random.Generator) -> Patch:
    return torques(amount)


def a_weak_knee(amount: float, plan: Any, rng: np.random.Generator) -> Patch:
    robot = load_robot(plan.jump.robot)
    share = np.ones(len(robot.joint_names))
    share[rng.choice(robot.leg_joint_index[:, -1])] = amount
    return torques(share)


def torques(share: Any) -> Patch:
    """Drives that give a share of what the controller believes."""

    def weaker(robot: Any, speed: Any, torque: Any) -> Any:
        return share * torque_in_direction(robot, speed, torque)

    return patch("llsrbm.simulation.world.torque_in_direction", weaker)


def detection(wanted: Callable[[float, float, float, bool], bool]) -> Cause:
    """A detector that reports when `wanted` says so.

    Args:
        wanted: of amount, time in flight, time since contact was seen, and whether it was, s.
    """

    def cause(amount: float, _plan: Any, _rng: np.random.Generator) -> Patch:
        class Detector(loop.WholeBodyController):
            def __init__(self, *arguments: Any) -> None:
                super().__init__(*arguments)
                update, tick = self.detector.update, self.detector.tick
                flight, since = 0.0, 0.0

                def changed(state: Any) -> bool:
                    nonlocal flight, since
                    flight += tick
                    seen = update(state) or since > 0
                    since += tick * seen
                    return wanted(amount, flight, since, seen)

                self.detector.update = changed  # type: ignore[method-assign]

        return patch.object(loop, "WholeBodyController", Detector)

    return cause


def push(*, turning: bool) -> Cause:
    """A jolt to the trunk in a random direction: rad/s in flight, or m/s in take-off."""

    def cause(amount: float, plan: Any, rng: np.random.Generator) -> Patch:
        robot = load_robot(plan.jump.robot)
        takeoff, flight = plan.lift_off, plan.touchdown - plan.lift_off
        start = takeoff + 0.1 * flight if turning else takeoff / 2
        angle = rng.uniform(0, 2 * math.pi)
        way = np.array([math.cos(angle), math.sin(angle), 0.0])
        jolt = (robot.inertia @ way if turning else robot.mass * way) * amount / PUSH
        advance = loop.World.advance

        def pushed(world: Any, torque: Any) -> Any:
            if start <= world.time < start + PUSH:
                world.push(*((np.zeros(3), jolt) if turning else (jolt, np.zeros(3))))
            return advance(world, torque)

        return patch.object(loop.World, "advance", pushed)

    return cause


def lower_ground(amount: float, _plan: Any, _rng: np.random.Generator) -> Patch:
    """The robot starts on a block that is drawn away in flight."""

    def sunk(robot: Any, plan: Any, scenario: Any) -> Any:
        around = surroundings(robot, plan, scenario)
        start = Block(
            "start",
            np.array([0.0, 0.0, -amount / 2]),
            np.array([2.0, 2.0, amount]),
            0.0,
            until_s=(plan.lift_off + plan.touchdown) / 2 - PUSH,
        )
        return replace(around, ground=around.ground - amount, blocks=(*around.blocks, start))

    return patch.object(surrounding, "surroundings", sunk)


@dataclass(frozen=True)
class Row:
    """A cause, how strong, and the kinds of event that it shows itself by."""

    cause: Cause | None
    amounts: tuple[float, ...]
    kinds: tuple[str, ...]


ROWS = {
    "nothing": Row(None, (0.0,), ()),
    "friction": Row(another_world("friction"), (0.06, 0.12), ("slip",)),
    "trunk's mass": Row(
        another_world("trunk_mass_factor"), (1.8, 2.2), ("sink", "torque limit", "speed limit")
    ),
    "torque delay": Row(
        another_world("torque_delay_ticks"), (12, 16), ("sink", "torque limit", "lift-off")
    ),
    "weak drives": Row(weak_drives, (0.35, 0.5), ("torque limit", "speed limit")),
    "a weak knee": Row(a_weak_knee, (0.2, 0.4), ("torque limit", "speed limit")),
    "touchdown missed": Row(detection(lambda *_: False), (0.0,), ("detection",)),
    "detected late": Row(
        detection(lambda amount, _flight, since, _seen: since > amount),
        (0.08, 0.12),
        ("detection",),
    ),
    "detected early": Row(
        detection(lambda amount, flight, _since, seen: seen or flight > amount),
        (0.135, 0.18),
        ("false detection",),
    ),
    "push in flight": Row(push(turning=True), (1.5, 2.5), ("spin", "lean", "turn")),
    "push in take-off": Row(push(turning=False), (1.5, 2.5), ("shift", "spin", "contact lost")),
    "lower ground": Row(lower_ground, (0.25, 0.4), ("ground",)),
}


@contextmanager
def in_place(cause: Cause | None, amount: float, plan: Any, seed: int) -> Iterator[None]:
    with ExitStack() as stack:
        if cause is not None:
            stack.enter_context(cause(amount, plan, np.random.default_rng([seed, 77])))
        yield


def main(seeds: str = "100:105", causes: str = ",".join(ROWS)) -> None:
    first, last = (int(part) for part in seeds.split(":"))
    plans = [llsrbm.plan(jump) for jump in JUMPS.values()]
    head = f"{'cause':18}{'runs':>5}{'fell':>5}{'named':>6}{'landed with events':>20}  first event"
    print(head)
    for name in causes.split(","):
        row = ROWS[name]
        runs, near, found = 0, 0, Counter[str]()
        for seed in range(first, last):
            for amount in row.amounts:
                for plan in plans:
                    with in_place(row.cause, amount, plan, seed):
                        rollout = llsrbm.simulate(plan, seed=seed)
                    events = diagnose(rollout)
                    runs += 1
                    if rollout.landed:
                        near += bool(events)
                    else:
                        found[events[0].what if events else "none"] += 1
        fell, named = found.total(), sum(found[kind] for kind in row.kinds)
        counts = ", ".join(f"{kind} {count}" for kind, count in found.most_common())
        landed = f"{near} of {runs - fell}"
        print(f"{name:18}{runs:>5}{fell:>5}{named:>6}{landed:>20}  {counts}", flush=True)


if __name__ == "__main__":
    typer.run(main)
