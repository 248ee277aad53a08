"""The connection to one computing process, read and written on threads of their own.

A process that stops in the middle of a message, or does not read the one that it is sent, keeps
nobody waiting but these threads; they end with the process.
"""

from __future__ import annotations

import logging
import queue
import threading
from dataclasses import dataclass
from multiprocessing.connection import Connection
from multiprocessing.reduction import ForkingPickler
from typing import Protocol

from app.workers.protocol import Job, Ready, Report

_log = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class Received:
    """A message of a process.

    Attributes:
        channel: that it came by; of a process of this machine, a `Channel`.
        message: None: the process has gone, or sends rubbish; nothing more will come.
    """

    channel: object
    message: Ready | Report | None


Inbox = queue.SimpleQueue[Received | None]
"""Where all channels put their messages; None only wakes the reader."""


class Sink(Protocol):
    """Takes messages from any thread."""

    def put(self, received: Received, /) -> None:
        """Keep it for its reader; returns at once."""
        ...


class Channel:
    """Our end of a connection."""

    def __init__(self, connection: Connection, inbox: Sink, name: str) -> None:
        """Begin to read.

        Args:
            connection: to the process; closed by this object once the process has gone.
            inbox: takes all that is read.
            name: of the process, for the names of the threads.
        """
        self._connection = connection
        self._inbox = inbox
        self._name = name
        self._sending: threading.Thread | None = None
        threading.Thread(target=self._read, name=f"{name}-reader", daemon=True).start()

    def send(self, job: Job) -> None:
        """Send a job to a process that has none; returns at once.

        A process that has gone is noticed by reading.

        Raises:
            Exception: the job cannot be pickled, whatever is wrong with it.
        """
        content = ForkingPickler.dumps(job)
        self._sending = threading.Thread(
            target=self._write, args=(content,), name=f"{self._name}-writer", daemon=True
        )
        self._sending.start()

    def _write(self, content: memoryview) -> None:
        try:
            self._connection.send_bytes(content)
        except OSError as error:
            _log.debug("%s takes no job: %s", self._name, error)

    def _read(self) -> None:
        try:
            while True:
                self._inbox.put(Received(self, self._connection.recv()))
        except (EOFError, OSError):
            pass
        except Exception:  # noqa: BLE001  # half a message, or one that is none
            _log.exception("%s sent a message that cannot be read", self._name)
        self._inbox.put(Received(self, None))
        # Closed only when no thread uses it any more: its number may be another file's soon.
        if self._sending is not None:
            self._sending.join()
        self._connection.close()
