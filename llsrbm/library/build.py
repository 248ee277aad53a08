"""Builds a library: requests are drawn until there are motions enough, or are given.

    DIR/journal.jsonl        a line for each request that was tried: what became of it
    DIR/parts/NAME.npz       motions, a file each, whole or not there
    DIR/ROBOT.npz            all motions of a robot, once the build is done

A build that was ended in between goes on where it was: what the journal has is not tried again, and
a motion that was written before the journal's line is known by its request.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO, TypeAlias

from llsrbm.errors import InputError
from llsrbm.file_locks import lock
from llsrbm.library.attempt import FAILED, KEPT, LIMIT, THERE, Attempt, Request, run_attempt
from llsrbm.library.draws import Draw
from llsrbm.library.library import Library
from llsrbm.library.mirror import image_of
from llsrbm.request.jump import Jump
from llsrbm.request.tuning import Tuning

if TYPE_CHECKING:
    import distributed

JOURNAL = "journal.jsonl"
TRIES = 4  # times as many draws as motions are wanted: then a robot is given up
_UNDER_WAY = 2  # requests a worker, so that it need not wait for its next one

Runner: TypeAlias = Callable[[Iterator[Request], int], Iterable[Attempt]]
"""(requests, seeds) -> what became of them, in any order; requests are taken as they are needed."""


class Build:
    """A library that is built, or that more is added to."""

    def __init__(self, folder: Path) -> None:
        """Open or make the folder, which is held by one process at a time.

        Raises `InputError`: it cannot be made, another process builds in it, or a file is damaged.
        """
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"{folder}: cannot be made: {error.strerror}") from error
        self.library = Library(folder)
        self._lock = _locked(folder)
        self._journal = folder / JOURNAL
        self._tried, self._imaged = self._read_journal()
        for card in self.library.cards:
            if card.drawn is not None:
                self._tried.setdefault((card.robot, card.drawn), KEPT)

    def close(self) -> None:
        """Let other processes build in the folder."""
        self._lock.close()

    def kept(self, robot: str) -> int:
        """Number of a robot's motions."""
        return sum(card.robot == robot for card in self.library.cards)

    def run(
        self,
        requests: Iterator[Request],
        seeds: int,
        runner: Runner,
        note: Callable[[Attempt], None],
    ) -> Counter[str]:
        """Try requests; `note` is told of each. How many came to what."""
        counts: Counter[str] = Counter()
        for found in runner(requests, seeds):
            found = self._put(found)
            self._write(found)
            counts[found.status] += 1
            note(found)
        return counts

    def draws(self, robots: Sequence[str], count: int) -> Iterator[Request]:
        """Draws that were not tried, until there are `count` motions, as many of each robot."""
        for place, robot in enumerate(robots):
            # One robot after the other: its solvers are built once.
            wanted = count // len(robots) + (place < count % len(robots))
            for number in range(TRIES * wanted):
                if self.kept(robot) >= wanted:
                    break
                if (robot, number) not in self._tried:
                    yield Request.drawn(Draw(robot, number))

    def images(self, robots: Sequence[str]) -> Iterator[Request]:
        """The images in a mirror of all motions of these robots, but those that were tried.

        A motion that is its own image, or whose image is there, has none.
        """
        for card in self.library.found():
            if card.robot not in robots or card.name in self._imaged:
                continue
            request = {"request": image_of(card)}
            if self.library.with_request(card.model_copy(update=request)) is None:
                yield Request.image(self.library.stored(card.name))

    def _put(self, found: Attempt) -> Attempt:
        if found.motion is None:
            return found
        try:
            self.library.put(found.motion)
        except InputError as error:
            return Attempt(found.request, THERE, why=str(error))
        return found

    def _write(self, found: Attempt) -> None:
        request = found.request
        line: dict[str, Any] = {"robot": request.jump.robot, "status": found.status}
        if request.original is not None:
            line["image_of"] = request.original.card.name
            self._imaged.add(request.original.card.name)
        if request.draw is not None:
            line |= {"draw": request.draw.number, "kind": request.draw.kind}
            self._tried[request.jump.robot, request.draw.number] = found.status
        with self._journal.open("a", encoding="utf-8") as file:
            file.write(json.dumps(line | {"why": found.why}) + "\n")

    def _read_journal(self) -> tuple[dict[tuple[str, int], str], set[str]]:
        """(robot, draw) -> what became of it, and names of motions whose images were tried.

        A line that was cut off is none.
        """
        found: dict[tuple[str, int], str] = {}
        imaged: set[str] = set()
        if not self._journal.is_file():
            return found, imaged
        text = self._journal.read_text(encoding="utf-8")
        if not text.endswith("\n"):  # the next line begins anew
            with self._journal.open("a", encoding="utf-8") as file:
                file.write("\n")
        for line in text.splitlines():
            try:
                entry = json.loads(line)
                if "image_of" in entry:
                    imaged.add(str(entry["image_of"]))
                    continue
                found[str(entry["robot"]), int(entry["draw"])] = str(entry["status"])
            except (ValueError, LookupError, TypeError):
                continue
        return found, imaged


def _locked(folder: Path) -> TextIO:
    """A lock of the folder, which is free again when the process ends."""
    file = (folder / ".lock").open("w")
    if not lock(file):
        file.close()
        raise InputError(f"{folder}: another process builds in it; expected another folder")
    return file


def read_requests(path: Path) -> list[Request]:
    """Requests of a JSON file: a list of objects with the fields of a `Jump` (rad, m).

    `weights` and `limits` may stand beside them. Raises `InputError`: the file is none, or a field
    is wrong.
    """
    from llsrbm.request.jump_types import with_defaults
    from llsrbm.request.messages import field_specs
    from llsrbm.text_files import parse_json, read_text

    rows = parse_json(read_text(path, "a list of requests (JSON)", 10**7), str(path))
    if not isinstance(rows, list):
        raise InputError(f"{path}: expected a list of requests")
    found = []
    for number, row in enumerate(rows, start=1):
        where = f"{path}: request {number}"
        if not isinstance(row, dict):
            raise InputError(f"{where}: expected an object with the fields of a jump")
        tuning = Tuning(row.pop("weights", {}), row.pop("limits", {}))
        for name in row:
            if name not in field_specs(Jump):
                raise InputError(f'{where}: no field "{name}"; expected some of a jump\'s')
        try:
            jump = Jump(**row)
            jump = with_defaults(jump, row) if "type" in row else jump
            found.append(Request(jump, tuning))
        except InputError as error:
            raise InputError(f"{where}: {error}") from error
    return found


def in_turn(requests: Iterator[Request], seeds: int) -> Iterator[Attempt]:
    """A `Runner` of one process beside this one."""
    for request in requests:
        yield run_attempt(request, seeds, LIMIT)


def on_workers(client: distributed.Client) -> Runner:
    """A `Runner` of the workers of a Dask scheduler."""
    import distributed
    from distributed.scheduler import KilledWorker

    def run(requests: Iterator[Request], seeds: int) -> Iterator[Attempt]:
        ended, under_way = distributed.as_completed(), dict[Any, Request]()
        while True:
            most = _UNDER_WAY * max(len(client.nthreads()), 1)
            while len(under_way) < most and (request := next(requests, None)) is not None:
                future = client.submit(run_attempt, request, seeds, LIMIT, pure=False)
                under_way[future] = request
                ended.add(future)
            if not under_way:
                return
            future = next(ended)
            request = under_way.pop(future)
            try:
                yield future.result()
            except KilledWorker:
                yield Attempt(request, FAILED, why="workers died while they computed it")

    return run
