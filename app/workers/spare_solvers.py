"""Builds solvers that will be wanted next, beside all else (`-m app.workers.spare_solvers JUMP`).

Those of jumps whose apex is dragged, and those that plan anew in flight. They take some ten seconds
each, once on a machine. The process ends with the one that asked for it.
"""

import contextlib
import json
import subprocess
import sys

from llsrbm.ocp.compile_job import end_with, yield_to_others
from llsrbm.ocp.compiled import asker
from llsrbm.request.jump import Jump


def build(jump: Jump) -> None:
    """Begin to build those of a jump's robot, model and type, in a process of its own.

    That one looks whether they are built, too, which can take longer than a plan.
    """
    command = [sys.executable, "-m", __name__, json.dumps(jump.as_dict())]
    subprocess.Popen(command, stdin=asker(), start_new_session=True)


def _free_apex() -> dict[str, float]:
    """Limits of the apex that limit nothing, of jumps that have them."""
    from llsrbm.planning.problem.apex import APEX_LIMITS, FREE_APEX

    return dict(zip(APEX_LIMITS, FREE_APEX, strict=True))


def main(text: str) -> None:
    """Build them, unless the first of them is there; `text`: the jump as JSON."""
    from llsrbm.planning.answer.planner import is_planner_built, planner_of
    from llsrbm.request.scenario import Scenario
    from llsrbm.simulation.replanning import Replanning

    end_with(sys.stdin.fileno())
    yield_to_others()
    jump = Jump(**json.loads(text))
    if is_planner_built(jump, _free_apex()):
        return
    planner = planner_of(jump)
    planner_of(jump, limits=_free_apex())
    plan = planner.plan(jump)
    Replanning(plan, planner.robot, 1 / planner.robot.file.control.rate, Scenario().replan_latency)


if __name__ == "__main__":
    with contextlib.suppress(SystemExit):  # nobody waits for it any more, and reads why
        main(sys.argv[1])
