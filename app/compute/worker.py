"""A computing process: plans and simulates, one job at a time, and reports what comes of it."""

from __future__ import annotations

import signal
import tempfile
from collections.abc import Callable
from functools import partial
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Protocol

import llsrbm
from app.compute.opened_file import OpenedFile
from app.compute.protocol import (
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
    Planner,
    PlannerFactory,
    Prepare,
    Prepared,
    Progress,
    Ready,
    Report,
    Simulated,
    SimulateJump,
    Tell,
)
from llsrbm import errors
from llsrbm.jump import Jump
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout


class SharedNumber(Protocol):
    """An integer both processes see (`multiprocessing.Value`)."""

    value: int


class LibraryPlanner:
    """Planner and simulator of the library, for robots found by name."""

    def __init__(self) -> None:
        """Import what takes long, once, before the first job."""
        import llsrbm.api  # noqa: F401

        self._solvers: set[tuple[str, str]] = set()

    def prepare(self, robot: str, tell: Tell) -> None:
        """See `app.compute.protocol.Planner.prepare`."""
        from llsrbm.robots import load_robot
        from llsrbm.robots.visuals import link_visuals

        tell(f"fitting the legs of {robot}")
        loaded = load_robot(robot)
        loaded.fit  # noqa: B018  # computed on first use, then kept on disk
        tell(f"simplifying the meshes of {robot}")
        link_visuals(loaded, coarse=True)

    def plan(self, task: PlanJump, tell: Tell, cancelled: Callable[[], bool]) -> Plan:
        """See `app.compute.protocol.Planner.plan`."""
        self._announce(task.jump.robot, task.jump.model, tell)
        # What the page shows may be no plan to start from: of another model, or from a file.
        near = task.near
        if near is not None and (near.solution is None or _solver(near.jump) != _solver(task.jump)):
            near = None
        plan = partial(
            llsrbm.plan,
            task.jump,
            weights=task.tuning.weights,
            limits=task.tuning.limits,
            patient=task.patient,
            progress=lambda p: tell(p.text, iteration=p.iteration, residual=p.residual),
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

    def nearest(self, task: FindNearest, tell: Tell, cancelled: Callable[[], bool]) -> Nearest:
        """See `app.compute.protocol.Planner.nearest`."""
        self._announce(task.jump.robot, task.jump.model, tell)
        found: Nearest = llsrbm.nearest(
            task.jump,
            weights=task.tuning.weights,
            limits=task.tuning.limits,
            progress=tell,
            cancelled=cancelled,
        )
        return found

    def simulate(self, task: SimulateJump, tell: Tell, cancelled: Callable[[], bool]) -> Rollout:
        """See `app.compute.protocol.Planner.simulate`."""
        told = -1

        def percent(share: float) -> None:
            # A simulation tells every few ticks; whoever looks at it reads whole per cents.
            nonlocal told
            if int(100 * share) > told:
                told = int(100 * share)
                tell(f"simulating, {told} %", share=share)

        return llsrbm.simulate(task.plan, task.scenario, progress=percent, cancelled=cancelled)

    def open(self, task: OpenFile, tell: Tell) -> OpenedFile:
        """See `app.compute.protocol.Planner.open`."""
        from app.compute.opened_file import open_file

        tell(f"opening {task.name}")
        opened = open_file(task.name, task.content, task.robot, task.fps)
        self.prepare(opened.robot, tell)
        return opened

    def export(self, task: ExportMotion, tell: Tell) -> tuple[str, bytes]:
        """See `app.compute.protocol.Planner.export`."""
        tell(f"writing {', '.join(task.formats)}")
        return exported(task)

    def _announce(self, robot: str, model: str, tell: Tell) -> None:
        if (robot, model) not in self._solvers:
            tell(f"building the solver of {model} for {robot}: half a minute, the first time")
        self._solvers.add((robot, model))


def _solver(jump: Jump) -> tuple[str, str]:
    return jump.robot, jump.model


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
    in the terminal, which the server notices and tells the user.

    Args:
        connection: jobs come in, reports go out.
        stop: number of the job that needs no result any more.
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
    def tell(
        text: str,
        *,
        share: float | None = None,
        iteration: int | None = None,
        residual: float | None = None,
    ) -> None:
        connection.send(Progress(job.number, text, share, iteration, residual))

    def cancelled() -> bool:
        return stop.value == job.number

    task = job.task
    try:
        if isinstance(task, Prepare):
            planner.prepare(task.robot, tell)
            return Prepared(job.number, task.robot)
        if isinstance(task, SimulateJump):
            return Simulated(job.number, planner.simulate(task, tell, cancelled))
        if isinstance(task, FindNearest):
            return Found(job.number, planner.nearest(task, tell, cancelled))
        if isinstance(task, OpenFile):
            return Opened(job.number, planner.open(task, tell))
        if isinstance(task, ExportMotion):
            return Exported(job.number, *planner.export(task, tell))
        return Planned(job.number, planner.plan(task, tell, cancelled))
    except errors.Cancelled:
        return Cancelled(job.number)
    except errors.NotConverged as error:
        return Failed(job.number, str(error), error.plan)
    except errors.Error as error:
        return Failed(job.number, str(error))
