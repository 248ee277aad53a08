"""Solver interface: options of a solve, a solve from a guess, and one from a near solution."""

import math
import time
from abc import ABC, abstractmethod
from collections import OrderedDict
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar, TypeAlias

import casadi as ca
import numpy as np

from llsrbm.arrays import Array
from llsrbm.ocp.horizon import Iterate, Problem, Solution
from llsrbm.ocp.progress import solving
from llsrbm.ocp.transcription import Transcribed


@dataclass(frozen=True)
class SolveOptions:
    """Start and end of a solve from a guess.

    Attributes:
        push: how far it begins inside of the bounds it touches; None: Fatrop's own 0.01.
        within: size of rows, in their units of about 1, beyond which no step leads; None: anywhere.
        acceptable: where the cost is flat Fatrop creeps: the constraints are met, the cost changes
            in the fourth digit, the gradient stays at some 1e-3. At this tolerance, for so many
            iterations, it is as good as solved; None: it creeps on.

    Ipopt ignores the last three.
    """

    mu: float  # complementarity at which it begins
    iterations: int  # after so many it is given up
    # Fatrop's default of 1e-8 stalls; at 1e-4 the cost agrees to 0.1 %.
    tolerance: float = 1e-4  # at which it has converged
    push: float | None = None
    within: float | None = None
    acceptable: tuple[float, int] | None = None


# From a guess, which is far from the optimum. The push takes 15 % fewer iterations over ten jumps
# and three models than with the solver's default.
FROM_GUESS = SolveOptions(mu=1e-2, iterations=150, push=0.05, acceptable=(5e-3, 4))

# A solve near a known solution stops at this tolerance: the cost is 0.02 % from that of a cold one.
NEAR_TOLERANCE = 3e-4
# The complementarity at which Fatrop ends for that tolerance; near a solution it begins there.
NEAR_MU = NEAR_TOLERANCE / 11
# A solution that violates the rows of its neighbour by more, in their units of about 1, is none:
# Fatrop may not come back from there. A slider that moves by 30 deg makes 0.3; a whole-body plan
# that began at 1.12 never came back, of five that began between 1 and 2 three were found.
MAX_FOLLOW_MISS = 1.0
# Likewise of a guess: analytic ones violate rows by some 3.
MAX_GUESS_MISS = 100.0
# An nlpsol that has run holds so many times its work vector, most of it in Fatrop's own matrices:
# 6 of Go2's draft (50 MB), 4 of its whole body (65), 4 to 5 of a caught flip's (170 and 280).
WORK_VECTORS = 5.0
# MB of a problem's nlpsols, one for each set of options; the last used one stays. Three of Go2's
# whole body fit in, two of G1's. To make one anew takes 0.1 to 0.4 s.
MOST_MADE = 350.0

Options: TypeAlias = SolveOptions | tuple[float, int] | None
"""Of a solve from a guess, or what is acceptable of one near a solution."""


