"""The pool of computing processes, as tabs see it: submit, cancel, forget.

The order of jobs is decided in `app.workers.waiting`. A plan that is running when its tab requests
something newer may finish if it is a quick one, because that is shorter than one notices; if it
takes longer it is stopped. A simulation or a search is stopped at once: it is no longer wanted.

All state is changed under one lock, which is never held for long. Each process has a thread, which
starts it and reads its messages; one more, the clock, keeps deadlines. Listeners are called
outside the lock, by two threads, in the order in which the reports came about: one calls those of
tabs; the other calls the warm-up's and writes the log, whose terminal may not be read by anybody.
"""

import itertools
import logging
import threading
import time
from collections.abc import Callable, Hashable, Sequence
from dataclasses import replace
from functools import partial

from app.workers import reports, worker
from app.workers.crew import PROCESSES, Crew
from app.workers.deliveries import Deliveries
from app.workers.member import SILENCE, Entry, Member
from app.workers.process import Ended
from app.workers.refusals import BROKEN, BUSY, CLOSED, DEFECT, LATE, SILENT
from app.workers.seeds import Seeds
from app.workers.tasks import PlanJump, PlannerFactory, Prepare, SimulateJump, SimulateSeeds, Task
from app.workers.waiting import AGAIN, Waiting
from llsrbm.errors import InputError

# How long a cancelled job may go on before its process is killed, s: the rest of the 0.2 s that
# cancelling may take is for that.
CANCEL_GRACE = 0.15
# How long a patient plan may go on when its tab wants something newer, s: longer than most take.
SUPERSEDED_GRACE = 0.3
# How long the job of a tab that has gone may go on, s: a solver that is being built (of G1 half a
# minute) will be of use, a hung one never.
FORGOTTEN_GRACE = 60.0
CLOSE_PATIENCE = 5.0  # s that closing may take
_DRAIN = 1.0  # s for reports that are under way when the pool closes
# A second unforeseen exception within this time of the first is a lasting defect, s: replacing the
# processes takes a second or two and did not help.
REPEATED_FAILURE = 10.0
PROGRESS_INTERVAL = 0.1  # least time between two pieces of progress of a job, s
# A tab that waits gets to know the reason after this time and then again and again, s.
WAITING_INTERVAL = 0.5

_log = logging.getLogger(__name__)


