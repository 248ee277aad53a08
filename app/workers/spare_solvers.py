"""Builds solvers that will be wanted next, beside all else (`-m app.workers.spare_solvers JUMP`).

Those of nearer jumps, for as soon as a request is not feasible, of jumps whose apex is dragged, and
those that plan anew in flight.
They take some ten seconds each, once on a machine. The process ends with the one that asked for it.
"""

from __future__ import annotations

import contextlib
import json
import subprocess
import sys

from llsrbm.ocp.compile_job import end_with, yield_to_others
from llsrbm.ocp.compiled import asker
from llsrbm.request.jump import Jump


def build(jump: Jump) -> None:
    """Begin to build those of a jump's robot, model and type, in a process of its own."""
    command = [sys.executable, "-m", __name__, json.dumps(jump.as_dict())]
    subprocess.Popen(command, stdin=asker(), start_new_session=True)


def main(text: str) -> None:
    """Build them; `text`: the jump as JSON."""
    from llsrbm.planning.answer.planner import planner_of
    from llsrbm.planning.problem.apex import APEX_LIMITS, FREE_APEX
    from llsrbm.request.scenario import Scenario
    from llsrbm.simulation.replanning import Replanning

    end_with(sys.stdin.fileno())
    yield_to_others()
    jump = Jump(**json.loads(text))
    planner = planner_of(jump)
    planner.prepare_nearest(jump)
    planner_of(jump, limits=dict(zip(APEX_LIMITS, FREE_APEX, strict=True)))
    plan = planner.plan(jump)
    Replanning(plan, planner.robot, 1 / planner.robot.file.control.rate, Scenario().replan_latency)


if __name__ == "__main__":
    with contextlib.suppress(SystemExit):  # nobody waits for it any more, and reads why
        main(sys.argv[1])
