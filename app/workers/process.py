"""A computing process as the pool knows it: started, read by a thread, given jobs, stopped, killed.

Only `run` waits; it is called by a thread of the process' own.
"""

import contextlib
import ctypes
import logging
import multiprocessing
import signal
import threading
from collections.abc import Callable, Iterator
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess
from multiprocessing.reduction import ForkingPickler
from typing import Any

from app.workers import worker
from app.workers.reports import Message
from app.workers.tasks import Job, PlannerFactory

# Time to exit (s): of a process whose connection has closed, and of one that was killed.
EXIT_PATIENCE, KILL_PATIENCE = 3.0, 2.0

_log = logging.getLogger(__name__)


class Ended(Exception):  # no error where it was our order
    """A process has gone; the message is its exit status or signal, by which it was `killed`."""

    def __init__(self, how: str, *, killed: bool = False) -> None:
        super().__init__(how)
        self.killed = killed


class Process:
    """A process that computes; started again after it has ended."""

    id: int | None = None  # None while there is none
    # s until it is ready; it imports for 1 s, on a machine with no memory to spare for minutes
    start_patience = 300.0

    def __init__(self, factory: PlannerFactory, name: str) -> None:
        # A forked child would inherit the server's sockets and threads' locks.
        self._context = multiprocessing.get_context("spawn")
        self._factory, self._name = factory, name
        self._stop: Any = self._context.Value(ctypes.c_longlong, 0, lock=False)
        self._process: SpawnProcess | None = None
        self._connection: Connection | None = None
        self._writer: threading.Thread | None = None
        self._sending = threading.Lock()  # held until the writer has started

    def run(self) -> Iterator[Message]:
        """Start it and wait for messages, `Ready` first; raises `Ended` once it has gone."""
        # Ctrl-C reaches every process of the terminal; the server decides when this one ends.
        resource_tracker.ensure_running()  # as it begins it lets SIGINT through again
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})  # which the process inherits
        ours, theirs = self._context.Pipe()
        process = self._context.Process(
            target=worker.main,
            args=(theirs, self._stop, self._factory),
            name=self._name,
            daemon=True,
        )
        try:
            process.start()
        except OSError as error:
            ours.close()
            raise Ended(f"{error.strerror or error}") from error
        finally:
            theirs.close()  # only the child may hold its end, or its death would go unnoticed
        self._connection, self._process, self.id = ours, process, process.pid
        try:
            while True:
                yield ours.recv()
        except (EOFError, OSError):
            pass
        except Exception:  # noqa: BLE001  # half a message, or one that is none
            _log.exception("%s sent a message that cannot be read", self._name)
        finally:
            ended = self._end(process)
        raise ended

    def send(self, job: Job, failed: Callable[[Exception], None]) -> None:
        """Give it a job; returns at once, `failed` is called if the job cannot be sent."""
        # A process that does not read keeps nobody waiting but this thread, which ends with it.
        with self._sending:
            self._writer = threading.Thread(
                target=self._write,
                args=(self._connection, job, failed),
                name=f"{self._name}-writer",
                daemon=True,
            )
            self._writer.start()

    def _write(self, to: Connection, job: Job, failed: Callable[[Exception], None]) -> None:
        try:
            content = ForkingPickler.dumps(job)
        except Exception as error:  # noqa: BLE001  # whatever is wrong with it
            failed(error)
            return
        with contextlib.suppress(OSError):  # a process that has gone is noticed by reading
            to.send_bytes(content)

    def stop(self, number: int) -> None:
        """Have the job with this number stop; from any thread."""
        self._stop.value = number

    def kill(self) -> None:
        """Have `run` end; from any thread, returns at once."""
        process = self._process
        if process is not None:
            with contextlib.suppress(ValueError):  # closed meanwhile
                process.kill()

    def _end(self, process: SpawnProcess) -> Ended:
        """Wait until it has gone, and say how."""
        process.join(EXIT_PATIENCE)
        if process.is_alive():
            process.kill()
            process.join(KILL_PATIENCE)
        code = process.exitcode
        if code is None:
            how = "it cannot even be killed"  # the kernel holds it; it is left to itself
        else:
            how = f"signal {-code}" if code < 0 else f"exit status {code}"
        self._process = self.id = None
        # Closed only when no thread uses it any more: its number may be another file's soon.
        with self._sending:
            writer = self._writer
        if writer is not None:
            writer.join()
        if self._connection is not None:
            self._connection.close()
        return Ended(how, killed=code is not None and code < 0)
