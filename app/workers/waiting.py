"""The jobs that wait, and the process that takes each: the rules by which tabs share the pool.

1. Tabs take turns in the order of their requests. A tab has one job waiting; a newer one takes its
   place in the queue, so that a slider dragged in one tab cannot starve another.
2. A tab has at most one job of each kind (planning, searching, simulating, files) running, besides
   those that were requested to stop. A job of several parts has any number of them running; after
   each the other tabs have their turn.
3. One process is reserved: it takes no job that lasts seconds, so that no plan has to wait for
   another tab's simulation; but for a machine with no more than two, while the other one looks for
   a largest jump, which takes minutes. One of these is looked for at a time.
4. A solver or a robot's meshes that have to be built first are built on one process at a time.
   Different ones are built side by side, but on the reserved process only if no other builds.
5. Visitors' files are read one at a time, so that a hostile one keeps one process busy.
6. At most `MOST_WAITING` jobs wait; beyond that new tabs are refused until the queue is shorter.
"""

from collections.abc import Hashable, Iterator, Sequence

from app.workers.member import Entry, Member
from app.workers.tasks import Kind, Task

MOST_WAITING = 200
"""Jobs in the queue: of some 60 tabs that plan, open and save at once; a job may hold a file of
32 MB, so that the queue needs a bound."""

AGAIN = "the computing process was killed, and another one takes its place"


class Waiting:
    """The jobs that wait."""

    def __init__(self) -> None:
        self._entries: dict[Hashable, Entry] = {}
        self._built: set[Hashable] = set()

    def __iter__(self) -> Iterator[Entry]:
        return iter(tuple(self._entries.values()))

    def __len__(self) -> int:
        return len(self._entries)

    def put(self, entry: Entry) -> None:
        """Queue it, or in place of its tab's waiting job; not if `is_full_for` its tab."""
        self._entries[entry.tab] = entry

    def get(self, tab: Hashable) -> Entry | None:
        """The tab's waiting job."""
        return self._entries.get(tab)

    def is_full_for(self, tab: Hashable) -> bool:
        """Whether no further job can wait, except in place of one of the same tab."""
        return len(self._entries) >= MOST_WAITING and tab not in self._entries

    def withdraw(self, tab: Hashable) -> Entry | None:
        """Take the tab's waiting job out of the queue."""
        return self._entries.pop(tab, None)

    def replaced(self, entry: Entry, members: Sequence[Member]) -> bool:
        """Whether its tab wants something else by now."""
        running = [m.working_on for m in members if m.working_on is not None]
        others = [self.get(entry.tab), *(each for each in running if each.tab == entry.tab)]
        return any(other not in (None, entry) for other in others)

    def awaited(self, entry: Entry, members: Sequence[Member]) -> str:
        """The job that this one waits for: its tab's own if there is one, else the longest."""
        if entry.begun_again:
            return AGAIN
        busy = [(m.working_on, m.activity) for m in members if m.working_on and m.activity]
        busy.sort(key=lambda pair: (pair[0].tab != entry.tab, pair[0].number))
        return busy[0][1] if busy else "the computing process starts"

    def note_done(self, task: Task) -> None:
        """A task was worked on: its solver or meshes are built, at least on the disk."""
        self._built.add(task.needs)

    def clear(self) -> list[Entry]:
        """Take all waiting jobs out of the queue."""
        entries = list(self._entries.values())
        self._entries.clear()
        return entries

    def next(self, members: Sequence[Member]) -> tuple[Entry, Task, Member] | None:
        """Take the first job, or part of one, that a member can take; with it, and the member."""
        running = [m.working_on for m in members if m.working_on is not None and not m.stopping]
        for entry in self._entries.values():
            task = entry.parts[0]
            rival = any(
                other is not entry and (other.tab, other.task.kind) == (entry.tab, task.kind)
                for other in running
            )
            able = [
                m for m in members if m.idle and (m.suits(task) or _stands_in(m, task, members))
            ]
            if rival or not able or not self.may_run(task, members):
                continue
            if self.is_new(task) and any(m.task and self.is_new(m.task) for m in members):
                able = [m for m in able if not m.reserved]
                if not able:
                    continue
            member = min(able, key=lambda m: self._reluctance(m, task))
            entry.parts.popleft()
            del self._entries[entry.tab]
            if entry.parts:  # behind the others, who have waited longer
                self._entries[entry.tab] = entry
            return entry, task, member
        return None

    def next_to_load(self, tab: Hashable, members: Sequence[Member]) -> tuple[Task, Member] | None:
        """Take what a process with time is to load; one at a time, in the name of that tab."""
        if any(m.working_on is not None and m.working_on.tab == tab for m in members):
            return None
        for member in members:
            if member.idle and member.todo:
                task = member.todo[0]
                blocked = self.is_new(task) and member.reserved
                if not blocked and self.may_run(task, members):
                    del member.todo[0]
                    return task, member
        return None

    def is_new(self, task: Task) -> bool:
        """Whether it may have to build something first, which may take long."""
        return task.needs is not None and task.needs not in self._built

    def may_run(self, task: Task, members: Sequence[Member]) -> bool:
        """Whether no member is building the same, nor reads a file if it is one."""
        running = [m.task for m in members if m.task is not None]
        if task.one_at_a_time and any(type(other) is type(task) for other in running):
            return False
        return not self.is_new(task) or all(other.needs != task.needs for other in running)

    def _reluctance(self, member: Member, task: Task) -> tuple[bool, bool]:
        """Sorts members: with the solver first; then a reserved one, unless it may take long."""
        long = self.is_new(task) or task.kind.long
        return task.needs not in member.loaded, member.reserved == long


def _stands_in(member: Member, task: Task, members: Sequence[Member]) -> bool:
    """Whether the reserved process takes a task as all the others look for largest jumps."""
    others = [m for m in members if not (m.reserved or m.spare)]
    searching = all(m.task is not None and m.task.kind is Kind.LARGEST for m in others)
    return member.reserved and task.kind is not Kind.LARGEST and searching
