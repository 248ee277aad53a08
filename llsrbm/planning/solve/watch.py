"""Progress and cancellation of planning."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

from llsrbm.errors import Cancelled
from llsrbm.ocp.horizon import Solution
from llsrbm.ocp.progress import IterationTable, attended, interruptible, when_idle
from llsrbm.request.messages import check_functions


@dataclass(frozen=True)
class PlanningProgress:
    """A step of the planner.

    Attributes:
        text: one line for a person.
        iteration: of the running solve; None before its first report.
        residual: its largest constraint violation, in the solver's scaled units.
    """

    text: str
    iteration: int | None = None
    residual: float | None = None


Progress = Callable[[PlanningProgress], None]
Result = TypeVar("Result")


class Watch:
    """Passes progress on, and cancels."""

    def __init__(
        self, cancelled: Callable[[], bool] | None = None, progress: Progress | None = None
    ) -> None:
        check_functions(cancelled=cancelled, progress=progress)
        self.cancelled, self.progress = cancelled, progress
        self._text = ""
        self._table = IterationTable()

    @property
    def read(self) -> Callable[[str], None] | None:
        """Takes a solver's printed output; None when progress is not wanted."""
        return None if self.progress is None else self._table.read

    def wait(self) -> None:
        """Until CasADi may be used. Raises `Cancelled`: on request."""
        when_idle(self.cancelled)

    def begin(self, text: str) -> None:
        """Report the next step. Raises `Cancelled`: on request."""
        if self.cancelled is not None and self.cancelled():
            raise Cancelled("planning was cancelled")
        self._text = text
        # A new one before its `read` is handed on.
        self._table = IterationTable()
        if self.progress is not None:
            self.progress(PlanningProgress(text))

    def built(self, make: Callable[[], Result]) -> Result:
        """The thing that `make` builds. Raises `Cancelled`: on request."""
        return interruptible(make, self.cancelled)

    def over(self, solve: Callable[[], Solution]) -> Solution:
        """Run `solve`, reporting progress; its result. Raises `Cancelled`: on request."""
        report = None if self.progress is None else self._report
        return attended(solve, lambda: self._table.last, report, self.cancelled)

    def _report(self, iteration: int, residual: float) -> None:
        if self.progress is not None:
            self.progress(PlanningProgress(self._text, iteration, residual))
