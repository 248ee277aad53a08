"""The nearest jump that the whole body does, where it does not do all that is asked.

Where the robot has a table of solved jumps it is sought from there, by moving the landing as far as
all limits allow, which finds requests that the table as such does not lead to. The others are
solved from their drafts, unless the table makes them unlikely: such searches end nowhere, late.
"""

from __future__ import annotations

from dataclasses import replace

from llsrbm.certified_plan import CertifiedPlanner, Nearest, may_hold_elsewhere
from llsrbm.errors import NotConverged
from llsrbm.motion.plan import Plan
from llsrbm.planning.problem.placement import limits_of
from llsrbm.planning.problem.shortfall import distance
from llsrbm.planning.problem.task import Task
from llsrbm.planning.solve.jump_layout import INTERVALS
from llsrbm.planning.whole_body.feasible import feasible_of
from llsrbm.planning.whole_body.learned_file import knows
from llsrbm.planning.whole_body.nearest import SURE
from llsrbm.request.jump import STEPS, Jump, not_feasible
from llsrbm.request.tuning import Tuning
from llsrbm.robots import load_robot
from llsrbm.robots.robot import Robot

NOT_FOUND = "no motion of the whole body that keeps all limits was found"
"""Why a request has a draft and no plan; a sentence without its full stop."""
# Score below which a jump is not solved as it is, neither from the table nor from its draft: of 82
# such requests of Go2's and ANYmal's (of 600, seeds 10061, 10062 and 10072) two were ever
# certified.
UNLIKELY = -1.0
# Shares of the ranges by which less is done than was asked, from which on drafts are not tried: of
# 33 such requests of ANYmal's and Go2's (seed 77, with 60, 80 and 100 % of the torque), 0.07 to 0.4
# off, three had a draft, and none a plan that is certified; all was found of one that is 0.056 off.
FAR = 0.06


def all_or_less(
    planner: CertifiedPlanner, task: Task, intervals: int = INTERVALS, *, less: bool = True
) -> Nearest | None:
    """The certified plan of a task's jump, or of `less`, begun from the robot's table; None: none.

    Raises:
        Cancelled: it is not wanted any more.
    """
    if not is_unlikely(task.jump, task.tuning):
        found = planner.from_table(task, intervals)
        if found is not None:
            return Nearest(found, None)
    return planner.nearest(task, intervals, less=less)


def whole_or_nearest(
    planner: CertifiedPlanner, draft: Plan, wanted: Jump, near: Nearest | None
) -> Plan:
    """The whole body's plan of a draft; without a certificate that holds where none is found.

    Args:
        planner: of whole bodies' plans.
        draft: a centroidal plan, of the request or of the nearest jump that has one.
        wanted: the request.
        near: what `all_or_less` has found of less.

    Raises:
        Cancelled: it is not wanted any more.
        NotConverged: less alone is found; its `nearest` is that.
    """
    all_of_it = not _given_up(draft.jump, wanted)
    if near is None or (all_of_it and not is_unlikely(draft.jump, draft.tuning)):
        # What is nearest need not be this one: a solver of a finer grid is not built for it.
        whole = replace(planner, guesses=False, finer=planner.finer and all_of_it).plan(draft)
        if near is None or whole.certified or not may_hold_elsewhere(whole):
            return whole
    raise less_alone(near, wanted)


def less_alone(near: Nearest, wanted: Jump) -> NotConverged:
    """That less of a request alone has a plan."""
    stops = () if near.stop is None else (near.stop,)
    reason = str(near.stop or NOT_FOUND)
    message = not_feasible(reason, wanted, near.plan.jump)
    return NotConverged(message, near.plan, stops, near.plan, reason)


def is_unlikely(jump: Jump, tuning: Tuning) -> bool:
    """Whether that table says that a jump is hardly found; it is not with tighter limits either."""
    robot = load_robot(jump.robot)
    score = _score(jump, robot, Tuning() if _only_tightens(tuning, robot) else tuning)
    return score is not None and score < UNLIKELY


def is_likely(jump: Jump, tuning: Tuning) -> bool:
    """Whether that table is sure that a jump is found."""
    score = _score(jump, load_robot(jump.robot), tuning)
    return score is not None and score >= SURE


def gives_up(near: Nearest, task: Task) -> bool:
    """Whether nothing nearer is looked for by drafts: it is unlikely, or too much is given up."""
    far = distance(task, near.plan.jump) > FAR
    return far or is_unlikely(task.jump, task.tuning)


def _score(jump: Jump, robot: Robot, tuning: Tuning) -> float | None:
    """Its score; None: the robot has no table, or it knows nothing of such jumps."""
    feasible = feasible_of(robot) if knows(jump, tuning) else None
    return None if feasible is None else feasible.score(jump)


def _only_tightens(tuning: Tuning, robot: Robot) -> bool:
    """Whether limits are the robot's own or tighter, and no weight is another one."""
    if tuning.weights:
        return False
    own = limits_of(robot) if tuning.limits else {}
    pairs = [(*own[name], value) for name, value in tuning.limits.items() if name in own]
    return not any(
        value < usual if limit.lower_bound else value > usual for limit, usual, value in pairs
    )


def _given_up(jump: Jump, wanted: Jump) -> bool:
    """Whether a jump does less than was asked."""
    return any(
        abs(getattr(wanted, name) - getattr(jump, name)) > step / 2 for name, step in STEPS.items()
    )
