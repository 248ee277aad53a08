"""Causes of a fall, found in a rollout.

Two sorts of things are looked for until the fall. *Deviations* say that the robot no longer does
what was planned: feet that slip, leave early or land elsewhere, a base or a CoM away from where it
should be, a touchdown that is unexpected or not noticed. Each has a threshold above what disturbed
robots that land show, and begins where it last was as small as theirs. *Limits* of the drives are
reached in good jumps, too: one is reported only where a deviation follows it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from llsrbm.arrays import Array, IntArray, stretches
from llsrbm.mechanics import rotation_matrices, turned
from llsrbm.motion.outcome import SATURATED
from llsrbm.motion.rollout import Rollout
from llsrbm.request.schedule import Schedule

TAKEOFF, FLIGHT, LANDING = range(3)
"""Before the first flight, in a flight, after one: what thresholds go by."""

_LEAVING = 0.3  # share of the flight in which contact is still that of feet that leave


class Record:
    """A rollout until its fall, T ticks of `tick`, s, cut up by what the controller believed.

    Attributes:
        count: T; end: s, the last of them; height: m of the standing CoM above the feet.
        part: (T,) `TAKEOFF`, `FLIGHT` or `LANDING`; contact: (T, L) bool; legs: names.
        swings: of each foot, [first tick, first tick in which contact is no longer that of a foot
            that leaves) of each time it leaves, by the plan's clock.
        overdue: (T,) whether a flight lasts longer than planned.
        landed: whether the controller believes to the end that the last flight is over.
        touchdown, detected: s, after the last flight and before the fall, or None; foot_touchdown.
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


def _parts(schedule: Schedule) -> IntArray:
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


# Thresholds in take-off, flight and landing; lengths are shares of the height at which the standing
# robot's CoM is. In brackets: the largest in 66 of 67 landings with everything disturbed (three
# robots, 16 jumps; one was a near miss in every respect).
LEAN = np.radians([4.0, 23.0, 25.0])  # of the base's z axis (1.9, 17.5, 19.3 deg)
TURN = np.radians([3.0, 15.0, 30.0])  # of yaw (0.5, 11.0, 23.6 deg)
SHIFT = np.array([0.04, 0.13, 0.13])  # of the CoM, horizontally (0.005, 0.071, 0.072)
SINK = np.array([0.06, 0.13, 0.27])  # of the CoM, downwards (0.022, 0.080, 0.212)
RISE = np.array([0.09, 0.16, 0.26])  # of the CoM, upwards (0.020, 0.083, 0.169)
SPIN = np.array([1.2, 1.2, np.inf])  # rad/s that L is worth too much; impacts change it (0.7, 0.8)
SLIP = np.array([0.075, 0.075, 0.13])  # that a foot moves on the ground (0.048, -, 0.092)
MISPLACED = 0.22  # of a foot at its touchdown (0.161)
STEP = 0.035  # m of ground higher or lower than planned (0.025, a board of the scenario)
EARLY, LATE = 0.05, 0.06  # s of the touchdown (0.033, 0.040)
UNNOTICED = 0.025  # s from touchdown to its detection (0.0075)
OFF_IN_TAKEOFF = 0.025  # s that a foot is in the air before lift-off (0)
STAYED = 0.03  # s that a foot stays on the ground after lift-off (0.010)
OFF_AGAIN = 0.05  # s that a foot is off the ground after its touchdown (0.025)

_BEGUN = 0.8  # share of its threshold that a deviation of a good jump does not reach
_GROWING = 0.1  # s after passing its threshold in which a deviation's size is read
_SETTLING = 0.01  # s that a foot may roll and creep when it touches down
_SHORTEST = 0.03  # s at a limit before something gives way
_SOON = 0.08  # s after a limit within which a deviation is put down to it
_TOO_FAST = 0.5  # share of a joint's largest torque limit below which it is its speed that limits


@dataclass(frozen=True)
class Event:
    """Something that went wrong."""

    time: float  # when it began, s
    # Its kind: "torque limit" or "speed limit" of joints; "contact lost", "lift-off", "slip",
    # "foothold" of feet; "touchdown", "ground", "detection", "false detection"; "lean", "turn" of
    # the base, "shift", "sink", "rise" of the CoM, "spin" of the whole.
    what: str
    words: str  # what happened, with names and sizes


def diagnose(rollout: Rollout) -> tuple[Event, ...]:
    """Events that led to a fall, in order of time; good landings have none."""
    record = Record(rollout)
    deviations = [
        *_touchdown(record),
        *_takeoff_contacts(record),
        *_slips(record),
        *_landing_contacts(record),
        *_away_from_reference(record),
    ]
    limits = _limits(record, [event.time for event in deviations])
    # Stable: of what begins in the same tick, a limit is the cause, and an error its consequence.
    return tuple(sorted((*limits, *deviations), key=lambda event: event.time))


