"""The computing processes, a thread each, and the successors of those that hold too much memory.

A process that says that it is heavy gets a successor, for which there is one process more than
places: it starts beside the other, loads what was used last, and takes its place when that has no
job.
"""

import threading
import time
from collections.abc import Callable, Sequence
from functools import partial

from app.workers.member import Member
from app.workers.process import Ended, Process
from app.workers.reports import Message
from app.workers.tasks import PlannerFactory, Prepare, Task
from llsrbm.processors import usable_processors

# One process plans while another simulates; more than four would mostly cost memory (0.3 GB each).
PROCESSES = min(max(usable_processors(), 2), 4)
MOST_PROCESSES = 64


class Crew:
    """All of the members; every method but `join` is called under the pool's lock."""

    def __init__(
        self,
        factory: PlannerFactory,  # makes the planner inside a process
        places: int,  # with more than one, the last takes nothing that lasts seconds
        lock: threading.RLock,  # the pool's
        # called under the lock, by a process' thread: it has sent something, has gone, or its
        # thread has met an exception that nothing foresees
        received: Callable[[Member, Message], None],
        ended: Callable[[Member, Ended], None],
        failed: Callable[[Exception], None],
    ) -> None:
        self.members = tuple(
            Member(
                Process(factory, f"llsrbm-computing-{i + 1}"),
                reserved=0 < i == places - 1,
                spare=i == places,
                may_start=i < places,
            )
            for i in range(places + 1)
        )
        self._lock, self._received, self._ended, self._failed = lock, received, ended, failed
        self._threads: set[threading.Thread] = set()

    @property
    def first(self) -> Member:
        """The one that is started first, and prepares robots for all."""
        return self.members[0]

    @property
    def process_ids(self) -> tuple[int | None, ...]:
        """Process id of each place, None while there is none; the reserved one is the last."""
        at_work = sorted((m for m in self.members if not m.spare), key=lambda m: m.reserved)
        return tuple(member.process.id for member in at_work)

    @property
    def first_is_through(self) -> bool:
        """Whether the first process has loaded all that it was to."""
        first, starting = self.first, self.first.may_start and not self.first.ready
        return not (first.todo or first.working_on is not None or starting)

    def load(self, tasks: Sequence[Task]) -> None:
        """Have all load what is likely to be requested; robots are prepared by the first alone."""
        others = [task for task in tasks if not isinstance(task, Prepare)]
        for member in self.members:
            if not member.spare:
                member.todo += tasks if member is self.first else others

    def start(self, *, at_once: bool) -> None:
        """Start those that may be; all of them `at_once`, or the first one first.

        On two cores the others would delay the first until it has something likely at hand.
        """
        at_once = at_once or any(member.loaded for member in self.members)
        for number, member in enumerate(self.members):
            wanted = at_once or member is self.first
            if wanted and member.may_start and not member.running:
                member.start(time.monotonic())
                self.start_thread(partial(self._run, member), f"worker-pool-{number}")

    def renew(self) -> None:
        """Have a heavy process' place taken by its successor, once that has loaded the same."""
        heavy = next((m for m in self.members if m.heavy and not m.ending), None)
        if heavy is None:
            return
        successor = next(member for member in self.members if member.spare)
        if not (successor.may_start or successor.running):
            successor.reserved, successor.may_start = heavy.reserved, True
            successor.todo = heavy.used_last
        elif successor.idle and not successor.todo and heavy.idle:
            successor.spare = False
            heavy.spare, heavy.heavy, heavy.may_start = True, False, False
            heavy.kill()

    def retire(self, member: Member) -> None:
        """A spare process has gone: a successor that has failed, or the one whose place it took."""
        if member.may_start:  # a successor: no other one before the heavy one says so again
            for other in self.members:
                other.heavy = False
        member.may_start = False
        member.todo.clear()
        member.loaded.clear()

    def start_thread(self, target: Callable[[], None], name: str) -> None:
        """A thread that `join` waits for."""

        def run() -> None:
            target()
            self._threads.discard(threading.current_thread())

        thread = threading.Thread(target=run, name=name, daemon=True)
        self._threads.add(thread)
        thread.start()

    def join(self, until: float) -> None:
        """Wait for the end of the threads, until a time (s, monotonic clock)."""
        for thread in tuple(self._threads):
            thread.join(max(0.0, until - time.monotonic()))

    def _run(self, member: Member) -> None:
        try:
            for message in member.process.run():
                with self._lock:
                    self._received(member, message)
        except Ended as ended:
            with self._lock:
                self._ended(member, ended)
        except Exception as error:  # noqa: BLE001  # the last resort: whatever it is
            with self._lock:
                self._failed(error)
                self._ended(member, Ended("of which the terminal says more"))
