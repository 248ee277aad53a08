"""Loading of solvers by the computing processes while there is no request, likeliest first."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from app.workers.member import PoolMember
from app.workers.protocol import PlanJump, Prepare, Report, Task
from app.workers.scheduler import Entry, Listener, Scheduler


class Background:
    """Takes the tasks in each process's `todo`, on one process at a time so that others are free.

    Attributes:
        listener: called with the reports of the first process.
    """

    def __init__(self, members: Sequence[PoolMember], turns: Scheduler) -> None:
        """Nothing is to be loaded.

        Args:
            members: of the pool.
            turns: know which task may take long.
        """
        self._members = members
        self._turns = turns
        self.listener: Listener = _ignore
        self._done: Callable[[], None] | None = None

    def warm_up(
        self, tasks: Sequence[Prepare | PlanJump], listener: Listener, done: Callable[[], None]
    ) -> None:
        """See `WorkerPool.warm_up`."""
        self.listener, self._done = listener, done
        for member in self._members:
            first = member is self._members[0]
            member.todo += [task for task in tasks if first or not isinstance(task, Prepare)]

    def owns(self, entry: Entry | None) -> bool:
        """Whether that is no tab's job."""
        return entry is not None and entry.tab is self

    def next(self) -> tuple[PoolMember, Task, Listener] | None:
        """A process with time, the task that it can load, and the listener; taken out of `todo`."""
        if any(self.owns(member.working_on) for member in self._members):
            return None
        able = [member for member in self._members if member.idle and self._may_take(member)]
        if not able:
            return None
        # The first process is through first: from then on, whatever is likely is at hand.
        member = able[0]
        reported = self._done is not None and member is self._members[0]
        return member, member.todo.pop(0), self.listener if reported else _ignore

    def take_done(self) -> Callable[[], None] | None:
        """The call that is due, once, when the first process is through; others go on."""
        first = self._members[0]
        starting = first.may_start and not first.ready
        if self._done is None or first.todo or first.working_on is not None or starting:
            return None
        done, self._done = self._done, None
        return done

    def wants_all_processes(self) -> bool:
        """Whether the first one has something likely at hand, so that the others may start.

        On two cores they would only delay that.
        """
        return any(member.loaded for member in self._members) or (
            self._done is not None and not self._members[0].todo
        )

    @property
    def awaited(self) -> bool:
        """Whether the first process is not through yet."""
        return self._done is not None

    def _may_take(self, member: PoolMember) -> bool:
        if not member.todo:
            return False
        new = self._turns.is_new(member.todo[0])
        return not (new and member.reserved) and self._turns.may_run(member.todo[0], self._members)


def _ignore(_report: Report) -> None:
    """Of what loads without a request, nothing is reported."""
