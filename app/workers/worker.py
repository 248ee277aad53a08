"""A computing process: works on one job at a time and reports its progress and its outcome."""

from __future__ import annotations

import logging
import sys
import tempfile
from collections.abc import Callable
from dataclasses import replace
from multiprocessing.connection import Connection
from pathlib import Path
from typing import TYPE_CHECKING, Any

import llsrbm
from app.workers import reports, spare_solvers, tasks
from app.workers.opened_file import OpenedFile, States
from llsrbm import errors
from llsrbm.arrays import Array
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.request.jump import Jump

if TYPE_CHECKING:
    from llsrbm.certificate import Certificate
    from llsrbm.largest_jump import Largest
    from llsrbm.repairing.result import Repair

_log = logging.getLogger(__name__)

_LOADING, _BUILDING = 4.0, 10.0  # s, about, that a solver takes

ProgressListener = Callable[..., None]  # `app.workers.reports.Talk.progress`


class LibraryPlanner:
    """Planner and simulator of the library, for robots found by name.

    Made once in each process and kept, its solvers warm. Methods raise `llsrbm.errors.Error`; those
    that take `cancelled` call it now and then and raise `Cancelled` when it is true.
    """

    most_memory = 900e6  # Bytes; a process that holds more is replaced by a new one

    def __init__(self) -> None:
        import llsrbm.api  # noqa: F401  # takes long: before the first job

        self._solvers: set[tasks.Solver] = set()
        self._spare: set[tasks.Solver] = set()  # beside which others are being built
        self._refined: set[tasks.Solver] = set()  # of which a plan has been refined
        self._replanned: set[tasks.Solver] = set()  # with which a flight has been planned anew

    def prepare(self, robot: str, progress: ProgressListener) -> None:
        """Compute or load everything that drawing `robot` needs."""
        from llsrbm.look.titles import title_of_robot
        from llsrbm.look.visuals import link_visuals
        from llsrbm.robots import load_robot

        progress(f"measuring the legs of {title_of_robot(robot)}")
        loaded = load_robot(robot)
        loaded.fit  # noqa: B018  # computed on first use, then kept on disk
        progress(f"preparing the picture of {title_of_robot(robot)}")
        link_visuals(loaded, coarse=True)

    def plan(
        self, task: tasks.PlanJump, progress: ProgressListener, cancelled: Callable[[], bool]
    ) -> Plan:
        """Plan a jump: a route by the whole body, from plans of its jumps; others as drafts.

        One that is to be by the whole body at once is so if the robot's table is sure of it, and
        its solver is at hand.
        """
        if task.jump.route or (task.whole_body and self._is_sure(task)):
            found = self._from_table(task, progress, cancelled)
            if found is not None:
                return found
        self._announce(task, progress)
        # The plan that the page shows may be no start: of another solver, or without an iterate.
        near = task.near
        if near is not None and (
            near.solution is None or tasks.solver_of(near.jump, near.tuning) != task.needs
        ):
            near = None
        self._build_beside(task)
        how: dict[str, Any] = {
            "weights": task.tuning.weights,
            "limits": task.tuning.limits,
            "patient": not task.alone,
            "hurried": not task.patient,
            "draft": True,  # the whole body's follows once the request has rested
            "progress": lambda p: progress(p.text, iteration=p.iteration, residual=p.residual),
            "cancelled": cancelled,
        }
        try:
            return llsrbm.plan(task.jump, near=near, **how)
        except errors.UnusableStart as error:  # from a file of another version, or made up
            _log.info("planned without the plan that is shown: %s", error)
            return llsrbm.plan(task.jump, near=None, **how)

    def refine(
        self, task: tasks.RefinePlan, progress: ProgressListener, cancelled: Callable[[], bool]
    ) -> Plan:
        """The whole body's plan, where its robot has a table as the command line makes it.

        Else from the draft, or that itself. Raises `NotConverged`: less alone is found.
        """
        from llsrbm.certified_nearest import whole_or_nearest
        from llsrbm.certified_plan import CertifiedPlanner
        from llsrbm.planning.whole_body.feasible import begins_from_table

        self._announce_whole_body(task.plan.jump, progress)
        how: dict[str, Any] = {
            "progress": lambda p: progress(p.text, iteration=p.iteration, residual=p.residual),
            "cancelled": cancelled,
        }
        tuning = task.plan.tuning
        if begins_from_table(task.wanted, tuning):
            return llsrbm.plan(task.wanted, weights=tuning.weights, limits=tuning.limits, **how)
        return whole_or_nearest(CertifiedPlanner(**how), task.plan, task.wanted, None)

    def largest(
        self, task: tasks.FindLargest, progress: ProgressListener, cancelled: Callable[[], bool]
    ) -> Largest:
        """The largest jump in one direction, without those on the way to it."""
        self._announce_whole_body(task.jump, progress)
        found = llsrbm.largest(
            task.jump,
            task.towards,
            weights=task.tuning.weights,
            limits=task.tuning.limits,
            progress=lambda p: progress(p.text, iteration=p.iteration, residual=p.residual),
            cancelled=cancelled,
        )
        return replace(found, smaller=())

    def simulate(
        self,
        task: tasks.SimulateJump,
        progress: ProgressListener,
        so_far: Callable[[float, Array, Array], None],
        cancelled: Callable[[], bool],
    ) -> Rollout:
        """Simulate a plan; progress comes with the share that is done."""
        jump = task.plan.jump
        if task.scenario.replan and tasks.solver_of(jump) not in self._replanned:
            progress(
                f"building the solvers that plan anew, {_of_whom(jump)}: half a minute, "
                "the first time",
                lasts=3 * _BUILDING,
            )
            self._replanned.add(tasks.solver_of(jump))
        shown = -1
        reached = 0.0

        def percent(share: float) -> None:
            # A simulation reports every few ticks; readers want whole per cents.
            nonlocal shown, reached
            reached = share
            if int(100 * share) > shown:
                shown = int(100 * share)
                progress(f"simulating, {shown} %", share=share)

        if task.wire:
            return _played(task, percent, cancelled)
        return llsrbm.simulate(
            task.plan,
            task.scenario,
            cancelled=cancelled,
            progress=percent,
            so_far=lambda time, qpos: so_far(reached, time, qpos),
        )

    def open(self, task: tasks.OpenFile, progress: ProgressListener) -> OpenedFile:
        """Read a file, and prepare its robot."""
        from app.workers.file_reading import open_file

        opened = open_file(task.name, task.content, task.robot, task.fps)
        self.prepare(opened.robot, progress)
        return opened

    def open_motion(self, task: tasks.OpenMotion, progress: ProgressListener) -> OpenedFile:
        """Open a motion of the library, whose certificate is checked again."""
        from app.workers.opened_file import OpenedFile
        from llsrbm.library import shipped

        progress("checking the motion at 1 kHz")
        plan = shipped().open(task.name)
        self.prepare(plan.jump.robot, progress)
        return OpenedFile(task.name, plan)

    def export(self, task: tasks.ExportMotion, progress: ProgressListener) -> tuple[str, bytes]:
        """Name and content of the file that is made."""
        progress(f"writing {', '.join(task.formats)}")
        return exported(task)

    def check(self, task: tasks.CheckMotion, progress: ProgressListener) -> Certificate:
        """Certificate of a plan, a rollout or another tool's motion."""
        from llsrbm.certificate import certify

        progress("checking the motion at 1 kHz")
        motion = task.motion
        return certify(motion.motion() if isinstance(motion, States) else motion)

    def repair(
        self, task: tasks.RepairMotion, progress: ProgressListener, cancelled: Callable[[], bool]
    ) -> Repair:
        """The plan nearest to another tool's motion."""
        return llsrbm.repair(
            task.motion.motion(),
            progress=lambda p: progress(p.text, iteration=p.iteration, residual=p.residual),
            cancelled=cancelled,
        )

    def _is_sure(self, task: tasks.PlanJump) -> bool:
        from llsrbm.certified_nearest import is_likely

        return tasks.solver_of(task.jump) in self._refined and is_likely(task.jump, task.tuning)

    def _from_table(
        self, task: tasks.PlanJump, progress: ProgressListener, cancelled: Callable[[], bool]
    ) -> Plan | None:
        """The certified plan; None: it is not found from the robot's table."""
        from llsrbm.certified_plan import CertifiedPlanner
        from llsrbm.planning.problem.placement import make_task
        from llsrbm.robots import load_robot
        from llsrbm.robots.payload import with_payload

        self._announce_whole_body(task.jump, progress)
        robot = with_payload(load_robot(task.jump.robot), task.jump.payload)
        requested = make_task(task.jump, robot, task.tuning.weights, task.tuning.limits)
        planner = CertifiedPlanner(
            progress=lambda p: progress(p.text, iteration=p.iteration, residual=p.residual),
            cancelled=cancelled,
        )
        return planner.from_table(requested)

    def _build_beside(self, task: tasks.PlanJump) -> None:
        """Have what a slider that moves will be followed by built in a process of its own."""
        solver = tasks.solver_of(task.jump)
        if task.patient or solver in self._spare:
            return
        self._spare.add(solver)
        spare_solvers.build(task.jump)

    def _announce_whole_body(self, jump: Jump, progress: ProgressListener) -> None:
        from llsrbm.look.titles import title_of_robot

        solver = tasks.solver_of(jump)
        if solver not in self._refined:
            progress(
                f"building the whole-body solver of {title_of_robot(jump.robot)}: some seconds, "
                "the first time",
                lasts=_BUILDING,
            )
            self._refined.add(solver)

    def _announce(self, task: tasks.PlanJump, progress: ProgressListener) -> None:
        from llsrbm.planning.answer.planner import is_planner_built

        if task.needs not in self._solvers:
            whose = _of_whom(task.jump)
            if is_planner_built(task.jump, task.tuning.limits):
                progress(f"loading the solver {whose}", lasts=_LOADING)
            else:
                words = f"building the solver {whose}: ten seconds, the first time"
                progress(words, lasts=_BUILDING)
        self._solvers.add(task.needs)


