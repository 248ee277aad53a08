"""The finished plan with which a new tab begins, so that its first picture is a robot that jumps.

It comes with the package, in `assets/plans` (made by `python -m benchmarks.initial_plans`), until
this server has made its own: so something moves while the solvers are still being built.
"""

import logging
import threading
from pathlib import Path

from app.workers.file_reading import differing
from app.workers.opened_file import OpenedFile
from llsrbm.errors import Error
from llsrbm.installed import assets_directory
from llsrbm.motion.plan import Plan, load_plan
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot
from llsrbm.robots.schema import read_robot_file, robot_files

LIBRARY_PLANNER = "app.workers.worker.LibraryPlanner"
"""The planner whose plans come with the package."""

_log = logging.getLogger(__name__)


class InitialPlans:
    """The plan of each robot's example, once it is there, or a file in place of all of them."""

    def __init__(self, planned_by: str, file: OpenedFile | None = None, note: str = "") -> None:
        """Plans that ship are not another planner's than `planned_by`; tabs begin with `file`."""
        # with which every tab begins; None: with the design that its browser kept, or with the
        # example
        self.file = file
        self.note = note  # a sentence on the server, to begin with
        self._planned_by = planned_by
        self._plans: dict[str, Plan] = {}
        self._lock = threading.Lock()

    def plan(self, robot: str) -> Plan | None:
        """Plan of the robot's example with the default model; None as long as it is not there."""
        with self._lock:
            return self._plans.get(robot)

    def recall(self, robot: str) -> None:
        """Take the plan that ships, unless there is one."""
        plan = shipped_plan(robot) if self._planned_by == LIBRARY_PLANNER else None
        if plan is not None:
            with self._lock:
                self._plans.setdefault(robot, plan)

    def keep(self, plan: Plan) -> None:
        """Begin with that plan of its robot's example, unless the one before is certified alone."""
        with self._lock:
            before = self._plans.get(plan.jump.robot)
            if plan.certified or before is None or not before.certified:
                self._plans[plan.jump.robot] = plan


def example(robot: str) -> Jump:
    """The jump that shows what a robot can do, from its file."""
    file = read_robot_file(robot_files()[robot])
    return Jump(robot=file.name, **file.example.model_dump())


def shipped_file(robot: str) -> Path:
    """The file of the robot's plan that comes with the package."""
    return assets_directory() / "plans" / f"{robot}.npz"


def shipped_plan(robot: str) -> Plan | None:
    """The robot's plan that comes with the package.

    None if there is none, or if it does not fit the robot file as it is now; a line in the terminal
    says so then.
    """
    path = shipped_file(robot)
    try:
        plan = load_plan(path)
        reason = _misfit(plan, robot)
    except (OSError, Error) as error:
        reason = " ".join(str(error).split())
    if not reason:
        return plan
    _log.warning(
        "%s is not used: %s. The first picture comes when the solver is built; "
        "`python -m benchmarks.initial_plans` makes the file anew.",
        path,
        reason,
    )
    return None


def _misfit(plan: Plan, robot: str) -> str:
    """Why a plan is not the one of the robot's example, in words; "" if it is."""
    if plan.jump != example(robot):
        return f"it is of another request ({plan.jump})"
    if not plan.solved:
        return "its planner did not converge"
    names = differing(plan.robot_parameters, load_robot(robot).parameters())
    return f"the robot differs ({', '.join(names):.120})" if names else ""
