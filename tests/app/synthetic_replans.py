"""What might have been planned anew during a rollout: the CoM as it flew, footholds below it."""

from dataclasses import replace

import numpy as np

from llsrbm.motion.replan import Replan

EVERY, LATENCY = 0.02, 0.02  # s
KNOTS = 9


def with_replans(rollout, plan):
    """The rollout with replans from lift-off to touchdown, and its scenario's `replan`.

    The third one was not solved, and the fifth came too late.
    """
    flight = plan.schedule.flights[0]
    lift_off, touchdown = plan.phase_start[flight : flight + 2]
    end = plan.duration
    replans = []
    for number, asked in enumerate(np.arange(lift_off, touchdown - LATENCY, EVERY)):
        solved, late = number != 2, number == 4
        time = np.linspace(asked + LATENCY, end, KNOTS)
        ticks = np.searchsorted(rollout.time, time).clip(0, len(rollout.time) - 1)
        com = rollout.com[ticks]
        moved = np.zeros(3)
        moved[:2] = (com - plan.com[-1])[-1, :2] * (asked - lift_off) / (touchdown - lift_off)
        feet = np.repeat(plan.foot_position[-1:] + moved, KNOTS, axis=0)
        replans.append(
            Replan(
                measured=float(asked),
                applied=float(asked + LATENCY) if solved and not late else np.nan,
                computing_time=0.031 if late else 0.008 + 0.001 * (number % 5),
                solved=solved,
                iterations=5,
                touchdown=float(touchdown) if solved else np.nan,
                time=time if solved else time[:0],
                com=com if solved else com[:0],
                base_quat=(rollout.base_quat[ticks]) if solved else np.zeros((0, 4)),
                foot_position=feet if solved else feet[:0],
                foot_quat=np.repeat(plan.foot_quat[-1:], KNOTS if solved else 0, axis=0),
            )
        )
    scenario = replace(rollout.scenario, replan=True)
    return replace(rollout, replans=tuple(replans), scenario=scenario)
