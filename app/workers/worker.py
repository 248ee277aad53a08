"""A computing process: works on one job at a time and reports its progress and its outcome."""

from __future__ import annotations

import signal
import tempfile
from collections.abc import Callable
from functools import partial
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Protocol

import llsrbm
from app.workers.opened_file import OpenedFile
from app.workers.planner import Array, Planner, PlannerFactory, ProgressListener, SoFarListener
from app.workers.protocol import (
    Cancelled,
    Exported,
    ExportMotion,
    Failed,
    FindNearest,
    Found,
    Job,
    Nearest,
    Opened,
    OpenFile,
    PlanJump,
    Planned,
    Prepare,
    Prepared,
    Progress,
    Ready,
    Report,
    SeedDone,
    SeedResult,
    Simulated,
    SimulatedSeeds,
    SimulatedSoFar,
    SimulateJump,
    SimulateSeeds,
    Solver,
    solver_of,
)
from app.workers.seeds import simulate_seeds
from llsrbm import errors
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.request.jump import Jump


class SharedNumber(Protocol):
    """An integer both processes see (`multiprocessing.Value`)."""

    value: int


class LibraryPlanner:
    """Planner and simulator of the library, for robots found by name."""

    def __init__(self) -> None:
        """Import what takes long, once, before the first job."""
        import llsrbm.api  # noqa: F401

        self._solvers: set[Solver] = set()
        self._replanned: set[Solver] = set()  # whose remains have been planned anew

    def prepare(self, robot: str, progress: ProgressListener) -> None:
        """See `app.workers.planner.Planner.prepare`."""
        from llsrbm.look.visuals import link_visuals
        from llsrbm.robots import load_robot

        progress(f"fitting the legs of {robot}")
        loaded = load_robot(robot)
        loaded.fit  # noqa: B018  # computed on first use, then kept on disk
        progress(f"simplifying the meshes of {robot}")
        link_visuals(loaded, coarse=True)

    def plan(
        self, task: PlanJump, progress: ProgressListener, cancelled: Callable[[], bool]
    ) -> Plan:
        """See `app.workers.planner.Planner.plan`."""
        self._announce(task.jump, progress)
        # What the page shows may be no plan to start from: of another solver, or from a file.
        near = task.near
        if near is not None and (
            near.solution is None or solver_of(near.jump) != solver_of(task.jump)
        ):
            near = None
        plan = partial(
            llsrbm.plan,
            task.jump,
            weights=task.tuning.weights,
            limits=task.tuning.limits,
            patient=task.patient,
            progress=lambda p: progress(p.text, iteration=p.iteration, residual=p.residual),
            cancelled=cancelled,
        )
        if near is not None:
            try:
                return plan(near=near)
            except errors.InputError:
                # A file of another version of the planner, or made up; a request that cannot be
                # planned is refused without it, too.
                pass
        return plan(near=None)

    def nearest(
        self, task: FindNearest, progress: ProgressListener, cancelled: Callable[[], bool]
    ) -> Nearest:
        """See `app.workers.planner.Planner.nearest`."""
        self._announce(task.jump, progress)
        found: Nearest = llsrbm.nearest(
            task.jump,
            weights=task.tuning.weights,
            limits=task.tuning.limits,
            progress=progress,
            cancelled=cancelled,
        )
        return found

    def simulate(
        self,
        task: SimulateJump,
        progress: ProgressListener,
        so_far: SoFarListener,
        cancelled: Callable[[], bool],
    ) -> Rollout:
        """See `app.workers.planner.Planner.simulate`."""
        jump = task.plan.jump
        if task.scenario.replan and solver_of(jump) not in self._replanned:
            progress(
                f"building the solvers that plan anew, of {jump.model} for {jump.robot}: a minute, "
                "the first time"
            )
            self._replanned.add(solver_of(jump))
        shown = -1
        reached = 0.0

        def percent(share: float) -> None:
            # A simulation reports every few ticks; readers want whole per cents.
            nonlocal shown, reached
            reached = share
            if int(100 * share) > shown:
                shown = int(100 * share)
                progress(f"simulating, {shown} %", share=share)

        return llsrbm.simulate(
            task.plan,
            task.scenario,
            cancelled=cancelled,
            progress=percent,
            so_far=lambda time, qpos: so_far(reached, time, qpos),
        )

    def open(self, task: OpenFile, progress: ProgressListener) -> OpenedFile:
        """See `app.workers.planner.Planner.open`."""
        from app.workers.file_reading import open_file

        progress(f"opening {task.name}")
        opened = open_file(task.name, task.content, task.robot, task.fps)
        self.prepare(opened.robot, progress)
        return opened

    def export(self, task: ExportMotion, progress: ProgressListener) -> tuple[str, bytes]:
        """See `app.workers.planner.Planner.export`."""
        progress(f"writing {', '.join(task.formats)}")
        return exported(task)

    def _announce(self, jump: Jump, progress: ProgressListener) -> None:
        if solver_of(jump) not in self._solvers:
            progress(
                f"building the solver of {jump.model} for {jump.robot}: half a minute, the first "
                "time"
            )
        self._solvers.add(solver_of(jump))


