"""Reports on the solves of a plan: effort, wall times, and violations of its constraints."""

from __future__ import annotations

from dataclasses import dataclass, replace

NEAREST = "nearest to another request"
"""`SolveReport.guess` of plans that were made in place of a request that is not feasible."""

UNTRIED = "not-tried"
"""`Refinement.status` of a draft in which the body turns over and lands on all feet at once."""


@dataclass(frozen=True)
class Violation:
    """Violation of one named constraint, recomputed from the result.

    Attributes:
        amount: largest violation, in `unit` (SI); 0 when satisfied.
        phase, time: name of the schedule's phase in which it is largest, and when, s.
    """

    amount: float
    unit: str
    phase: str
    time: float


@dataclass(frozen=True)
class Effort:
    """Interior-point iterations and wall times (s) of a whole plan: draft and whole body.

    Attributes:
        solve_time_s, total_time_s, build_time_s: as of a `SolveReport`.
    """

    iterations: int
    solve_time_s: float
    total_time_s: float
    build_time_s: float

    @classmethod
    def of(cls, draft: SolveReport, whole_body: Refinement | None) -> Effort:
        """Both solves of a plan together."""
        solves = (draft,) if whole_body is None else (draft, whole_body)
        return cls(
            iterations=sum(each.iterations for each in solves),
            solve_time_s=sum(each.solve_time_s for each in solves),
            total_time_s=sum(each.total_time_s for each in solves),
            build_time_s=sum(each.build_time_s for each in solves),
        )


@dataclass(frozen=True)
class SolveReport:
    """Status, effort and wall times (s) of a solve.

    Attributes:
        status: "solved" or "not-converged"; solver: "fatrop" or "ipopt".
        iterations, guess: interior-point iterations of the attempt that is returned, and the origin
            of its initial guess, in words.
        attempts: initial guesses tried, 1 when the analytic one was enough; 0 of whole-body plans
            that began without a draft.
        solve_time_s: inside the solver, all attempts; total_time_s: from request to `Plan`, solver
            already built; build_time_s: to build or load the solver, 0 when it was at hand.
        cost: value of the objective.
        compiling: whether the solver was still being compiled, and took twice as long for it.
    """

    status: str
    solver: str
    iterations: int
    attempts: int
    solve_time_s: float
    total_time_s: float
    build_time_s: float
    cost: float
    guess: str = ""
    compiling: bool = False


@dataclass(frozen=True)
class Refinement:
    """Status, effort and wall times (s) of the second stage, on the whole body's dynamics.

    Attributes:
        status: "solved"; "not-converged", or "not-tried" for a body that turns over and is not
            caught: then the plan is the centroidal one.
        solve_time_s, total_time_s, build_time_s, compiling: as of a `SolveReport`.
    """

    status: str
    iterations: int
    solve_time_s: float
    total_time_s: float
    build_time_s: float
    cost: float
    compiling: bool = False

    def beside(self, other: Refinement) -> Refinement:
        """With the effort and the times of another one, which came to nothing."""
        return replace(
            self,
            iterations=other.iterations + self.iterations,
            solve_time_s=other.solve_time_s + self.solve_time_s,
            total_time_s=other.total_time_s + self.total_time_s,
            build_time_s=other.build_time_s + self.build_time_s,
        )
