"""The finished plan with which a new tab begins, so that its first picture is a robot that jumps.

There are three sources, the best first: the plan of this very server; the one that an earlier
server of the same version kept in the user's cache; the one that comes with the package, in
`assets/plans` (made by `python -m benchmarks.initial_plans`), so that something moves on a
machine's very first start while its solvers are still being built.
"""

from __future__ import annotations

import logging
import tempfile
import threading
from importlib.metadata import version
from pathlib import Path

import llsrbm
from app.workers.file_reading import differing
from app.workers.opened_file import OpenedFile
from llsrbm.cache import cache_path, content_key, read_checked, write_checked
from llsrbm.errors import Error
from llsrbm.installed import assets_directory
from llsrbm.motion.plan import Plan, load_plan
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot
from llsrbm.robots.schema import read_robot_file, robot_files

LIBRARY_PLANNER = "app.workers.worker.LibraryPlanner"
"""The planner whose plans come with the package."""

_log = logging.getLogger(__name__)

# What a plan depends on besides our own sources and the robot file.
_PACKAGES = ("casadi", "example-robot-data", "numpy", "pin", "scipy")


class InitialPlans:
    """The plan of each robot's example, once it is there, or a file in place of all of them.

    Files are read and written, and sources hashed, by the thread that calls `recall` or `keep`,
    never under the lock.
    """

    def __init__(self, planned_by: str, file: OpenedFile | None = None, note: str = "") -> None:
        """Other planners' plans than `planned_by`'s are not recalled; tabs begin with `file`."""
        self.note = note  # a sentence on the server, to begin with
        # with which every tab begins; None: with the design that its browser kept, or with the
        # example
        self.file = file
        self._planned_by = planned_by
        self._plans: dict[str, Plan] = {}
        self._lock = threading.Lock()

    def plan(self, robot: str) -> Plan | None:
        """Of the robot's example with the default model; None as long as it is not there."""
        with self._lock:
            return self._plans.get(robot)

    def recall(self, robot: str) -> None:
        """Take the plan that an earlier server of this version kept, else the one that ships."""
        plan = self._kept(robot)
        if plan is None and self._planned_by == LIBRARY_PLANNER:
            plan = shipped_plan(robot)
        if plan is not None:
            with self._lock:
                self._plans.setdefault(robot, plan)

    def keep(self, plan: Plan) -> None:
        """Begin with that plan from now on; it is of its robot's example."""
        with self._lock:
            self._plans[plan.jump.robot] = plan
        try:
            with tempfile.TemporaryDirectory() as folder:
                path = Path(folder) / "plan.npz"
                plan.save(path)
                write_checked(self._entry(plan.jump.robot), path.read_bytes())
        except (OSError, Error) as error:
            _log.warning("the initial plan of %s is not kept (%s)", plan.jump.robot, error)

    def _kept(self, robot: str) -> Plan | None:
        content = read_checked(self._entry(robot))
        if content is None:
            return None
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "plan.npz"
            path.write_bytes(content)
            try:
                return load_plan(path)
            except Error as error:
                _log.warning("the kept plan of %s cannot be read (%s)", robot, error)
                return None

    def _entry(self, robot: str) -> Path:
        sources = sorted(Path(llsrbm.__file__).parent.rglob("*.py"))
        packages = repr([(name, version(name)) for name in _PACKAGES])
        request = f"{self._planned_by} {example(robot)}"
        key = content_key(request, packages, robot_files()[robot], *sources)
        return cache_path(f"initial-plans-{robot}", key, ".npz")


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