def exported(task: ExportMotion) -> tuple[str, bytes]:
    """Name and content of the one file that an export makes.

    Raises:
        llsrbm.errors.Error: as `llsrbm.export`.
    """
    from llsrbm.formats.exporting import file_name, stem

    name = (
        f"{stem(task.trajectory)}.zip" if task.zipped else file_name(task.trajectory, task.formats)
    )
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / name
        llsrbm.export(task.trajectory, path, format=task.formats, **task.options)
        return name, path.read_bytes()


def main(connection: Connection, stop: SharedNumber, factory: PlannerFactory) -> None:
    """Work until the server closes its end of the connection.

    An exception that is no `llsrbm.errors.Error` is a defect: it ends the process with a traceback
    in the terminal, and the server reports that to the user.

    Args:
        connection: jobs come in, reports go out.
        stop: number of the job whose result nobody needs any more.
        factory: makes the planner.
    """
    # Ctrl-C reaches every process of the terminal; the server decides when this one ends.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        planner = factory()
        connection.send(Ready())
        while True:
            job: Job = connection.recv()
            connection.send(_work(planner, job, connection, stop))
    except (EOFError, BrokenPipeError, ConnectionResetError):
        return


def _work(planner: Planner, job: Job, connection: Connection, stop: SharedNumber) -> Report:
    number, task = job.number, job.task

    def progress(
        text: str,
        *,
        share: float | None = None,
        iteration: int | None = None,
        residual: float | None = None,
    ) -> None:
        connection.send(Progress(number, text, share, iteration, residual))

    def so_far(share: float, time: Array, qpos: Array) -> None:
        connection.send(SimulatedSoFar(number, share, time, qpos))

    def seed_done(result: SeedResult, done: int, of: int) -> None:
        connection.send(SeedDone(number, result, done, of))

    def cancelled() -> bool:
        return stop.value == number

    try:
        match task:
            case Prepare(robot):
                planner.prepare(robot, progress)
                return Prepared(number, robot)
            case PlanJump():
                return Planned(number, planner.plan(task, progress, cancelled))
            case FindNearest():
                return Found(number, planner.nearest(task, progress, cancelled))
            case SimulateJump():
                return Simulated(number, planner.simulate(task, progress, so_far, cancelled))
            case SimulateSeeds():
                results, worst = simulate_seeds(planner, task, progress, seed_done, cancelled)
                return SimulatedSeeds(number, results, worst)
            case OpenFile():
                return Opened(number, planner.open(task, progress))
            case ExportMotion():
                return Exported(number, *planner.export(task, progress))
    except errors.Cancelled:
        return Cancelled(number)
    except errors.NotConverged as error:
        return Failed(number, str(error), error.plan)
    except errors.Error as error:
        return Failed(number, str(error))