def fall_in_words(rollout: Rollout) -> str:
    """When it fell, what went wrong first, and how it ended; "" for a robot that landed.

    The last push before that is named, whether it was the cause or not.
    """
    outcome = rollout.outcome
    if rollout.landed:
        return ""
    when = "" if outcome.fell_at_s is None else f"at {outcome.fell_at_s:.2f} s: "
    events = diagnose(rollout)
    if not events:
        return f"{when}{outcome.reason}"
    first = events[0]
    words = f"first {first.words} ({first.time:.2f} s){_push_before(rollout, first.time)}"
    return f"{when}{words}, then {outcome.reason}"


def _push_before(rollout: Rollout, time: float) -> str:
    """The last push that began before an instant, s, and how long before; "" for none."""
    before = [push for push in rollout.pushes if push.time <= time]
    if not before:
        return ""
    push = max(before, key=lambda each: each.time)
    impulse, moment = (float(np.linalg.norm(vector)) for vector in (push.impulse, push.moment))
    size = f"{impulse:.3g} N s" if impulse else f"{moment:.3g} N m s"
    return f", {time - push.time:.2f} s after the push of {size}"


def _away_from_reference(record: Record) -> Iterator[Event]:
    """Base, CoM and angular momentum that are not where the controller wants them."""
    rollout, n = record.rollout, record.count
    actual, wanted = (
        rotation_matrices(quat[:n]) for quat in (rollout.base_quat, rollout.reference_base_quat)
    )
    lean = np.arccos(np.clip((actual[:, :, 2] * wanted[:, :, 2]).sum(axis=1), -1.0, 1.0))
    turn = turned(rollout.base_quat[:n], rollout.reference_base_quat[:n])
    away = rollout.com[:n] - rollout.reference_com[:n]
    # In a flight that lasts longer than planned the reference stands still.
    lean[record.overdue] = turn[record.overdue] = 0.0
    away[record.overdue] = 0.0
    excess = (rollout.angular_momentum - rollout.reference_angular_momentum)[:n]
    spin = np.linalg.norm(np.linalg.solve(rollout.inertia[:n], excess[:, :, None])[:, :, 0], axis=1)
    # The controller takes off and flies on by its clock while feet are still, or again, loaded.
    spin[(record.part == FLIGHT) & record.contact.any(axis=1)] = 0.0
    degrees = 180 / np.pi
    signals = (
        ("lean", lean, LEAN, degrees, "the base leaned {:.0f}° away from the plan"),
        ("turn", np.abs(turn), TURN, degrees, "the base turned {:.0f}° away from the plan"),
        (
            "shift",
            np.linalg.norm(away[:, :2], axis=1),
            SHIFT * record.height,
            100,
            "the CoM moved {:.0f} cm sideways from the plan",
        ),
        ("sink", -away[:, 2], SINK * record.height, 100, "the CoM sank {:.0f} cm below the plan"),
        ("rise", away[:, 2], RISE * record.height, 100, "the CoM rose {:.0f} cm above the plan"),
        ("spin", spin, SPIN, 1, "the whole body's turning rate was {:.1f} rad/s off the plan"),
    )
    for what, values, thresholds, scale, words in signals:
        found = _first(values / thresholds[record.part])
        if found is not None:
            begun, passed = found
            size = _size(record, values, passed)
            yield Event(float(record.time[begun]), what, words.format(scale * size))


def _takeoff_contacts(record: Record) -> Iterator[Event]:
    """Feet that leave the ground too early or too late."""
    for leg, name in enumerate(record.legs):
        swings = record.swings[leg]
        off = ~record.contact[: swings[0][0] if swings else record.count, leg]
        for start, end in stretches(off):
            length = record.seconds(end - start)
            if length > OFF_IN_TAKEOFF:
                yield Event(
                    float(record.time[start]),
                    "contact lost",
                    f"{name} was off the ground for {1e3 * length:.0f} ms before lift-off",
                )
                break
        for start, left in swings:
            after = record.contact[start:left, leg]
            stayed = record.seconds(int(np.flatnonzero(after)[-1]) + 1) if after.any() else 0.0
            if stayed > STAYED:
                yield Event(
                    float(record.time[start]),
                    "lift-off",
                    f"{name} stayed on the ground for {1e3 * stayed:.0f} ms after lift-off",
                )
                break


def _slips(record: Record) -> Iterator[Event]:
    """The first time that each foot slips; feet roll a little on their spheres without slipping."""
    place = record.rollout.foot_position[..., :2]
    settling = round(_SETTLING / record.tick)
    for leg, name in enumerate(record.legs):
        for start, end in stretches(record.contact[:, leg]):
            stands = start + settling if start else start
            if stands >= end:
                continue
            moved = np.linalg.norm(place[stands:end, leg] - place[stands, leg], axis=1)
            found = _first(moved / (SLIP[record.part[stands]] * record.height))
            if found is not None:
                begun, passed = found
                size = float(moved[: passed + round(_GROWING / record.tick)].max())
                yield Event(
                    float(record.time[stands + begun]),
                    "slip",
                    f"{name} slipped {100 * size:.0f} cm "
                    f"(friction {record.rollout.disturbance.friction:.2f})",
                )
                break


