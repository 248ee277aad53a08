"""News of planning while it runs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from llsrbm.errors import Cancelled
from llsrbm.ocp.problem import Solution
from llsrbm.ocp.progress import IterationTable, attended, when_idle


@dataclass(frozen=True)
class PlanningProgress:
    """What the planner is doing.

    Attributes:
        text: one line for a person.
        iteration: of the running solve; None before its first news.
        residual: its largest constraint violation, in the solver's scaled units.
    """

    text: str
    iteration: int | None = None
    residual: float | None = None


Progress = Callable[[PlanningProgress], None]


class Watch:
    """Whether to go on, and who is told how it goes."""

    def __init__(
        self, cancelled: Callable[[], bool] | None = None, progress: Progress | None = None
    ) -> None:
        self._cancelled, self._progress = cancelled, progress
        self._text = ""
        self._table = IterationTable()

    @property
    def read(self) -> Callable[[str], None] | None:
        """Takes what a solver prints; None when nobody wants to know."""
        return None if self._progress is None else self._table.read

    def wait(self) -> None:
        """Until CasADi may be used.

        Raises:
            Cancelled: it is not wanted any more.
        """
        when_idle(self._cancelled)

    def begin(self, text: str) -> None:
        """Tell what comes next.

        Raises:
            Cancelled: it is not wanted any more.
        """
        if self._cancelled is not None and self._cancelled():
            raise Cancelled("planning was cancelled")
        self._text = text
        # A new one before anybody takes hold of its `read`.
        self._table = IterationTable()
        if self._progress is not None:
            self._progress(PlanningProgress(text))

    def over(self, solve: Callable[[], Solution]) -> Solution:
        """What `solve` returns, watched over.

        Raises:
            Cancelled: it is not wanted any more.
        """
        tell = None if self._progress is None else self._tell
        return attended(solve, lambda: self._table.last, tell, self._cancelled)

    def _tell(self, iteration: int, residual: float) -> None:
        if self._progress is not None:
            self._progress(PlanningProgress(self._text, iteration, residual))
