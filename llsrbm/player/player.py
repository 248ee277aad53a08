"""`Player`: the loop: a reading, what could be wrong, a command; until the robot is damped."""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

from llsrbm.control.motor_command import MotorCommand
from llsrbm.control.readings import Readings
from llsrbm.player.play_log import PlayLog
from llsrbm.player.states import Check, Damp, State
from llsrbm.player.stops import (
    LINK_LOST,
    UNDER_WAY,
    LateReadings,
    MissedDeadlines,
    Moment,
    Stop,
    Tilt,
    TrackingError,
    UnresponsiveDrive,
    Unwell,
)
from llsrbm.player.tier import PERIOD, Tier
from llsrbm.wire.link import Link

_DISPLACED = "commands: another program commands the robot ({} heard)"
FIRST_READING = 2.0  # s until which a robot has to be heard: networks find each other in one


@dataclass(frozen=True)
class Ended:
    """How a play ended: `reason` in one line, "" if the plan was played to its end.

    `state`: in which it was, and `time`, s of the player's clock, when that was found; `damped`:
    whether the robot was; it is left alone where another program commands it.
    """

    reason: str
    state: str
    time: float
    damped: bool = True

    @property
    def line(self) -> str:
        """One line for a person."""
        if not self.reason:
            return "played to the end, then damped"
        then = "and damped" if self.damped else "and left alone"
        return f"stopped in {self.state} {then}: {self.reason}"


class Player:
    """Plays the plan of a tier, once.

    `clock`: s, that goes on while the link receives; `announce` is called with each state as it
    begins; `log`: all that was read and sent.
    """

    def __init__(
        self,
        tier: Tier,
        link: Link,
        clock: Callable[[], float],
        announce: Callable[[State], None] | None = None,
    ) -> None:
        self._tier, self._link, self._clock, self._announce = tier, link, clock, announce
        self._deadlines = MissedDeadlines()
        self._stops: tuple[Stop, ...] = (
            *(Tilt(), TrackingError(tier.robot), UnresponsiveDrive(tier.robot)),
            *(LateReadings(), self._deadlines, Unwell()),
        )
        self._sent: deque[MotorCommand] = deque(maxlen=UNDER_WAY)
        self._asked = ""
        self.log = PlayLog(tier.robot)

    def stop(self, reason: str) -> None:
        """Ask to stop with the next tick; from another thread or a signal's handler."""
        self._asked = self._asked or reason

    def run(self) -> Ended:
        """Play, and damp; returns when that is over."""
        ended = None
        try:
            ended = self._play()
            return ended
        finally:
            if ended is None or ended.damped:
                self._damp()

    def _play(self) -> Ended:
        state: State | None = None
        heard = self._clock()
        while True:
            readings, now = self._newest(), self._clock()
            self._deadlines.awake(now)
            if readings is None:
                reason = self._asked or _lost_link(state, now - heard)
                if reason:
                    return Ended(reason, state.name if state else Check.name, now)
                continue
            heard = now
            if state is None:
                state = self._begun(Check(self._tier, readings.time))
            if others := self._link.others():
                self.log.add(state.name, now, 0.0, readings, None, None)
                return Ended(_DISPLACED.format(others), state.name, now, damped=False)
            reason = self._asked or state.wrong(readings) or self._stopped(state, readings, now)
            if reason:
                self.log.add(state.name, now, 0.0, readings, None, None)
                return Ended(reason, state.name, now)
            if state.over(readings.time):
                following = state.following(readings.time)
                if isinstance(following, Damp):
                    return Ended("", state.name, now)
                state = self._begun(following)
            self._send(state, readings, now)

    def _newest(self) -> Readings | None:
        """The newest reading, within a period."""
        newest = self._link.receive(PERIOD)
        if newest is not None:
            while (more := self._link.receive(0.0)) is not None:
                newest = more
        return newest

    def _begun(self, state: State) -> State:
        if self._announce is not None:
            self._announce(state)
        return state

    def _stopped(self, state: State, readings: Readings, now: float) -> str:
        planned, sent = state.planned(readings), tuple(self._sent)
        moment = Moment(now, readings, planned, sent, self._link.health)
        reasons = [stop.find(moment) for stop in self._stops]  # each counts its own ticks
        return next(filter(None, reasons), "")

    def _send(self, state: State, readings: Readings, received: float) -> None:
        command = state.command(readings)
        if command is not None:
            self._link.send(command)
            self._sent.appendleft(command)
        now = self._clock()
        self._deadlines.sent(received, now)
        self.log.add(state.name, received, now - received, readings, command, self._tier.estimate)

    def _damp(self) -> None:
        state = Damp(self._tier, self._clock())
        self._begun(state)
        for _ in range(round(state.duration / PERIOD)):
            self._link.send(state.brake)
            readings = self._link.receive(PERIOD)
            if readings is not None:
                self.log.add(state.name, self._clock(), 0.0, readings, state.brake, None)


def _lost_link(state: State | None, silent: float) -> str:
    allowed = FIRST_READING if state is None else LINK_LOST
    if silent <= allowed:
        return ""
    if state is None:
        return f"lost link: nothing was heard of the robot in {silent:.1f} s"
    most = 1e3 * LINK_LOST
    return f"lost link: no reading for {1e3 * silent:.0f} ms, at most {most:.0f} are allowed"
