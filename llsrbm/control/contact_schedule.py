"""The feet that stand: lifted by the schedule, put down by measured contact.

Feet leave when the plan says, which is the robot's own doing. The ground may be nearer or farther
than planned, and the robot may have jumped higher. So

- a flight begins by the clock and ends when the contact detector says so, and it went through the
  feet: a push on the trunk is no touchdown (`MeasuredImpulse`). The plan's clock is set to the
  planned touchdown, and all later phases come as much earlier or later;
- a foot that lands while others stand is swung as planned until its planned landing, and then seeks
  the ground. It stands from the moment at which its leg feels load, or, once it seeks, at which it
  has stopped sinking: a foot that is put down gently shows no force that stands out of noise;
- a foot that lifts while others stand leaves by the clock.

The feet that stand measure how high the ground is, and the motion is raised by that from there on.
"""

from dataclasses import dataclass

import numpy as np

from llsrbm.arrays import Array, BoolArray
from llsrbm.control.delay import Measurement
from llsrbm.control.foot_force import FootForces
from llsrbm.control.whole_body import WholeBody
from llsrbm.motion.plan import Plan
from llsrbm.motion.sampling import foothold_knots

JUST_AFTER = (
    1e-3  # s after touchdown, where the nearest sample of a plan surely is one on the ground
)
# A foot that seeks the ground from rest sinks at 0.2 m/s after this time, s; one that then is
# slower than this, m/s, for so many ticks has met it.
_SEEKING_TIME = 0.015
_STOPPED_BELOW = 0.05
_STILL_TICKS = 3
_BOUNCES = 0.02  # s without load; what measures it needs some ticks to begin with
_LEFT = 0.5  # of a swing while others stand: a foot that feels load before is one that leaves late


@dataclass
class Flight:
    """A flight as it was flown."""

    phase: int  # its place in the schedule
    # lift_off, touchdown: s: when it was planned to begin and to end, retimed by the touchdowns
    # before it.
    lift_off: float
    touchdown: float
    detected: float | None = None  # s: when its touchdown was detected; None before


