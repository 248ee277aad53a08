"""Playing a motion: a clock that says which instant to show, and when the next one is due."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Callable

SPEEDS = ("0.1×", "0.25×", "0.5×", "1×")

_HOLD = 0.7  # s of rest at the end before a loop starts anew


class Player(ABC):
    """Plays one motion in one tab. Whoever moves the frames, server or browser, answers to this."""

    @abstractmethod
    def load(self, duration: float) -> None:
        """Play a motion of this length, s, from now on; keeps the time and whether it plays."""

    @abstractmethod
    def play(self) -> None:
        """Go on, from the start if at the end."""

    @abstractmethod
    def pause(self) -> None:
        """Stop where it is."""

    @abstractmethod
    def seek(self, time: float) -> None:
        """Go to an instant, s."""

    @abstractmethod
    def set_speed(self, speed: float) -> None:
        """Seconds of motion a second."""

    @abstractmethod
    def set_loop(self, loop: bool) -> None:
        """Whether to start again at the end."""

    @abstractmethod
    def step(self) -> None:
        """Do what is due; called by the session when `wait` has passed."""

    @property
    @abstractmethod
    def wait(self) -> float | None:
        """Seconds until `step` is due, or None when nothing moves."""

    @property
    @abstractmethod
    def playing(self) -> bool:
        """Whether it moves."""

    @property
    @abstractmethod
    def time(self) -> float:
        """The instant that is shown, s."""


class ServerPlayer(Player):
    """The server sends every frame. Nothing is sent while it is paused."""

    def __init__(
        self,
        show: Callable[[float], None],
        frame_rate: Callable[[], float] = lambda: 60.0,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Nothing is loaded and nothing moves.

        Args:
            show: draws an instant, s.
            frame_rate: how many frames a second to send at present.
            clock: s.
        """
        self._show = show
        self._frame_rate = frame_rate
        self._clock = clock
        self._duration = 0.0
        self._speed = 1.0
        self._loop = True
        self._playing = False
        self._time = 0.0
        self._last = 0.0  # clock at the latest step
        self._due = 0.0  # clock at the next one

    def load(self, duration: float) -> None:
        """See `Player.load`."""
        self._duration = duration
        self.seek(self._time)

    def play(self) -> None:
        """See `Player.play`."""
        if not self._playing and self._duration > 0:
            if self._time >= self._duration:
                self._time = 0.0
            self._playing = True
            self._last = self._due = self._clock()

    def pause(self) -> None:
        """See `Player.pause`."""
        self._playing = False
        self._time = min(self._time, self._duration)

    def seek(self, time: float) -> None:
        """See `Player.seek`."""
        self._time = min(max(time, 0.0), self._duration)
        self._show(self._time)

    def set_speed(self, speed: float) -> None:
        """See `Player.set_speed`."""
        self._speed = speed

    def set_loop(self, loop: bool) -> None:
        """See `Player.set_loop`."""
        self._loop = loop

    def step(self) -> None:
        """See `Player.step`."""
        now = self._clock()
        if not self._playing or now < self._due:
            return
        self._time += (now - self._last) * self._speed
        self._last = now
        # A late step does not make the next ones crowd together.
        self._due = max(self._due + 1 / self._frame_rate(), now)
        if self._time >= self._duration:
            if not self._loop:
                self.pause()
            elif self._time >= self._duration + _HOLD * self._speed:
                self._time = 0.0
        self._show(self.time)

    @property
    def wait(self) -> float | None:
        """See `Player.wait`."""
        return max(0.0, self._due - self._clock()) if self._playing else None

    @property
    def playing(self) -> bool:
        """See `Player.playing`."""
        return self._playing

    @property
    def time(self) -> float:
        """See `Player.time`."""
        return min(self._time, self._duration)