class WorkerPool:
    """Owns the computing processes and passes them the jobs of all tabs.

    A listener gets its job's reports in order, nothing after the outcome, from a thread of the
    pool's; it must return at once.
    """

    def __init__(
        self,
        factory: PlannerFactory = worker.LibraryPlanner,  # makes the planner inside a process
        *,
        # how many; with more than one, the last takes nothing that lasts seconds
        processes: int = PROCESSES,
    ) -> None:
        self.planner = f"{factory.__module__}.{factory.__qualname__}"  # name of the planner
        self._lock = threading.RLock()
        self._changed = threading.Condition(self._lock)
        self._waiting = Waiting()
        self._numbers = itertools.count(1)
        self._refusal = ""  # the answer to all requests; "" as long as they are taken
        self._failed_at: float | None = None  # time of the last unforeseen exception
        self._warm_up_listener: reports.Listener = _ignore
        self._warm_up_done: Callable[[], None] | None = None
        self._reports, self._asides = Deliveries("reports"), Deliveries("asides")
        self._crew = Crew(factory, processes, self._lock, self._receive, self._ended, self._recover)
        self._members = self._crew.members
        self._crew.start_thread(self._keep_time, "worker-pool-clock")
        with self._lock:
            self._hand_out()

    # ---- called by tabs, from any thread

    def submit(self, tab: Hashable, task: Task, listener: reports.Listener) -> int:
        """Queue a task in place of the tab's waiting one; the job's number, larger than all before.

        The replaced one gets no report; a running one still does. A request that cannot be taken,
        because too many wait or the pool has ended, is answered with `Failed` before this returns.
        """
        now = time.monotonic()
        with self._lock:
            number = next(self._numbers)
            refusal = self._refusal or (BUSY if self._waiting.is_full_for(tab) else "")
            try:
                batch = Seeds(number, task) if isinstance(task, SimulateSeeds) else None
            except InputError as error:
                refusal = refusal or str(error)
            if not refusal:
                entry = Entry(tab, number, task, listener, now + WAITING_INTERVAL, batch=batch)
                self._waiting.put(entry)
                for member in self._members:
                    member.may_start = member.may_start or not member.spare
                    if member.working_on is not None and member.working_on.tab == tab:
                        member.supersede(task, now, SUPERSEDED_GRACE)
                self._hand_out()
        if refusal:
            listener(reports.Failed(number, refusal))
        return number

    def cancel(self, tab: Hashable) -> None:
        """Give up the tab's jobs, waiting and running; each is `Cancelled` at once."""
        with self._lock:
            for entry in self._give_up(tab, CANCEL_GRACE):
                self._report(entry, reports.Cancelled(entry.number))

    def forget(self, tab: Hashable) -> None:
        """Give up the tab's jobs without a report: the tab has gone."""
        with self._lock:
            for entry in self._give_up(tab, FORGOTTEN_GRACE):
                entry.listener, entry.over = _ignore, True  # for reports that are under way

    def warm_up(
        self,
        tasks: Sequence[Prepare | PlanJump],
        listener: reports.Listener,
        done: Callable[[], None],
    ) -> None:
        """Have every process load what is likely to be requested; called once.

        Robots are prepared by the first process only, as that is for all. `listener` gets its
        reports, `done` is called when it is through; both may take their time.
        """
        with self._lock:
            self._warm_up_listener, self._warm_up_done = listener, done
            self._crew.load(tasks)
            self._hand_out()

    def close(self) -> None:
        """End the processes and this object's threads, within `CLOSE_PATIENCE` or little more."""
        with self._lock:
            self._stop_all(CLOSED)
        self._crew.join(time.monotonic() + CLOSE_PATIENCE)
        self._reports.close(_DRAIN)
        self._asides.close(_DRAIN)

    @property
    def process_ids(self) -> tuple[int | None, ...]:
        """Id of each computing process, None while there is none; the reserved one is the last."""
        return self._crew.process_ids

    # ---- the clock's thread

    def _keep_time(self) -> None:
        with self._changed:
            while not self._refusal:
                try:
                    due = self._keep_deadlines(time.monotonic())
                except Exception as error:  # noqa: BLE001  # the last resort: whatever it is
                    due = None
                    self._recover(error)
                self._changed.wait(None if due is None else max(0.0, due - time.monotonic()))

    # ---- under the lock

    def _receive(self, member: Member, message: reports.Message) -> None:
        if isinstance(message, reports.Ready):
            member.ready, member.killed_starting = not member.ending, False
            self._hand_out()
            return
        if isinstance(message, reports.Heavy):
            member.heavy = not member.spare
            return
        entry, task = member.working_on, member.task
        if entry is None or task is None or entry.number != message.job or member.ending:
            return
        now = time.monotonic()
        member.silent_by = now + SILENCE
        if isinstance(message, reports.Progress):
            member.activity, member.progress = message.text, message
            self._report_progress(member, entry, now)
            return
        if isinstance(message, reports.SimulatedSoFar):
            self._report(entry, message, task)
            return
        member.finish()
        if not isinstance(message, reports.Cancelled):
            self._waiting.note_done(task)
        if isinstance(message, reports.Planned) and isinstance(task, PlanJump):
            member.note_loaded(replace(task, near=None))
        self._report(entry, message, task)
        self._cancel_remains(entry)
        self._hand_out()

    def _ended(self, member: Member, how: Ended) -> None:
        """A process has gone: another one takes its place and, if it was killed, its job."""
        was_ready, expected = member.ready, member.ending
        member.running = member.ready = member.ending = member.heavy = False
        if self._refusal:
            return
        entry, task = member.working_on, member.task
        left = member.finish()
        if member.spare:
            self._crew.retire(member)
        elif was_ready or expected:
            loading = entry is not None and entry.tab is self
            member.plan_to_restore(but=task if loading else None)
            message = f"The computing process ended unexpectedly ({how}) and was restarted."
            if not expected:
                self._note(message)
            again = how.killed and not member.stopping
            if left is not None and not (again and self._begin_again(left, task)):
                self._report(left, reports.Failed(left.number, message))
        elif how.killed and not member.killed_starting:
            self._note("a computing process was killed as it started (%s)", how)
            member.killed_starting = True
        else:
            # Not again before the next request, so that a lasting defect does not spin.
            message = f"The computing process does not start ({how}); the terminal says why."
            self._note(message)
            member.may_start = False
            member.todo.clear()
            if not any(other.running for other in self._members):
                self._fail_all(message)
        self._hand_out()

    def _begin_again(self, entry: Entry, task: Task | None) -> bool:
        """Have a job wait once more, for the machine may have been short of memory for a moment.

        Not if its tab wants something newer, nor a file, which may be what takes the memory.
        """
        if task is None or entry.begun_again or task.one_at_a_time or entry.tab is self:
            return False
        if self._waiting.replaced(entry, self._members):
            return False
        entry.begun_again = True
        entry.parts.appendleft(task)
        entry.notify_at = time.monotonic() + WAITING_INTERVAL
        self._waiting.put(entry)
        text = f"waiting: {AGAIN}"
        self._report(entry, reports.Progress(entry.number, text, waiting=True))
        return True

    def _cancel_remains(self, entry: Entry) -> None:
        running = any(member.working_on is entry for member in self._members)
        if not (entry.over or running or self._waiting.get(entry.tab) is entry):
            self._report(entry, reports.Cancelled(entry.number))

    def _keep_deadlines(self, now: float) -> float | None:
        """Do what is due; when something will be, s."""
        for member in self._members:
            if member.working_on is not None and not member.ending:
                self._keep_deadlines_of_job(member, member.working_on, now)
            elif member.starting and now >= member.start_by:
                self._note("a computing process was not ready in time")
                member.killed_starting = True  # by us
                member.process.kill()
                member.start_by = now + member.process.start_patience
        self._notify_waiting(now)
        due = [at for member in self._members for at in member.deadlines]
        return min([*due, *(entry.notify_at for entry in self._waiting)], default=None)

    def _keep_deadlines_of_job(self, member: Member, entry: Entry, now: float) -> None:
        self._report_progress(member, entry, now)
        if member.stop_at is not None and now >= member.stop_at:
            member.request_stop()
            member.stop_at = None
            self._hand_out()  # what its tab wants instead
        late = member.end_at is not None and now >= member.end_at
        if late or now >= member.silent_by:
            limit = member.task.limit if member.task is not None else None
            message = LATE.format(limit=limit) if late and limit else SILENT
            self._report(entry, reports.Failed(entry.number, message))
            member.finish()
            member.plan_to_restore(but=None)
            member.kill()

    def _report_progress(self, member: Member, entry: Entry, now: float) -> None:
        if member.progress is not None and now >= member.notify_at:
            self._report(entry, member.progress, member.task)
            member.progress, member.notify_at = None, now + PROGRESS_INTERVAL
        elif member.progress is not None:
            self._changed.notify_all()

    def _notify_waiting(self, now: float) -> None:
        for entry in self._waiting:
            if now < entry.notify_at:
                continue
            entry.notify_at = now + WAITING_INTERVAL
            if any(member.working_on is entry for member in self._members):
                continue  # some of its parts run
            text = f"waiting: {self._waiting.awaited(entry, self._members)}"
            self._report(entry, reports.Progress(entry.number, text, waiting=True))

    def _hand_out(self) -> None:
        """Give jobs to the processes that can take them, a tab's first, then the warm-up's."""
        try:
            while (turn := self._waiting.next(self._members) or self._next_to_load()) is not None:
                entry, task, member = turn
                job = member.begin(entry, task, time.monotonic())
                member.process.send(job, partial(self._unsendable, member, entry))
            self._crew.renew()
            if not self._refusal:
                self._crew.start(at_once=len(self._waiting) > 0)
            if self._warm_up_done is not None and self._crew.first_is_through:
                self._asides.put(self._warm_up_done)
                self._warm_up_done = None
        except Exception as error:  # noqa: BLE001  # the last resort: whatever it is
            self._recover(error)
        self._changed.notify_all()

    def _next_to_load(self) -> tuple[Entry, Task, Member] | None:
        """A process with time, and a task of its `todo`."""
        if (turn := self._waiting.next_to_load(self, self._members)) is None:
            return None
        task, member = turn
        heard = self._warm_up_done is not None and member is self._crew.first
        listener = self._warm_up_listener if heard else _ignore
        return Entry(self, next(self._numbers), task, listener), task, member

    def _give_up(self, tab: Hashable, grace: float) -> list[Entry]:
        """Withdraw the tab's jobs, in order; running ones end within `grace`, s."""
        waiting = self._waiting.withdraw(tab)
        entries = {} if waiting is None else {waiting.number: waiting}
        for member in self._members:
            entry = member.working_on
            if entry is not None and entry.tab == tab and not entry.over:
                entries[entry.number] = entry
                member.request_stop()
                member.end_at = time.monotonic() + grace
        self._hand_out()
        return [entries[number] for number in sorted(entries)]

    def _report(self, entry: Entry, report: reports.Report, task: Task | None = None) -> None:
        """Have the listener called, soon, with a report on a job or on its part; in order."""
        passed_on = [report]
        if entry.batch is not None and isinstance(task, SimulateJump):
            passed_on = entry.batch.take(task, report)
        for each in passed_on:
            if entry.over:
                return
            if not isinstance(each, reports.Partial):
                entry.over = True
                self._stop_parts(entry)
            calls = self._asides if entry.tab is self else self._reports
            calls.put(partial(entry.deliver, each))

    def _stop_parts(self, entry: Entry) -> None:
        if entry.parts and self._waiting.get(entry.tab) is entry:
            self._waiting.withdraw(entry.tab)
        for member in self._members:
            if member.working_on is entry and not member.stopping:
                member.request_stop()
                member.end_at = time.monotonic() + CANCEL_GRACE

    def _fail_all(self, message: str) -> None:
        for entry in self._waiting.clear():
            self._report(entry, reports.Failed(entry.number, message))
        for member in self._members:
            left = member.finish()
            if left is not None and left.tab is not self:
                self._report(left, reports.Failed(left.number, message))

    def _unsendable(self, member: Member, entry: Entry, error: Exception) -> None:
        with self._lock:
            self._note("job %d cannot be sent", entry.number, error=error)
            if member.working_on is entry:
                member.finish()
            self._report(entry, reports.Failed(entry.number, DEFECT))
            self._hand_out()

    def _recover(self, error: Exception) -> None:
        """Fail all jobs and replace all processes; end it all if that did not help before."""
        now = time.monotonic()
        repeated = self._failed_at is not None and now - self._failed_at < REPEATED_FAILURE
        self._failed_at = now
        self._note("a defect in the pool of computing processes", error=error)
        if repeated:
            self._stop_all(BROKEN)
            return
        self._fail_all(DEFECT)
        for member in self._members:
            member.plan_to_restore(but=None)
            member.kill()

    def _stop_all(self, refusal: str) -> None:
        self._refusal = self._refusal or refusal
        self._fail_all(refusal)
        for member in self._members:
            member.kill()
        self._changed.notify_all()

    def _note(self, text: str, *values: object, error: Exception | None = None) -> None:
        """Log it, without waiting for a terminal that is not read."""
        self._asides.put(partial(_log.error, text, *values, exc_info=error))


def _ignore(_report: reports.Report | str) -> None:
    """Take nothing: of a tab that has gone, of loading, or of a pool without a page."""