class ContactSchedule:
    """The state of a plan's schedule while it is followed: P phases, L feet, from standing on all.

    `standing`: (L,) feet that stand as far as is known; `flights`: those that have begun, in order;
    `ground_shift`: height of the ground under the feet that stand, or stood last, above the plan's,
    m.
    """

    def __init__(self, plan: Plan, body: WholeBody, feet: FootForces, tick: float) -> None:
        self._schedule = plan.schedule
        self._body, self._feet, self._tick = body, feet, tick
        self._stands = plan.schedule.stands
        self._take(plan)

        self.phase = 0
        self.standing: BoolArray = self._stands[0].copy()
        self.flights: list[Flight] = []
        self.ground_shift = 0.0
        self._light = np.zeros(body.legs, dtype=np.int64)  # ticks that a foot has stood unloaded
        # The plan's clock: this time of the plan was at that time.
        self._plan_time, self._at = 0.0, 0.0
        self._still = np.zeros(body.legs, dtype=np.int64)
        self._seeking_since = np.full(body.legs, np.inf)

    def _take(self, plan: Plan) -> None:
        phases = range(len(plan.schedule))
        self._start = plan.phase_start
        # (K + 1, L, 3) m; of a foot that never stands in a place it does not matter.
        self._footholds = plan.foot_position[foothold_knots(plan), np.arange(self._body.legs)]
        self._comes_from = np.array([_coming_from(plan, p) for p in phases])
        self._pushes_from = np.array([_pushing_from(plan, p) for p in phases])

    def follow(self, plan: Plan) -> None:
        """Go on with another plan, of the same schedule and clock; what has happened stays."""
        self._take(plan)
        if self.flying:
            end = self._start[self.phase + 1] - self._plan_time + self._at
            self.flights[-1].touchdown = float(end)

    @property
    def flying(self) -> bool:
        """True if no foot stands, as far as is known."""
        return self._schedule[self.phase].is_flight

    @property
    def carrying(self) -> BoolArray:
        """(L,) feet that stand and have felt load not long ago: a foot that bounces does not.

        Until a foot first leaves the ground all that stand are taken to.
        """
        return self.standing & (self._light < _BOUNCES / self._tick)

    @property
    def planned(self) -> BoolArray:
        """(L,) feet that stand in the present phase of the plan."""
        return self._stands[self.phase]

    @property
    def seeking(self) -> BoolArray:
        """(L,) feet that should stand and do not yet."""
        return self.planned & ~self.standing

    @property
    def foothold(self) -> Array:
        """(L, 3) m: where feet stand in the present place, as planned."""
        return self._footholds[self._schedule[self.phase].place]

    @property
    def detected(self) -> float | None:
        """When the last touchdown was detected, s; None in the first take-off and in flight."""
        return self.flights[-1].detected if self.flights else None

    def plan_time(self, time: float) -> float:
        """The time of the plan at a time, s."""
        return self._plan_time + time - self._at

    def reference_time(self, time: float) -> float:
        """The same, but no time of a phase that is over: feet lift up to half a tick early.

        Before the plan's start it is negative: the robot stands.
        """
        if self.phase == 0:
            return self.plan_time(time)
        return max(self.plan_time(time), float(self._start[self.phase]) + JUST_AFTER)

    def lands(self, time: float) -> bool:
        """True if standing feet catch a landing: the first half of a stance between flights."""
        return not self.flying and bool(self.plan_time(time) < self._pushes_from[self.phase])

    def follow_clock(self, time: float) -> bool:
        """Lift the feet whose time has come; whether a flight begins with it."""
        if self.flying:
            return False
        # Half a tick, so that rounding of times cannot shift a phase by a whole one.
        now = self.plan_time(time) + self._tick / 2
        for phase in range(self.phase + 1, len(self._schedule)):
            if now < self._start[phase]:
                break
            self.phase = phase
            if self._schedule[phase].is_flight:
                self._take_off()
                return True
            self.standing = self.standing & ~self._schedule.lifts(phase)
            self._seek(self._schedule.lands(phase), time)
        return False

    def find_contacts(self, measured: Measurement, com_velocity: Array, *, hit: bool) -> None:
        """Find the feet that have met the ground, as far as is measured.

        What is foreseen of the body, its feet do that the ground has stopped. `com_velocity`: (3,)
        m/s, measured. `hit`: whether something was hit, as the detector says; counts in flight, if
        with the feet.
        """
        if self.phase == 0:
            return
        time, v = measured.time, measured.v
        loaded = self._feet.update(measured.torque, v, com_velocity)
        self._light = np.where(loaded | ~self.standing, 0, self._light + 1)
        if self.flying:
            if hit and self._feet.met_ground():
                self._touch_down(time, loaded)
            return
        self.standing = self.standing | self._found(time, loaded, v)
        self._measure_ground()

    def _take_off(self) -> None:
        self._feet.reset()
        self.standing = np.zeros_like(self.standing)
        begin, end = self._start[self.phase : self.phase + 2] - self._plan_time + self._at
        self.flights.append(Flight(self.phase, float(begin), float(end)))

    def _touch_down(self, time: float, loaded: BoolArray) -> None:
        self.flights[-1].detected = time
        self.phase += 1
        self._plan_time, self._at = float(self._start[self.phase]) + JUST_AFTER, time
        # Something has been hit; where no leg is sure yet, it is the one that feels most.
        can = self.planned | (self._comes_from[self.phase] < np.inf)
        self.standing = loaded & can
        self.standing[int(np.argmax(np.where(can, self._feet.vertical, -np.inf)))] = True
        self._seek(self.planned, time)
        self._measure_ground()

    def _seek(self, feet: BoolArray, time: float) -> None:
        self._still = np.where(feet, 0, self._still)
        self._seeking_since = np.where(feet, time, self._seeking_since)

    def _found(self, time: float, loaded: BoolArray, v: Array) -> BoolArray:
        sinking = self._body.foot_jacobian[:, 2] @ v < -_STOPPED_BELOW
        self._still = np.where(sinking, 0, self._still + 1)
        stopped = (self._still >= _STILL_TICKS) & (time - self._seeking_since > _SEEKING_TIME)
        coming = self.plan_time(time) >= self._comes_from[self.phase]
        return (self.planned & (loaded | stopped)) | (coming & loaded)

    def _measure_ground(self) -> None:
        """By the feet that stand; the ground that the robot started from is the plan's."""
        if self.flights and self.standing.any():
            height = self._body.foot[:, 2] - self.foothold[:, 2]
            self.ground_shift = float(height[self.standing].mean())


def _together(plan: Plan, phase: int) -> tuple[int, int]:
    """[first, end) of the phases around one of them in which feet stand, without a flight."""
    flights = plan.schedule.flights
    first = max((flight + 1 for flight in flights if flight < phase), default=0)
    end = min((flight for flight in flights if flight >= phase), default=len(plan.schedule))
    return first, end


def _coming_from(plan: Plan, phase: int) -> Array:
    """(L,) s of the plan from which feet that swing in a phase may land before their time.

    Feet that a flight has lifted may at once, others once they are on the way back. Infinite where
    a foot stands, or does not land before the next flight.
    """
    stands, start = plan.schedule.stands, plan.phase_start
    first, end = _together(plan, phase)
    since = np.full(stands.shape[1], np.inf)
    for foot in range(stands.shape[1]):
        landing = next((p for p in range(phase, end) if stands[p, foot]), phase)
        if landing == phase:
            continue
        stood = [p for p in range(first, phase) if stands[p, foot]]
        since[foot] = -np.inf
        if stood:
            left = start[stood[-1] + 1]
            since[foot] = left + _LEFT * (start[landing] - left)
    return since


def _pushing_from(plan: Plan, phase: int) -> float:
    """S of the plan from which those that stand around a phase push towards the next flight."""
    first, end = _together(plan, phase)
    if first == 0:
        return -np.inf
    if end == len(plan.schedule):
        return np.inf
    return float(plan.phase_start[[first, end]].mean())