def _touchdown(record: Record) -> Iterator[Event]:
    """A touchdown that comes when or where it was not planned, and how it was noticed."""
    rollout, true, detected = record.rollout, record.touchdown, record.detected
    if detected is not None and (true is None or detected < true):
        before = "" if true is None else f", {1e3 * (true - detected):.0f} ms before the first"
        yield Event(detected, "false detection", f"touchdown was detected without contact{before}")
    if true is None:
        return
    noticed = (record.end if detected is None else detected) - true
    if noticed > UNNOTICED:
        words = "not noticed" if detected is None else f"noticed {1e3 * noticed:.0f} ms late"
        yield Event(true, "detection", f"touchdown was {words}")
    early = rollout.outcome.touchdown_planned_s - true
    when = f"{1e3 * abs(early):.0f} ms {'early' if early > 0 else 'late'}"
    first = min((at, leg) for leg, at in enumerate(record.foot_touchdown) if at is not None)[1]
    planned = float(rollout.plan.foot_position[-1, first, 2])
    ground = float(rollout.foot_position[record.index(true), first, 2]) - planned
    if abs(ground) > STEP:
        where = f"{1e3 * abs(ground):.0f} mm {'higher' if ground > 0 else 'lower'} than planned"
        yield Event(true, "ground", f"{record.legs[first]} met ground {where}, {when}")
    elif early > EARLY or early < -LATE:
        yield Event(true, "touchdown", f"touchdown came {when}")


def _landing_contacts(record: Record) -> Iterator[Event]:
    """Feet that touch down in the wrong place, or do not stay down."""
    rollout = record.rollout
    # Without a detected touchdown the feet have no footholds, but a place under the CoM.
    foothold = rollout.reference_foot_position[-1]
    for leg, (name, at) in enumerate(zip(record.legs, record.foot_touchdown, strict=True)):
        if at is None:
            continue
        touched = record.index(at)
        aside = rollout.foot_position[touched, leg, :2] - foothold[leg, :2]
        missed = float(np.linalg.norm(aside))
        if record.landed and missed > MISPLACED * record.height:
            yield Event(
                at, "foothold", f"{name} touched down {100 * missed:.0f} cm from its foothold"
            )
        for start, end in stretches(~record.contact[touched:, leg]):
            length = record.seconds(end - start)
            if length > OFF_AGAIN:
                yield Event(
                    float(record.time[touched + start]),
                    "contact lost",
                    f"{name} lost the ground for {1e3 * length:.0f} ms after touchdown",
                )
                break


def _limits(record: Record, begun: Sequence[float]) -> Iterator[Event]:
    """Joints at what their drives can give while a deviation begins."""
    rollout, n = record.rollout, record.count
    limit = rollout.torque_limit[:n]
    at_limit = np.abs(rollout.torque[:n]) >= SATURATED * limit
    found: dict[str, list[tuple[float, float, str]]] = {"torque limit": [], "speed limit": []}
    for joint, name in enumerate(rollout.joint_names):
        for start, end in stretches(at_limit[:, joint]):
            first, last = float(record.time[start]), record.seconds(end)
            following = min((time for time in begun if time >= first), default=np.inf)
            # What comes at once is what brought the joint to its limit.
            long = min(last, following) - first >= _SHORTEST
            if not long or following > last + _SOON:
                continue
            given = float(limit[start:end, joint].mean())
            slow = given > _TOO_FAST * rollout.torque_limit[:, joint].max()
            found["torque limit" if slow else "speed limit"].append((first, last, name))
            break
    for what, at_limits in found.items():
        if not at_limits:
            continue
        first, last, name = min(at_limits, key=lambda item: (item[0], -item[1]))
        together = {other for start, _, other in at_limits if start < last and other != name}
        more = f"{len(together)} more joint{'s' if len(together) > 1 else ''}"
        which = f"{name} and {more} were" if together else f"{name} was"
        yield Event(first, what, f"{which} at the {what} for {1e3 * (last - first):.0f} ms")


def _first(share: Array) -> tuple[int, int] | None:
    """Where a deviation (T,), in shares of its threshold, began, and where it passed it."""
    above = np.flatnonzero(share > 1.0)
    if not len(above):
        return None
    passed = int(above[0])
    before = np.flatnonzero(share[:passed] < _BEGUN)
    return (int(before[-1]) + 1 if len(before) else 0), passed


def _size(record: Record, values: Array, passed: int) -> float:
    return float(values[passed : passed + round(_GROWING / record.tick) + 1].max())