def _of_whom(jump: Jump) -> str:
    """Model and robot of a jump's solver: "for Unitree Go2 by LL-SRBM+"."""
    from llsrbm.look.titles import title_of_model, title_of_robot

    return f"for {title_of_robot(jump.robot)} by {title_of_model(jump.model)}"


def exported(task: tasks.ExportMotion) -> tuple[str, bytes]:
    """Name and content of the one file that an export makes; raises as `llsrbm.export`."""
    from llsrbm.formats import file_name

    name = file_name(task.trajectory, task.formats, zipped=task.zipped)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / name
        llsrbm.export(task.trajectory, path, format=task.formats, **task.options)
        return name, path.read_bytes()


def main(connection: Connection, stop: Any, factory: tasks.PlannerFactory) -> None:
    """Work on jobs of a connection until it is closed; `stop`: number of a job to be stopped.

    An exception that is no `llsrbm.errors.Error` is a defect: it ends the process with a traceback
    in the terminal, and the server reports that to the user.
    """
    try:
        planner = factory()
        connection.send(reports.Ready())
        while True:
            job: tasks.Job = connection.recv()
            outcome = _work(planner, job, reports.Talk(job.number, connection.send, stop))
            if _memory() > planner.most_memory:
                connection.send(reports.Heavy())
            connection.send(outcome)
    except (EOFError, BrokenPipeError, ConnectionResetError):
        return


def _memory() -> float:
    """Bytes that this process holds now; without /proc, the most that it has held; 0: unknown."""
    try:
        import resource
    except ImportError:  # Windows
        return 0.0
    try:
        pages = int(Path("/proc/self/statm").read_text("ascii").split()[1])
        return pages * resource.getpagesize()
    except OSError:
        unit = 1 if sys.platform == "darwin" else 1024
        return unit * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def _work(planner: Any, job: tasks.Job, talk: reports.Talk) -> reports.Report:
    try:
        return job.task.work(planner, talk)
    except errors.Cancelled:
        return reports.Cancelled(job.number)
    except errors.Error as error:
        return reports.Failed(job.number, str(error))


def _played(
    task: tasks.SimulateJump, progress: Callable[[float], None], cancelled: Callable[[], bool]
) -> Rollout:
    """A plan as the player plays it. Raises `Error`: it stopped before the jump."""
    from llsrbm.motion.robot import robot_of
    from llsrbm.player.played import play_in

    played = play_in(task.plan, robot_of(task.plan), task.scenario, progress, cancelled)
    if played.rollout is None:
        raise errors.Error(f"the robot simulator: {played.ended.line}")
    return played.rollout
