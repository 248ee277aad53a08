"""Effects: what `app.tab.outside` has to do for an event outside of the state, as values."""

from __future__ import annotations

from dataclasses import dataclass

from app.tab.events import Event
from app.tab.lanes import Lane
from app.workers.task import Task
from llsrbm.request.design import Design


@dataclass(frozen=True, eq=False)
class Submit:
    """Have the pool compute something; it comes back as `Reported`.

    Attributes:
        lane: in which, in place of the job that waits there.
        ticket: by which the state knows the job.
        task: what.
    """

    lane: Lane
    ticket: int
    task: Task


@dataclass(frozen=True)
class Stop:
    """Have the pool give up what waits and runs in a lane."""

    lane: Lane


@dataclass(frozen=True)
class LoadRobot:
    """Load a robot that was prepared; it comes back as `RobotLoaded` or `RobotMissing`."""

    name: str


@dataclass(frozen=True, eq=False)
class After:
    """Have an event happen later, in place of the one that was to happen later before.

    Attributes:
        seconds: from now.
        event: which.
    """

    seconds: float
    event: Event


@dataclass(frozen=True)
class Keep:
    """Have the browser keep a design, for a tab without a state."""

    design: Design


@dataclass(frozen=True)
class Download:
    """Send a file.

    Attributes:
        name: of the file.
        content: of the file.
    """

    name: str
    content: bytes


@dataclass(frozen=True)
class Share:
    """Show a link that opens a design, and put it where a visitor pastes from."""

    design: Design


@dataclass(frozen=True)
class Notify:
    """Show a note that stays until it is closed.

    Attributes:
        title: in some words.
        body: in a sentence.
    """

    title: str
    body: str


@dataclass(frozen=True)
class ResetControls:
    """Put the controls where the state has them: what was entered had to be corrected."""


@dataclass(frozen=True)
class Play:
    """Go on, from the start if at the end."""


@dataclass(frozen=True)
class Pause:
    """Stand still."""


@dataclass(frozen=True)
class Seek:
    """Go to an instant.

    Attributes:
        time: s.
    """

    time: float


@dataclass(frozen=True)
class SetPlayback:
    """Play at another speed.

    Attributes:
        speed: seconds of motion a second.
        loop: start again at the end.
    """

    speed: float
    loop: bool


Effect = (
    Submit
    | Stop
    | LoadRobot
    | After
    | Keep
    | Download
    | Share
    | Notify
    | ResetControls
    | Play
    | Pause
    | Seek
    | SetPlayback
)

AFTER_DRAWING = (Share, Play, Pause, Seek, SetPlayback)
"""Effects on the page that mean what it shows then, not what it showed before."""
