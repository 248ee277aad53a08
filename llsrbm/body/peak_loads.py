"""The largest loads of the joints, of arrays over intervals."""

from typing import NamedTuple

import numpy as np

from llsrbm.arrays import Array, BoolArray, IntArray
from llsrbm.request.schedule import Schedule


def torque_share(torque: Array, available: Array) -> Array:
    """|torque| as a share of what is available, (...); infinite where nothing is, 0 of 0."""
    size = np.abs(torque)
    some = available > 0
    return np.where(some, size / np.where(some, available, 1.0), np.where(size > 0, np.inf, 0.0))


class PeakLoad(NamedTuple):
    """The joint, and the interval, with the largest share of the torque that is available there."""

    joint: str  # its name
    phase: str  # name of the interval's
    time: float  # s, its middle
    event: str  # "lift-off" or "touchdown" where it begins or ends with that of a foot, else ""
    torque: float  # Nm or N, with its sign
    available: float  # what the drive can give in that direction

    @property
    def ratio(self) -> float:
        """Share of what is available; infinite where nothing is."""
        return float(torque_share(np.array(self.torque), np.array(self.available)))

    def in_words(self, sliding_joints: frozenset[str] = frozenset()) -> str:
        """Without the joint's name, for instance "34 of 40 Nm at lift-off (85 %)".
        `sliding_joints`: names of those whose torque is a force (`Robot.sliding_joints`).
        """
        unit = "N" if self.joint in sliding_joints else "Nm"
        when = when_in_words(self.phase, self.time, self.event)
        load = f"{abs(self.torque):.0f} of {self.available:.0f} {unit} {when}"
        if not np.isfinite(self.ratio):
            return f"{load} (too fast for any torque)"
        return f"{load} ({100 * self.ratio:.0f} %)"


def event_beside(contact: BoolArray, interval: int) -> str:
    """Either "lift-off" or "touchdown" where an interval begins or ends with that of a foot, or "".

    `contact`: (N, L) whether a foot stands over an interval.
    """
    around = contact[max(0, interval - 1) : interval + 2]
    if (around[:-1] & ~around[1:]).any():
        return "lift-off"
    if (~around[:-1] & around[1:]).any():
        return "touchdown"
    return ""


def when_in_words(phase: str, time: float, event: str) -> str:
    """For instance "at lift-off" or "in flight at 0.52 s"; `event` as `event_beside` has it."""
    return f"at {event}" if event else f"in {phase} at {time:.2f} s"


def peak_load(
    names: tuple[str, ...],
    time: Array,
    phase: IntArray,
    schedule: Schedule,
    torque: Array,
    available: Array,
) -> PeakLoad:
    """The largest load over N intervals of J joints: `torque`, `available` (N, J) Nm or N.

    `time`: (N+1,) s, their ends; `phase`: (N,) index into the schedule's phases.
    """
    k, j = np.unravel_index(np.argmax(torque_share(torque, available)), torque.shape)
    return PeakLoad(
        joint=names[j],
        phase=schedule[int(phase[k])].name,
        time=float(time[k] + time[k + 1]) / 2,
        event=event_beside(schedule.stands[phase], int(k)),
        torque=float(torque[k, j]),
        available=float(available[k, j]),
    )