class Solver(ABC):
    """Solves a transcription's problems with one of nlpsol's plugins, one solve at a time."""

    name: ClassVar[str]  # to choose it by
    compiled: ClassVar[bool] = False  # whether it takes compiled functions

    def __init__(self, transcribed: Transcribed) -> None:
        self._faster: Callable[[], Transcribed | None] | None = None
        self._wait: Callable[[], None] | None = None
        self._adopt(transcribed)

    def _adopt(self, transcribed: Transcribed) -> None:
        self._problem = transcribed
        self._made: OrderedDict[Options, ca.Function] = OrderedDict()  # the last used at the end

    @property
    def sizes(self) -> tuple[int, int]:
        """Numbers of variables and of rows."""
        rows = self.function("nlp_g")
        return int(rows.numel_in(0)), int(rows.numel_out(0))

    @property
    def megabytes(self) -> float:
        """Memory that it takes, MB, about."""
        return self._problem.megabytes + self._megabytes_made()

    def _megabytes_made(self) -> float:
        # A solve that was abandoned may go on in its thread, and add one meanwhile.
        return sum(WORK_VECTORS * 8e-6 * made.sz_w() for made in tuple(self._made.values()))

    def _nlpsol_for(self, options: Options, make: Callable[[], ca.Function]) -> ca.Function:
        """The nlpsol of these options; those not used for longest go where memory is short."""
        self._made[options] = found = self._made.pop(options, None) or make()
        while len(self._made) > 1 and self._megabytes_made() > MOST_MADE:
            self._made.popitem(last=False)
        return found

    def replace_by(
        self, faster: Callable[[], Transcribed | None], wait: Callable[[], None] | None = None
    ) -> None:
        """Use the same problem's faster functions from the first solve on for which they exist.

        `faster` returns them, or None before; `wait` returns when they exist, or never will.
        """
        self._faster, self._wait = faster, wait

    def settle(self) -> None:
        """Wait for faster functions that are being made; later solves all use the same ones."""
        if self._faster is not None and self._wait is not None:
            self._wait()
        self._renew()
        self._faster = None

    def _renew(self) -> None:
        if self._faster is not None and (transcribed := self._faster()) is not None:
            self._adopt(transcribed)
            self._faster = None

    def function(self, name: str) -> ca.Function:
        """One of the problem's functions, as it is evaluated (`transcription.FUNCTIONS`)."""
        return self._problem.functions[name]

    def solve(
        self,
        problem: Problem,
        guess: Array,
        options: SolveOptions = FROM_GUESS,
        read: Callable[[str], None] | None = None,
    ) -> Solution:
        """Solve from a guess of all variables; `read` receives the table of iterations, if any.

        Raises `ValueError`: the guess is not finite, but violates no row.
        """
        with solving:
            self._renew()
            if (miss := self.miss(problem, guess)) > MAX_GUESS_MISS:
                start = Iterate(guess, np.zeros_like(problem.lower))
                return self._not_begun(problem, start, miss)
            nlpsol = self._nlpsol_for(options, partial(self._solver_from_guesses, options))
            with nullcontext() if read is None else self._printing(read):
                return self._run(nlpsol, problem, {"x0": guess})

    def follow(
        self,
        problem: Problem,
        start: Iterate,
        max_miss: float = MAX_FOLLOW_MISS,
        acceptable: tuple[float, int] | None = None,
    ) -> Solution:
        """Solve from the solution of a problem whose numbers are a little off.

        `max_miss`: largest violation of a row with which it is begun; `acceptable`: see
        `SolveOptions`.
        """
        with solving:
            self._renew()
            rows = self._rows(problem, start.variables)
            if (miss := largest_violation(problem, rows)) > max_miss:
                return self._not_begun(problem, start, miss)
            nlpsol = self._nlpsol_for(acceptable, partial(self._solver_near, acceptable))
            return self._follow(nlpsol, problem, start, rows)

    @abstractmethod
    def _follow(
        self, solver: ca.Function, problem: Problem, start: Iterate, rows: Array
    ) -> Solution:
        """`follow` by a solver of `_solver_near`, with `rows` (rows,), g of the start."""

    def miss(self, problem: Problem, variables: Array) -> float:
        """The largest violation of a row; infinite where a row is not finite."""
        with solving:
            return largest_violation(problem, self._rows(problem, variables))

    def _rows(self, problem: Problem, variables: Array) -> Array:
        return np.array(self.function("nlp_g")(variables, problem.parameters)).ravel()

    def _not_begun(self, problem: Problem, start: Iterate, miss: float) -> Solution:
        return Solution(
            variables=start.variables,
            multipliers=start.multipliers,
            converged=False,
            iterations=0,
            cost=float(self.function("nlp_f")(start.variables, problem.parameters)),
            solve_time_s=0.0,
            violation=miss,
            message="too far from a solution to begin",
        )

    @property
    def gives_up(self) -> bool:
        """False if a search for a direction may go on for ever."""
        return True

    @abstractmethod
    def _solver_from_guesses(self, options: SolveOptions) -> ca.Function:
        pass

    @abstractmethod
    def _solver_near(self, acceptable: tuple[float, int] | None) -> ca.Function:
        pass

    @abstractmethod
    def _outcome(self, stats: dict[str, Any]) -> tuple[bool, int]:
        """Convergence and number of iterations from nlpsol's statistics."""

    def _printing(self, read: Callable[[str], None]) -> AbstractContextManager[None]:
        """Meanwhile the solver prints its table into `read`; by default there is none."""
        return nullcontext()

    def _run(
        self,
        solver: ca.Function,
        problem: Problem,
        arguments: dict[str, Array],
        scale: float | Array = 1.0,
    ) -> Solution:
        """Call nlpsol; `scale` (rows,): of its rows, in units of the problem's."""
        if not np.isfinite(arguments["x0"]).all():  # Fatrop would never return
            raise ValueError("the initial guess is not finite")
        start = time.perf_counter()
        numbers = {"p": problem.parameters, "lbg": problem.lower, "ubg": problem.upper}
        result = solver(**numbers | arguments)
        elapsed = time.perf_counter() - start
        stats = solver.stats()
        converged, iterations = self._outcome(stats)
        return Solution(
            variables=np.array(result["x"]).ravel(),
            multipliers=scale * np.array(result["lam_g"]).ravel(),
            converged=converged,
            iterations=iterations,
            cost=float(result["f"]),
            solve_time_s=elapsed,
            violation=largest_violation(problem, np.array(result["g"]).ravel() / scale),
            message=str(stats.get("return_status", "")),
        )


def largest_violation(problem: Problem, g: Array) -> float:
    """Largest distance of a row of g (rows,) from its bounds; infinite if one is not finite."""
    largest = np.maximum(problem.lower - g, g - problem.upper).max()
    return float(largest) if np.isfinite(largest) else math.inf
