"""Effects: what has to be done for an event outside of the state, as values that can be compared.

`Outside` is where a tab's session has them carried out.
"""

from dataclasses import dataclass
from enum import Enum
from functools import partial
from typing import Any

import viser

from app import gallery
from app.link import PageLink
from app.panel.help import terms, topics
from app.tab.inbox import Inbox
from app.workers.pool import WorkerPool
from app.workers.reports import Report
from app.workers.tasks import Task
from llsrbm.errors import Error
from llsrbm.look.visuals import needs_preparation
from llsrbm.request.design import Design, dump_design
from llsrbm.request.tuning import Tuning
from llsrbm.robots import Robot, load_robot

MOST_NOTES = 4  # That stand at a time; more would cover the picture


class Queue(Enum):
    """A tab's queues in the pool: jobs of one replace each other, and do not wait for others."""

    MOTION = "motion"
    ROBOT = "robot"
    OPEN = "open"
    SAVE = "save"
    CHECK = "check"
    COMPARE = "compare"
    LARGEST = "largest"
    BEGINNING = "beginning"


MOST_LANES = 4
"""Most lanes of a queue: a job of one replaces those of its own, and runs beside the others."""


# ---- events that come of effects


@dataclass(frozen=True, eq=False)
class RobotLoaded:
    """A robot can be drawn, by its meshes if it is prepared, else by its collision shapes."""

    robot: Robot
    prepared: bool = True


@dataclass(frozen=True)
class RobotMissing:
    """The robot of this name cannot be drawn, and why not."""

    robot: str
    message: str


# ---- the outside


class Outside:
    """One tab's pool, page and browser; for the session's thread."""

    def __init__(
        self, client: viser.ClientHandle, pool: WorkerPool, link: PageLink, inbox: Inbox
    ) -> None:
        self.client, self.pool, self.link, self.inbox = client, pool, link, inbox
        self.has_gallery = False  # the page has the examples' pictures
        self._notes: dict[tuple[str, str], viser.NotificationHandle] = {}  # the oldest first

    def name(self, queue: Queue, lane: int = 0) -> tuple[int, Queue, int]:
        """Name of a lane of a queue of this tab."""
        return self.client.client_id, queue, lane

    def forget(self, queue: Queue) -> None:
        """Have the pool forget all of a queue's jobs."""
        for lane in range(MOST_LANES):
            self.pool.forget(self.name(queue, lane))

    def note(self, title: str, body: str) -> None:
        """Show a note until it is closed, in place of the one on the same control or file."""
        alike = title, body.partition(": ")[0]
        while len(self._notes) >= MOST_NOTES or alike in self._notes:
            self._notes.pop(alike if alike in self._notes else next(iter(self._notes))).remove()
        self._notes[alike] = self.client.add_notification(title, body, color="orange")


class Effect:
    """Something to be done outside of the state."""

    after_drawing = False  # it means what the page shows then, not what it showed before

    def do(self, outside: Outside) -> None:
        """Carry it out."""
        raise NotImplementedError


@dataclass(frozen=True)
class ShowPart(Effect):
    """Show what a part of the robot does, made by `app.plots.readings`."""

    reading: dict[str, Any]

    def do(self, outside: Outside) -> None:
        outside.link.call("parts.show", self.reading)


@dataclass(frozen=True, eq=False)
class Submit(Effect):
    """Have the pool compute something, in place of the queue's waiting job: see `Reported`."""

    queue: Queue  # which
    ticket: int  # by which the state knows the job
    task: Task  # its work
    lane: int = 0  # of the queue; jobs of different ones run side by side

    def do(self, outside: Outside) -> None:
        listener = partial(_report, outside.inbox, self)
        outside.pool.submit(outside.name(self.queue, self.lane), self.task, listener)


@dataclass(frozen=True, eq=False)
class Reported:
    """A job has something to report."""

    job: Submit
    report: Report  # the pool's

    @property
    def ticket(self) -> int:
        """The number by which the state knows the job."""
        return self.job.ticket


def _report(inbox: Inbox, job: Submit, report: Report) -> None:
    inbox.put(Reported(job, report))


@dataclass(frozen=True)
class Stop(Effect):
    """Have the pool give up a queue's jobs, waiting and running."""

    queue: Queue

    def do(self, outside: Outside) -> None:
        outside.pool.cancel(outside.name(self.queue))


