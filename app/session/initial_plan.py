"""The finished plan with which a new tab begins, so that its first picture is a robot that jumps.

It is planned once a server, by the warm-up, and kept in the user's cache for the next server.
"""

from __future__ import annotations

import logging
import tempfile
import threading
from importlib.metadata import version
from pathlib import Path

import llsrbm
from app.compute.opened_file import OpenedFile
from llsrbm.cache import cache_path, content_key, read_checked, write_checked
from llsrbm.errors import Error
from llsrbm.jump import Jump
from llsrbm.motion.plan import Plan
from llsrbm.motion.plan_file import load_plan
from llsrbm.robots.assets import robot_files
from llsrbm.robots.schema import read_robot_file

_log = logging.getLogger(__name__)

# What a plan depends on besides our own sources and the robot file.
_PACKAGES = ("casadi", "example-robot-data", "numpy", "pin", "scipy")


class InitialPlans:
    """The plan of each robot's example, once it is there, or a file in place of all of them.

    Attributes:
        file: with which every tab begins; None: with the design that its browser kept, or with the
            example.
    """

    def __init__(self, planned_by: str, file: OpenedFile | None = None) -> None:
        """Nothing is known yet.

        Args:
            planned_by: name of the planner; another one's plans are not recalled.
            file: with which every tab shall begin.
        """
        self.file = file
        self._planned_by = planned_by
        self._plans: dict[str, Plan] = {}
        self._lock = threading.Lock()

    def plan(self, robot: str) -> Plan | None:
        """Of the robot's example with the default model; None as long as it is not there."""
        with self._lock:
            return self._plans.get(robot)

    def recall(self, robot: str) -> None:
        """Take the plan that an earlier server kept, if it would come out the same today."""
        content = read_checked(self._entry(robot))
        if content is None:
            return
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "plan.npz"
            path.write_bytes(content)
            plan = load_plan(path)
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
            _log.warning("the opening plan of %s is not kept (%s)", plan.jump.robot, error)

    def _entry(self, robot: str) -> Path:
        sources = sorted(Path(llsrbm.__file__).parent.rglob("*.py"))
        packages = repr([(name, version(name)) for name in _PACKAGES])
        request = f"{self._planned_by} {example(robot)}"
        key = content_key(request, packages, robot_files()[robot], *sources)
        return cache_path("opening", key, ".npz")


def example(robot: str) -> Jump:
    """The jump that shows what a robot can do, from its file."""
    file = read_robot_file(robot_files()[robot])
    return Jump(robot=file.name, **file.example.model_dump())
