"""A rollout until its fall, cut up by what the controller believed: what a diagnosis looks at."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from llsrbm.motion.rollout import Rollout
from llsrbm.request.schedule import Schedule

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

TAKEOFF, FLIGHT, LANDING = range(3)
"""Before the first flight, in a flight, after one: what thresholds go by."""

_LEAVING = 0.3  # share of the flight in which contact is still that of feet that leave


class Record:
    """A rollout until its fall: T ticks, and what several questions need.

    Attributes:
        rollout: the whole; tick: s.
        count: T; end: s, the last of them.
        height: m of the CoM above the feet when standing, by the plan.
        part: (T,) `TAKEOFF`, `FLIGHT` or `LANDING`; contact: (T, L) bool; legs: names.
        swings: of each foot, [first tick, first tick in which contact is no longer that of a foot
            that leaves) of each time it leaves, by the plan's clock.
        overdue: (T,) whether a flight lasts longer than planned.
        landed: whether the controller believes to the end that the last flight is over.
        touchdown, detected: s, None if they are not before the fall; foot_touchdown: each foot's.
            Those after the last flight.
    """

    def __init__(self, rollout: Rollout) -> None:
        outcome = rollout.outcome
        self.rollout = rollout
        self.time = rollout.time
        self.tick = 1.0 / outcome.control_rate_hz
        fell_at = np.inf if outcome.fell_at_s is None else outcome.fell_at_s
        self.count = max(1, int(np.searchsorted(rollout.time, fell_at, side="right")))
        self.end = float(rollout.time[self.count - 1])
        self.height = float(
            rollout.reference_com[0, 2] - rollout.reference_foot_position[0, :, 2].mean()
        )
        self.contact = rollout.contact[: self.count].astype(bool)
        self.legs = rollout.leg_names
        schedule = rollout.schedule
        phase = rollout.phase[: self.count]
        self.part = _parts(schedule)[phase]
        self.landed = bool(rollout.phase[-1] > schedule.flights[-1])
        ends = _planned_touchdowns(rollout, schedule)
        self.overdue = np.zeros(self.count, dtype=bool)
        for flight, end in ends.items():
            self.overdue |= (phase == flight) & (self.time[: self.count] > end)
        self.swings = [
            [(start, self._left(ends, int(phase[start]), start, end)) for start, end in swings]
            for swings in map(stretches, ~schedule.stands[phase].T)
        ]
        self.foot_touchdown = [self._before_fall(at) for at in outcome.foot_touchdown_s]
        self.touchdown = min((at for at in self.foot_touchdown if at is not None), default=None)
        self.detected = self._before_fall(outcome.touchdown_detected_s)

    def _left(self, ends: dict[int, float], phase: int, start: int, end: int) -> int:
        """First tick in which a foot that swings in [start, end) has surely left the ground."""
        touchdown = next((ends[flight] for flight in sorted(ends) if flight >= phase), self.end)
        share = _LEAVING * max(0.0, touchdown / self.tick - start)
        return min(start + round(share), end)

    def index(self, time: float) -> int:
        """The tick in which an instant lies."""
        return int(np.searchsorted(self.time, time + 1e-9, side="right")) - 1

    def seconds(self, ticks: int) -> float:
        """As a length of time."""
        return ticks * self.tick

    def _before_fall(self, time: float | None) -> float | None:
        return None if time is None or time > self.end else time


def _parts(schedule: Schedule) -> NDArray[np.int64]:
    """(P,) `TAKEOFF`, `FLIGHT` or `LANDING`, of each phase."""
    part = np.full(len(schedule), LANDING)
    part[: schedule.flights[0]] = TAKEOFF
    part[list(schedule.flights)] = FLIGHT
    return part


def _planned_touchdowns(rollout: Rollout, schedule: Schedule) -> dict[int, float]:
    """Flight -> when it was planned to end, retimed by the touchdowns before it, s."""
    *earlier, last = schedule.flights
    ends = {last: rollout.outcome.touchdown_planned_s}
    length = np.diff(rollout.plan.phase_start)
    for flight in earlier:
        begun = int(np.argmax(rollout.phase == flight))
        ends[flight] = float(rollout.time[begun] + length[flight])
    return ends


def stretches(on: Mask) -> list[tuple[int, int]]:
    """[start, end) of each stretch of True in (T,)."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], on, [False]]).astype(np.int8)))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]
