"""The pool's own thread: the only one that starts, feeds and ends processes.

It waits for its inbox alone: processes are read and written by threads of `app.workers.channel`,
and one that ends is looked at now and then. An exception that nothing foresaw fails all jobs and
replaces all processes; a second one soon after ends the thread, and every request is refused from
then on.
"""

from __future__ import annotations

import queue
import time

from app.workers.channel import Inbox, Received
from app.workers.jobs import Jobs
from app.workers.member import SILENCE, PoolMember
from app.workers.process import EXIT_PATIENCE, Ended
from app.workers.scheduler import Entry

# Time between two looks at a process that is ending, s.
POLL_INTERVAL = 0.01
# A second unforeseen exception within this time of the first is a lasting defect, s: replacing the
# processes takes a second or two and did not help.
REPEATED_FAILURE = 10.0

DEFECT = "A defect of the server interrupted this; please try again."
BROKEN = "The server has a lasting defect and computes nothing any more; the terminal says more."


class Dispatcher:
    """Passes jobs to processes and takes their reports, until the pool closes; for one thread."""

    def __init__(self, jobs: Jobs, inbox: Inbox) -> None:
        """Nothing happens before `run`.

        Args:
            jobs: of the pool.
            inbox: all messages of processes; None wakes the thread.
        """
        self._jobs = jobs
        self._inbox = inbox
        self._failed_at: float | None = None  # when it met its last unforeseen exception

    def run(self) -> None:
        """Work until the pool closes."""
        try:
            while not self._jobs.closed:
                try:
                    self._hand_out()
                    self._start()
                    self._take_messages()
                    self._keep_deadlines()
                except Exception as error:  # noqa: BLE001  # the last resort: whatever it is
                    if not self._recover(error):
                        break
        finally:
            # No request is taken that nobody would work on, even if recovering went wrong.
            self._jobs.refusal = self._jobs.refusal or BROKEN
            self._end_all()

    def _hand_out(self) -> None:
        while True:
            with self._jobs.lock:
                turn = self._jobs.next()
                if turn is None:
                    break
                entry, member = turn
                member.begin(entry, time.monotonic())
            try:
                member.send(entry.job)
            except Exception as error:  # noqa: BLE001  # a task that cannot be pickled
                self._jobs.note("job %d cannot be sent", entry.job.number, error=error)
                with self._jobs.lock:
                    self._jobs.fail(member.finish(), DEFECT)
        with self._jobs.lock:
            done = self._jobs.background.take_done()
        if done is not None:
            self._jobs.put_aside(done)

    def _start(self) -> None:
        first = self._jobs.workers[0]
        more = len(self._jobs.turns) > 0 or self._jobs.background.wants_all_processes()
        for member in self._jobs.workers:
            if member.exists or not member.may_start or not member.process.startable:
                continue
            if not (more or member is first):
                continue
            try:
                member.start(time.monotonic())
            except OSError as error:
                self._jobs.note("a computing process cannot be started", error=error)
                how = f"{error.strerror or error}"
                self._does_not_start(member, Ended(how, unexpected=True))

    def _take_messages(self) -> None:
        due = self._next_deadline()
        timeout = None if due is None else max(0.0, due - time.monotonic())
        try:
            received = self._inbox.get(timeout=timeout)
        except queue.Empty:
            return
        while True:
            if received is not None:
                self._take(received)
            try:
                received = self._inbox.get_nowait()
            except queue.Empty:
                return

    def _take(self, received: Received) -> None:
        member = next(
            (m for m in self._jobs.workers if m.process.channel is received.channel), None
        )
        if member is None:
            return  # of a process that is ending
        if received.message is None:
            member.end(time.monotonic(), EXIT_PATIENCE, unexpected=True)
            return
        with self._jobs.lock:
            self._jobs.receive(member, received.message)

    def _next_deadline(self) -> float | None:
        with self._jobs.lock:
            due = []
            for member in self._jobs.workers:
                due += [at for at in (member.stop_at, member.end_at) if at is not None]
                if member.progress is not None:
                    due.append(member.notify_at)
                if member.process.ending:
                    due.append(time.monotonic() + POLL_INTERVAL)
                elif member.starting:
                    due.append(member.start_by)
                elif member.working_on is not None:
                    due.append(member.silent_by)
            due += [entry.notify_at for entry in self._jobs.turns]
        return min(due, default=None)

    def _keep_deadlines(self) -> None:
        now = time.monotonic()
        with self._jobs.lock:
            for member in self._jobs.workers:
                if member.working_on is not None:
                    self._keep_deadlines_of_job(member, member.working_on, now)
                if member.starting and now >= member.start_by:
                    self._jobs.note("a computing process was not ready in time")
                    member.end(now, unexpected=True)
            self._jobs.notify_waiting(now)
        for member in self._jobs.workers:
            ended = member.poll(now)
            if ended is not None and ended.unexpected:
                if member.was_ready:
                    self._died(member, ended)
                else:
                    self._does_not_start(member, ended)

    def _keep_deadlines_of_job(self, member: PoolMember, entry: Entry, now: float) -> None:
        self._jobs.report_progress(member, entry, now)
        if member.stop_at is not None and now >= member.stop_at:
            member.ask_to_stop()
            member.stop_at = None
        silent = now >= member.silent_by
        if silent or (member.end_at is not None and now >= member.end_at):
            stuck = f"It gave no sign of life for {SILENCE / 60:g} minutes and was stopped."
            self._jobs.fail(member.finish(), stuck)
            member.plan_to_restore(but=None)
            member.end(now)

    def _died(self, member: PoolMember, ended: Ended) -> None:
        """Fail its job; a new process takes its place, if there is a machine for it."""
        message = f"The computing process ended unexpectedly ({ended.how})"
        message += " and was restarted." if member.process.startable else "; please try again."
        if not ended.logged:
            self._jobs.note(message)
        with self._jobs.lock:
            entry = member.working_on
            in_background = self._jobs.background.owns(entry)
            member.plan_to_restore(but=entry.job.task if entry and in_background else None)
            self._jobs.fail(member.finish(), message)

    def _does_not_start(self, member: PoolMember, ended: Ended) -> None:
        """Not again before the next request, so that a lasting defect does not spin.

        If no process can start, all jobs that wait fail.
        """
        message = f"The computing process does not start ({ended.how}); the terminal says why."
        if not ended.logged:
            self._jobs.note(message)
        with self._jobs.lock:
            member.may_start = False
            member.todo.clear()
            if not any(other.exists for other in self._jobs.workers):
                for entry in self._jobs.turns.clear():
                    self._jobs.fail(entry, message)
                self._jobs.fail_warm_up(message)

    def _recover(self, error: Exception) -> bool:
        """Fail all jobs and replace all processes; False if that did not help the last time."""
        now = time.monotonic()
        repeated = self._failed_at is not None and now - self._failed_at < REPEATED_FAILURE
        self._failed_at = now
        self._jobs.note("a defect in the pool of computing processes", error=error)
        message = BROKEN if repeated else DEFECT
        with self._jobs.lock:
            if repeated:
                self._jobs.refusal = self._jobs.refusal or BROKEN
            self._jobs.fail_all(message)
            for member in self._jobs.workers:
                member.plan_to_restore(but=None)
                member.end(now)
            if repeated:
                self._jobs.fail_warm_up(message)
        return not repeated

    def _end_all(self) -> None:
        """Fail what tabs still wait for, and end every process."""
        with self._jobs.lock:
            for member in self._jobs.workers:
                if self._jobs.background.owns(member.working_on):
                    member.finish()  # no tab's, and no failure
            self._jobs.fail_all(self._jobs.refusal)
        for member in self._jobs.workers:
            member.end(time.monotonic())
        while any(member.process.ending for member in self._jobs.workers):
            time.sleep(POLL_INTERVAL)
            for member in self._jobs.workers:
                member.poll(time.monotonic())
