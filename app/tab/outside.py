"""Effects carried out: on the pool, the page and the browser, outside of a session's state."""

from __future__ import annotations

from functools import partial

import viser

from app.link import PageLink
from app.panel.notes import Notes
from app.tab.effects import (
    After,
    Download,
    Effect,
    Keep,
    LoadRobot,
    Notify,
    Pause,
    Play,
    ResetControls,
    Seek,
    SetPlayback,
    Share,
    Stop,
    Submit,
)
from app.tab.events import Reported, RobotLoaded, RobotMissing
from app.tab.inbox import Inbox
from app.tab.lanes import Lane
from app.workers.pool import WorkerPool
from app.workers.protocol import Report
from llsrbm.errors import Error
from llsrbm.look.visuals import needs_preparation
from llsrbm.request.design import dump_design
from llsrbm.robots import load_robot


class Outside:
    """One tab's; for the session's thread. What comes of an effect is put into the inbox.

    Attributes:
        link: to the scripts in the tab's page.
    """

    def __init__(
        self, client: viser.ClientHandle, pool: WorkerPool, link: PageLink, inbox: Inbox
    ) -> None:
        """Do nothing yet.

        Args:
            client: the tab.
            pool: computes.
            link: to its page.
            inbox: takes what comes back.
        """
        self._client = client
        self._pool = pool
        self._inbox = inbox
        self._notes = Notes(client)
        self.link = link

    def carry_out(self, effect: Effect) -> None:
        """Do what an effect says, but for `ResetControls`, which is the drawing's."""
        match effect:
            case Submit(lane, ticket, task):
                listener = partial(self._report, lane, ticket)
                self._pool.submit((self._client.client_id, lane), task, listener)
            case Stop(lane):
                self._pool.cancel((self._client.client_id, lane))
            case LoadRobot(name):
                self._inbox.put(loaded(name))
            case After(seconds, event):
                self._inbox.put_later(seconds, event)
            case Keep(design):
                self.link.keep(dump_design(design))
            case Share(design):
                self.link.share(dump_design(design))
            case Download(name, content):
                self._client.send_file_download(name, content, save_immediately=True)
            case Notify(title, body):
                self._notes.show(title, body)
            case Play():
                self.link.play()
            case Pause():
                self.link.pause()
            case SetPlayback(speed, loop):
                self.link.set_playback(speed, loop)
            case Seek(instant):
                self.link.seek(instant)
            case ResetControls():
                raise AssertionError("controls are put back where they are drawn")

    def give_up(self) -> None:
        """Have the pool forget all of the tab's jobs."""
        for lane in Lane:
            self._pool.forget((self._client.client_id, lane))

    def _report(self, lane: Lane, ticket: int, report: Report) -> None:
        self._inbox.put(Reported(lane, ticket, report))


def loaded(name: str) -> RobotLoaded | RobotMissing:
    """A robot that was prepared, or why it cannot be loaded."""
    try:
        robot = load_robot(name)
        return RobotLoaded(robot, prepared=not needs_preparation(robot))
    except Error as error:
        return RobotMissing(name, str(error))
