"""Playing a clip: whoever moves the nodes, browser or server, answers to one interface."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Callable

from app.motion.clip import Clip
from app.viser_link.page_link import PageLink, PlayerMoved
from llsrbm.motion.timeline import Timeline

SPEEDS = ("0.1×", "0.25×", "0.5×", "1×")

_HOLD = 0.7  # s of rest at the end before a loop starts anew


class Player(ABC):
    """Plays one clip in one tab; to be used by one thread."""

    @abstractmethod
    def load(self, clip: Clip, events: Timeline) -> None:
        """Play this clip from now on; keeps the time and whether it plays."""

    @abstractmethod
    def clear(self) -> None:
        """Nothing to play."""

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


class BrowserPlayer(Player):
    """The page plays by itself: nothing is sent but clips and what the panel's buttons say.

    Time and state are what the page last told; it tells them when it is paused, started or moved.
    """

    def __init__(self, bridge: PageLink) -> None:
        """Nothing is loaded and nothing moves."""
        self._bridge = bridge
        self._clip: Clip | None = None
        self._playing = False
        self._time = 0.0

    def hear(self, event: PlayerMoved) -> None:
        """What the page told."""
        self._time, self._playing = event.time, event.playing

    def load(self, clip: Clip, events: Timeline) -> None:
        """See `Player.load`."""
        self._clip = clip
        self._bridge.load(clip, events)

    def clear(self) -> None:
        """See `Player.clear`."""
        self._clip = None
        self._playing = False
        self._bridge.clear()

    def play(self) -> None:
        """See `Player.play`."""
        if self._clip is not None:
            self._playing = True
            self._bridge.play()

    def pause(self) -> None:
        """See `Player.pause`."""
        self._playing = False
        self._bridge.pause()

    def seek(self, time: float) -> None:
        """See `Player.seek`."""
        self._time = time
        self._bridge.seek(time)

    def set_speed(self, speed: float) -> None:
        """See `Player.set_speed`."""
        self._bridge.set_speed(speed)

    def set_loop(self, loop: bool) -> None:
        """See `Player.set_loop`."""
        self._bridge.set_loop(loop)

    def step(self) -> None:
        """Nothing is ever due."""

    @property
    def wait(self) -> float | None:
        """See `Player.wait`."""
        return None

    @property
    def playing(self) -> bool:
        """See `Player.playing`."""
        return self._playing

    @property
    def time(self) -> float:
        """See `Player.time`."""
        return min(max(self._time, 0.0), 0.0 if self._clip is None else self._clip.end)


class ServerPlayer(Player):
    """The server sends every frame. Nothing is sent while it is paused."""

    def __init__(
        self,
        show: Callable[[Clip, float], None],
        frame_rate: Callable[[], float] = lambda: 60.0,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Nothing is loaded and nothing moves.

        Args:
            show: draws an instant, s, of a clip.
            frame_rate: how many frames a second to send at present.
            clock: s.
        """
        self._show = show
        self._frame_rate = frame_rate
        self._clock = clock
        self._clip: Clip | None = None
        self._speed = 1.0
        self._loop = True
        self._playing = False
        self._time = 0.0
        self._last = 0.0  # clock at the latest step
        self._due = 0.0  # clock at the next one

    def load(self, clip: Clip, events: Timeline) -> None:
        """See `Player.load`."""
        self._clip = clip
        self.seek(self._time)

    def clear(self) -> None:
        """See `Player.clear`."""
        self._clip = None
        self._playing = False

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
        if self._clip is not None:
            self._show(self._clip, self._time)

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
        if self._clip is not None:
            self._show(self._clip, self.time)

    @property
    def _duration(self) -> float:
        return 0.0 if self._clip is None else self._clip.end

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
