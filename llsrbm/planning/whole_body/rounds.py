"""Solves of the whole-body problem, each with the distances about the motion of the one before."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from llsrbm.body.efforts import efforts
from llsrbm.motion.solve_report import Violation
from llsrbm.ocp.horizon import Iterate, Problem, Solution
from llsrbm.ocp.progress import solving
from llsrbm.ocp.solvers import MAX_FOLLOW_MISS, SolveOptions, Solver
from llsrbm.planning.solve.watch import Watch
from llsrbm.planning.whole_body.apart import Apart
from llsrbm.planning.whole_body.bounds import RowBounds
from llsrbm.planning.whole_body.grid import Grid
from llsrbm.planning.whole_body.motion import Motion
from llsrbm.planning.whole_body.problem import make_problem, rolled_by
from llsrbm.planning.whole_body.sizes import Sizes
from llsrbm.planning.whole_body.start import Start, trunk_room, variables
from llsrbm.planning.whole_body.tops import tops
from llsrbm.request.slopes import normals
from llsrbm.robots.link_shapes import LinkShapes
from llsrbm.robots.robot import Robot

Array = NDArray[np.float64]

FROM_FAR = SolveOptions(mu=1e-2, iterations=80, push=0.01, acceptable=(5e-3, 4), tolerance=1e-3)
LOOK = replace(FROM_FAR, iterations=12)  # after so many distances are measured again
NEARER = replace(FROM_FAR, mu=1e-3)
NEAR = replace(FROM_FAR, mu=1e-4, iterations=60)
# From a table's jumps nearby: of 19 of Go2's and ANYmal's combined requests that took 2 s or more
# none is lost with 60 in place of 80 and 60 more, and those that are not found take half the time;
# with 45 one is lost.
BESIDE = replace(NEARER, iterations=60)
# Largest miss of a start from which a solver that never gives up is let begin: one at 0.75 never
# came back, below this none is known that did not.
SURE_MISS = 0.5
# Iterations of all solves that begin from a table: of 30 of Go2's requests 20 are found in 5 to 87,
# and the ten that are not took 27 to 264.
MOST_FOLLOWED = 100
# Of a landing that is moved: 21 to 101 iterations are needed.
MOVED = replace(NEARER, iterations=100)
MOVES = 4  # solves of it, each with the distances about the motion of the one before
NEARLY = 0.02  # of rows, of such a solution
TOLERANCE = 1e-3  # of rows, in their units of about 1
ROUNDS = 6
BETWEEN = 8  # parts of an interval at whose edges a motion is looked at
# Shares of the weight, and of it at `ARM` (m), that may be missing between the nodes; certificates
# allow a tenth.
MISSED, ARM = 0.09, 0.2
ASTRAY = 3e-3  # m that feet may come to rest from their places
_UNITS = {"stop": "rad", "rest": "m/s", "clearance": "m", "apart": "m", "durations": "s"}


@dataclass
class Rounds:
    """All solves from one start, and where they led.

    Attributes:
        solutions: all of them; found: name of rows -> the last one's largest violation.
        motion, start: where all rows hold and links keep apart; `solved` says whether; solution:
            the solver's of that motion.
    """

    robot: Robot
    grid: Grid
    solver: Solver
    phases: tuple[str, ...]  # names
    watch: Watch
    solutions: list[Solution] = field(default_factory=list)
    found: dict[str, Violation] = field(default_factory=dict)
    motion: Motion | None = None
    start: Start | None = None
    solution: Solution | None = None
    solved: bool = False
    _worst: float = np.inf  # of that motion, as a share of what may be

    def __post_init__(self) -> None:
        self.sizes = Sizes.of(self.robot, len(self.grid.phases))

    def solve(self, start: Start) -> None:
        """Solve from a start; where that fails, again with distances looked at early."""
        guess = variables(start, self.grid, self.sizes)
        for begun in (FROM_FAR, LOOK):
            self._from(start, guess, (begun,))
            if self.solved:
                break

    def follow(
        self, start: Start, begun: Iterate, *, alone: bool = False, straighter: bool = False
    ) -> None:
        """Follow from what is near the solution; `start`: of its motion.

        `straighter`: it is of straighter lines already; none with still straighter ones is sought.

        Where that leads nowhere the interior-point solver begins there, unless it is to be followed
        `alone`: of 10 of Go2's requests that its table did not lead to, 8 are found so, in 13 to 53
        iterations.
        """
        start = start.straighter() if straighter else start
        for options in ((begun,),) if alone else ((begun,), (BESIDE,)):
            self._from(start, begun.variables, options, MOST_FOLLOWED, once=straighter)
            if self.solved:
                break

    def near(self, start: Start) -> None:
        """Solve from a motion whose rows held on another grid."""
        self._from(start, variables(start, self.grid, self.sizes), (NEARER, NEAR), MOST_FOLLOWED)

    def reach(self, start: Start, begun: Iterate) -> bool:
        """Move the landing towards what is wanted, from what is near a solution without.

        Whether rows nearly hold in the end: they are solved again for what is reached.
        """
        guess = begun.variables
        for _ in range(MOVES):
            rows = RowBounds(self.robot, self.grid, self.sizes, start)
            self._hold(rows, make_problem(rows), guess, (MOVED,), np.inf)
            if any(violation.amount > NEARLY for violation in self.found.values()):
                return False
            guess = self.solutions[-1].variables
            motion = Motion.of(guess, self.grid, self.sizes)
            self.start = start = start.timed(motion.durations, self.grid)
            apart = self._apart(motion, start)
            if apart.holds:
                break
            start = replace(
                start.beside(motion.state), apart=apart, rolled=self._rolled(motion, start)
            )
        return True

    def _from(
        self,
        start: Start,
        guess: Array,
        options: tuple[SolveOptions | Iterate, ...],
        most: float = np.inf,  # iterations, after which none is begun
        once: bool = False,  # none with straighter lines is sought
    ) -> None:
        for _ in range(ROUNDS):
            rows = RowBounds(self.robot, self.grid, self.sizes, start)
            hold = self._hold(rows, make_problem(rows), guess, options, most)
            guess = self.solutions[-1].variables
            if not np.isfinite(guess).all() or not (hold or options == (LOOK,)):
                return
            motion = Motion.of(guess, self.grid, self.sizes)
            start = start.timed(motion.durations, self.grid)
            apart = self._apart(motion, start)
            if hold and apart.holds:
                missed, astray = self._accept(motion, start)
                if not (astray or (missed and not once)):
                    return
                start = start.straighter() if missed else start
                options = (NEAR, NEAR) if missed else (self.solutions[-1], NEAR)
            else:
                start = replace(start.beside(motion.state), apart=apart)
                start = start.nearer() if hold else start
                options = (NEAR, NEAR) if hold else (NEARER, NEAR)
            start = replace(start, rolled=self._rolled(motion, start))

    def _rolled(self, motion: Motion, start: Start) -> Array:
        return rolled_by(self.robot, self.grid, start.task.schedule, motion.state)

    def _accept(self, motion: Motion, start: Start) -> tuple[bool, bool]:
        """Take a motion if it is the first, or a better one; whether one may be better still: miss
        less between the nodes, and come to rest nearer to its places.
        """
        interval, part = np.divmod(np.arange((BETWEEN + 1) * self.grid.intervals), BETWEEN + 1)
        at = motion.within(interval, part / BETWEEN)
        on = normals(start.tilt[interval])
        lacks = efforts(self.robot, at.q, at.v, at.a, at.force, on)[:, :6] / self.sizes.weight
        force, moment = (np.linalg.norm(part, axis=1).max() for part in np.split(lacks, 2, axis=1))
        missed = max(force, moment / ARM)
        # Links may pass through each other between the instants at which they are apart.
        links = LinkShapes.of(self.robot)
        passing = bool(links.pairs) and links.least(at.q)[0] < 0
        parts = missed / MISSED, self._astray(motion, start) / ASTRAY
        if passing or max(parts) >= self._worst:
            return False, False
        self.motion, self.start, self.solution = motion, start, self.solutions[-1]
        self.solved, self._worst = True, float(max(parts))
        return parts[0] > 1.0, parts[1] > 1.0

    def _astray(self, motion: Motion, start: Start) -> float:
        """M between where feet come to rest and their places, horizontally: balls roll otherwise
        than in the motion beside which they land.
        """
        (q,) = motion.at(start.time[-1:]).q
        model, data = self.robot.model, self.robot.model.createData()
        pin.framesForwardKinematics(model, data, q)
        feet = [data.oMf[leg.foot_frame_id].translation[:2] for leg in self.robot.legs]
        off: Array = np.linalg.norm(np.array(feet) - start.place[-1, :, :2], axis=1)
        return float(off.max())

    def _hold(
        self,
        rows: RowBounds,
        problem: Problem,
        guess: Array,
        options: tuple[SolveOptions | Iterate, ...],
        most: float,
    ) -> bool:
        """Solve, and again from there where rows do not hold; whether they do in the end."""
        for each in options:
            if sum(solution.iterations for solution in self.solutions) >= most:
                return False
            if isinstance(each, Iterate):
                reach = MAX_FOLLOW_MISS if self.solver.gives_up else SURE_MISS
                solve = partial(self.solver.follow, problem, each, reach, FROM_FAR.acceptable)
            else:
                solve = partial(self.solver.solve, problem, guess, each, self.watch.read)
            solution = self.watch.over(solve)
            self.solutions.append(solution)
            self.found = dict(self._violations(solution, problem, rows))
            # Where its rows hold a motion can be done, whether or not it is the smoothest one.
            if all(violation.amount <= TOLERANCE for violation in self.found.values()):
                return True
            guess = solution.variables
            if not np.isfinite(guess).all():
                break
        return False

    def _apart(self, motion: Motion, start: Start) -> Apart:
        q, quat = motion.at(start.time).q, start.state["quat"]
        others = tops(q, self.grid, start.task, self.robot)
        trunk = trunk_room(self.grid)
        return Apart.near(q, start.time, quat, self.robot, start.solids, trunk, start.apart, others)

    def _violations(
        self, solution: Solution, problem: Problem, rows: RowBounds
    ) -> Iterator[tuple[str, Violation]]:
        """The largest violation of each kind of rows, of a solution as it is; NaN is the worst."""
        with solving:
            g = self.solver.function("nlp_g")(solution.variables, problem.parameters)
        g = np.array(g).ravel()
        worst: dict[str, float] = {}
        at = 0
        for name, knot, instant, low, high in rows:
            values = g[at : at + len(low)]
            at += len(low)
            amount = float(np.max(np.maximum(low - values, values - high), initial=0.0))
            amount = amount if np.isfinite(amount) else np.inf
            if name not in worst or amount > worst[name]:
                worst[name] = amount
                phase = int(self.grid.phase[min(knot, self.grid.intervals - 1)])
                yield name, Violation(amount, _UNITS.get(name, "1"), self.phases[phase], instant)
