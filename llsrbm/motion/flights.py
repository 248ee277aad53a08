"""The flights of a rollout, as the simulator's contacts tell them."""

from dataclasses import dataclass

import numpy as np

from llsrbm.arrays import Array, BoolArray, IntArray
from llsrbm.motion.rollout import Rollout

_SAME_INSTANT = 1e-9  # s


@dataclass(frozen=True)
class Flight:
    """From when the last foot has left the ground until the first one is back.

    Attributes:
        lift_off: s, the end of the last tick with a contact; None if a foot never left.
        touchdown: s, when the first contact begins; detected: s, when the controller took it for
            over; None if never.
    """

    lift_off: float | None
    touchdown: float | None
    detected: float | None

    @property
    def duration(self) -> float | None:
        """s; None where there was no touchdown."""
        if self.touchdown is None or self.lift_off is None:
            return None
        return self.touchdown - self.lift_off


def flights(rollout: Rollout) -> tuple[Flight, ...]:
    """In order; of a schedule with several flights those that the controller began.

    The outcome knows when a single flight ended. Among several, each one's touchdown is its
    first contact after a tick without any, within the controller's flight.
    """
    outcome, phases = rollout.outcome, rollout.schedule.flights
    if len(phases) == 1:
        touchdown = outcome.touchdown_true_s
        lift_off = _lift_off(rollout, 0, touchdown)
        return (Flight(lift_off, touchdown, outcome.touchdown_detected_s),)
    found, after = [], 0
    for phase in phases:
        inside = after + np.flatnonzero(rollout.phase[after:] == phase)
        if not len(inside):
            break
        end = int(inside[-1]) + 1
        detected = float(rollout.time[end]) if end < len(rollout.time) else None
        touchdown = _first_contact(rollout, inside)
        found.append(Flight(_lift_off(rollout, after, touchdown), touchdown, detected))
        after = end
    return tuple(found)


def without_contact(rollout: Rollout, flight: Flight) -> BoolArray:
    """(T,) ticks of a flight that has ended."""
    assert flight.lift_off is not None
    assert flight.touchdown is not None
    before = _ends(rollout) <= flight.touchdown + _SAME_INSTANT
    return before & (rollout.time >= flight.lift_off - _SAME_INSTANT)


def _lift_off(rollout: Rollout, after: int, touchdown: float | None) -> float | None:
    """s: the end of the last tick with a contact, from the tick `after` until a touchdown."""
    contact = _in_contact(rollout)
    if touchdown is None:
        aloft = np.flatnonzero(~contact[after:])
        if not len(aloft):
            return None
        stop = after + int(aloft[0])
    else:
        stop = int((_ends(rollout) <= touchdown + _SAME_INSTANT).sum())
    standing = np.flatnonzero(contact[after:stop])
    if len(standing):
        return float(_ends(rollout)[after + standing[-1]])
    return float(rollout.time[after])


def _first_contact(rollout: Rollout, inside: IntArray) -> float | None:
    """s: among the ticks of a controller's flight, or where it ends; None with the rollout."""
    contact = _in_contact(rollout)[inside]
    if contact.all():
        return None
    off = int(np.argmin(contact))
    back = np.flatnonzero(contact[off:])
    tick = int(inside[off + back[0]]) if len(back) else int(inside[-1]) + 1
    return float(rollout.time[tick]) if tick < len(rollout.time) else None


def _in_contact(rollout: Rollout) -> BoolArray:
    return np.asarray(rollout.contact.astype(bool).any(axis=1))


def _ends(rollout: Rollout) -> Array:
    return rollout.time + 1.0 / rollout.outcome.control_rate_hz