@dataclass(frozen=True)
class Forget(Effect):
    """Have the pool give up a queue's jobs without a report, once a solver under way is built."""

    queue: Queue

    def do(self, outside: Outside) -> None:
        outside.forget(self.queue)


@dataclass(frozen=True)
class LoadRobot(Effect):
    """Load a robot that was prepared: `RobotLoaded` or `RobotMissing` comes of it."""

    name: str

    def do(self, outside: Outside) -> None:
        outside.inbox.put(loaded(self.name))


@dataclass(frozen=True, eq=False)
class After(Effect):
    """Have an event happen later (s), in place of the one that was to happen later before."""

    seconds: float
    event: Any

    def do(self, outside: Outside) -> None:
        outside.inbox.put_later(self.seconds, self.event)


@dataclass(frozen=True)
class Keep(Effect):
    """Have the browser keep a design, for a tab without a state."""

    design: Design

    def do(self, outside: Outside) -> None:
        outside.link.call("page.keep", dump_design(self.design))


@dataclass(frozen=True)
class Download(Effect):
    """Send a file."""

    name: str
    content: bytes

    def do(self, outside: Outside) -> None:
        outside.client.send_file_download(self.name, self.content, save_immediately=True)


@dataclass(frozen=True)
class Notify(Effect):
    """Show a note that stays until it is closed: a title, and a sentence."""

    title: str
    body: str

    def do(self, outside: Outside) -> None:
        outside.note(self.title, self.body)


@dataclass(frozen=True)
class ShowTuning(Effect):
    """Show the numbers of a design in the page's table, whatever was typed there."""

    tuning: Tuning

    def do(self, outside: Outside) -> None:
        outside.link.call("tuning.show", self.tuning)


@dataclass(frozen=True)
class Share(Effect):
    """Show a link that opens a design, and put it where a visitor pastes from."""

    design: Design
    after_drawing = True

    def do(self, outside: Outside) -> None:
        outside.link.call("page.share", dump_design(self.design))


@dataclass(frozen=True)
class ShowGallery(Effect):
    """Show the examples, and the motions of the library; their pictures are sent once."""

    shown: bool = True  # rather than only sent

    def do(self, outside: Outside) -> None:
        if not outside.has_gallery:
            outside.has_gallery = True
            outside.link.call("gallery.fill", gallery.cards(), gallery.motions())
        if self.shown:
            outside.link.call("gallery.open")


@dataclass(frozen=True)
class SendFigures(Effect):
    """Send the stick figures of these motions of the library, of those that have one."""

    names: tuple[str, ...]

    def do(self, outside: Outside) -> None:
        outside.link.call("gallery.animate", gallery.stick_figures(self.names))


@dataclass(frozen=True)
class ShowHelp(Effect):
    """Show topics and terms."""

    def do(self, outside: Outside) -> None:
        outside.link.call("help.open", topics(), terms())


@dataclass(frozen=True)
class ShowExports(Effect):
    """Show the formats in which a motion can be written: purpose -> a table a format."""

    motion: str  # its title
    groups: dict[str, list[dict[str, str]]]

    def do(self, outside: Outside) -> None:
        outside.link.call("exports.open", self.motion, list(self.groups.items()))


@dataclass(frozen=True)
class Play(Effect):
    """Go on, from the start if at the end."""

    after_drawing = True

    def do(self, outside: Outside) -> None:
        outside.link.call("player.play")


@dataclass(frozen=True)
class Pause(Effect):
    """Stand still."""

    after_drawing = True

    def do(self, outside: Outside) -> None:
        outside.link.call("player.pause")


@dataclass(frozen=True)
class Seek(Effect):
    """Go to an instant, s."""

    time: float
    after_drawing = True

    def do(self, outside: Outside) -> None:
        outside.link.call("player.seek", self.time)


@dataclass(frozen=True)
class SetPlayback(Effect):
    """Play so many seconds of motion a second, and start again at the end or not."""

    speed: float
    loop: bool
    after_drawing = True

    def do(self, outside: Outside) -> None:
        outside.link.call("player.setSpeed", self.speed)
        outside.link.call("player.setLoop", self.loop)


def loaded(name: str) -> RobotLoaded | RobotMissing:
    """A robot that was prepared, or why it cannot be loaded."""
    try:
        robot = load_robot(name)
        return RobotLoaded(robot, prepared=not needs_preparation(robot))
    except Error as error:
        return RobotMissing(name, str(error))
