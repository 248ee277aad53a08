"""A process beside each Dask worker that computes its jumps.

A solve that hangs, or code that crashes, ends this process instead of the worker: the jump becomes
a row at once, and no other jump is lost with it.
"""

from __future__ import annotations

import multiprocessing
import signal
import threading
from collections.abc import Callable, Sequence
from multiprocessing.connection import Connection
from typing import Any

from threadpoolctl import threadpool_limits

from llsrbm.errors import Error
from llsrbm.sweep.jump import failed_rows, prepare, rows_of
from llsrbm.sweep.points import Point
from llsrbm.sweep.rows import FAILED, TIMED_OUT, Row
from llsrbm.sweep.spec import Spec

_ATTEMPTS = 3  # processes that may die of a jump: a machine short of memory kills one by chance

_lock = threading.Lock()  # CasADi is not safe to use from two threads
_running: _Process | None = None


class ProcessDied(Exception):
    """The process ended before it had an answer."""


class _Process:
    def __init__(self) -> None:
        # Dask's nanny starts workers as daemons, which may have no children. This one ends when
        # its connection to the worker does.
        multiprocessing.current_process().daemon = False
        context = multiprocessing.get_context("spawn")
        self._connection, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(theirs,), daemon=True)
        self._process.start()
        theirs.close()

    def call(self, function: Callable[..., Any], arguments: Any, limit: float | None) -> Any:
        try:
            self._connection.send((function, arguments))
            if not self._connection.poll(limit):
                raise TimeoutError
            return self._connection.recv()
        except (EOFError, ConnectionError) as error:
            self._process.join(1.0)
            raise ProcessDied(f"exit status {self._process.exitcode}") from error

    def end(self) -> None:
        self._process.kill()
        self._process.join()
        self._connection.close()


def run_jump(spec: Spec, point: Point, limit: float) -> list[Row]:
    """A jump's rows, computed within `limit` seconds or failed; called by Dask in a worker. Raises
    `Error`: this machine lacks the robot's file, or something else that all jumps need.
    """
    died = ""
    for _ in range(_ATTEMPTS):
        try:
            found: list[Row] = compute(rows_of, spec, point, limit=limit)
        except TimeoutError:
            return failed_rows(point, TIMED_OUT, f"no result within {limit:g} s")
        except ProcessDied as error:
            died = f"{_ATTEMPTS} processes died while they computed it ({error})"
        else:
            return found
    return failed_rows(point, FAILED, died)


def run_prepare(points: Sequence[Point]) -> None:
    """Fill this machine's cache; called by Dask in a worker."""
    compute(prepare, points, limit=None)


def compute(function: Callable[..., Any], *arguments: Any, limit: float | None) -> Any:
    """A function's result, computed in the worker's process within `limit` seconds.

    Raises `TimeoutError`: it takes longer; `ProcessDied`: the process ended; `Error`: the function
    raised something.
    """
    global _running  # one a worker
    with _lock:
        _running = _running or _Process()
        try:
            result = _running.call(function, arguments, limit)
        except (TimeoutError, ProcessDied):
            _running.end()
            _running = None
            raise
    if isinstance(result, Error):
        raise result
    return result


def _serve(connection: Connection) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # of the terminal: the command ends its workers
    with threadpool_limits(limits=1):  # a process a core: more threads would only wait
        while True:
            try:
                function, arguments = connection.recv()
                connection.send(_answer(function, arguments))
            except (EOFError, ConnectionError):
                return


def _answer(function: Callable[..., Any], arguments: Any) -> Any:
    try:
        return function(*arguments)
    except Exception as error:  # noqa: BLE001  # as text: not every exception can be sent
        return Error(f"{type(error).__name__}: {error}")
