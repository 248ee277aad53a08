"""One tab: its request, its plan, its simulation. One thread does everything, in order.

viser calls back from threads of its own, and a browser may skip values, so callbacks only say that
something happened; this thread then reads the controls as they stand. The latest counts.
"""

from __future__ import annotations

import queue
import threading
from contextlib import closing
from enum import Enum

import viser

from app import summaries
from app.bridge import Bridge, PageEvent
from app.download import exported
from app.panel import Action, Panel
from app.protocol import (
    Cancelled,
    Failed,
    PlanJump,
    Planned,
    Prepare,
    Prepared,
    Progress,
    Report,
    Simulated,
    SimulateJump,
    Task,
)
from app.replay import presentable
from app.stage import Stage
from app.worker_pool import WorkerPool
from llsrbm.errors import Error
from llsrbm.jump import Jump
from llsrbm.robots import Robot, load_robot, read_robot_file
from llsrbm.robots.assets import robot_files
from llsrbm.trajectory.plan import Plan
from llsrbm.trajectory.rollout import Rollout


class _Stop(Enum):
    STOP = 0


class Session:
    """A tab's state; `start` runs its thread until `close`."""

    def __init__(self, client: viser.ClientHandle, pool: WorkerPool) -> None:
        """Nothing happens before `start`.

        Args:
            client: the tab.
            pool: plans and simulates for all tabs.
        """
        self._client = client
        self._pool = pool
        self._inbox: queue.SimpleQueue[Action | PageEvent | Report | _Stop] = queue.SimpleQueue()
        self._thread = threading.Thread(
            target=self._run, name=f"session-{client.client_id}", daemon=True
        )
        self._file = read_robot_file(robot_files()[Jump().robot])
        self.jump = Jump(robot=self._file.name, **self._file.example.model_dump())
        self._robot: Robot | None = None
        self._awaited: Task | None = None  # the newest job's, until its outcome is there
        self._asked: Jump | None = None  # what the newest plan was asked for
        self._job = 0  # the newest job; reports of older ones are news, but not the end
        self._shown_job = 0

    @property
    def plan(self) -> Plan | None:
        """The plan that is shown."""
        return self._stage.plan

    @property
    def rollout(self) -> Rollout | None:
        """The simulation that is shown."""
        return self._stage.rollout

    def start(self) -> None:
        """Build the page and begin to plan."""
        self._thread.start()

    def close(self) -> None:
        """The tab has gone, or the server ends."""
        self._pool.forget(self._client.client_id)
        self._inbox.put(_Stop.STOP)
        self._thread.join()

    # ---- the thread

    def _run(self) -> None:
        self._panel = Panel(self._client, self.jump, self._file, self._inbox.put)
        try:
            bridge = Bridge(self._client, self._inbox.put)
            with closing(Stage(self._client, self._panel, bridge)) as self._stage:
                self._prepare()
                self._loop()
        except BaseException:
            self._panel.show_status("Failed", "by a defect of this page; reload it, please.")
            raise

    def _loop(self) -> None:
        while True:
            events = self._next_events()
            if _Stop.STOP in events:
                return
            for event in events:
                if isinstance(event, Action):
                    self._act(event)
                elif isinstance(event, PageEvent):
                    self._stage.hear(event)
                elif not isinstance(event, _Stop):
                    self._hear(event)
            self._stage.step()

    def _next_events(self) -> list[Action | PageEvent | Report | _Stop]:
        """What has happened, each kind of action once; waits until something has or is due."""
        try:
            first = self._inbox.get(timeout=self._stage.wait)
        except queue.Empty:
            return []
        events: dict[Action | PageEvent | Report | _Stop, None] = {first: None}
        while True:
            try:
                event = self._inbox.get_nowait()
            except queue.Empty:
                return list(events)
            # The latest of its kind counts: play, pause, play is play.
            events.pop(event, None)
            events[event] = None

    def _act(self, action: Action) -> None:
        player = self._stage.player
        match action:
            case Action.REQUEST:
                self._request()
            case Action.SIMULATE:
                self._simulate()
            case Action.CANCEL:
                self._pool.cancel(self._client.client_id)
            case Action.PLAY:
                player.play()
            case Action.PAUSE:
                player.pause()
                self._stage.show_time()
            case Action.SCRUB:
                player.pause()
                player.seek(self._panel.read_time())
            case Action.PACE:
                speed, loop = self._panel.read_pace()
                player.set_speed(speed)
                player.set_loop(loop)
            case Action.LAYERS:
                self._stage.show_layers()
            case Action.EXPORT:
                self._export()

    # ---- asking

    def _request(self) -> None:
        jump, complaints = self._panel.jump.read(self.jump)
        robot_changed = jump.robot != self.jump.robot
        if robot_changed:
            # What was asked of the other robot is not for this one.
            self._panel.show_robot(read_robot_file(robot_files()[jump.robot]))
            jump, complaints = self._panel.jump.read(jump)
        if complaints:
            self._panel.notify("Corrected", "; ".join(complaints))
            self._panel.jump.show(jump)
        self.jump = jump
        preparing = isinstance(self._awaited, Prepare)
        if robot_changed or (self._robot is None and not preparing):
            self._prepare()
        elif self._robot is not None and jump != self._asked:
            self._plan()

    def _prepare(self) -> None:
        self._robot = None
        self._asked = None
        self._submit(Prepare(self.jump.robot))
        self._panel.show_status("Planning", "begins when the robot is ready.", busy=True)

    def _plan(self) -> None:
        self._asked = self.jump
        self._submit(PlanJump(self.jump))
        self._panel.show_status("Planning", "...", busy=True)

    def _simulate(self) -> None:
        plan = self.plan
        obstacle = ""
        if self._robot is None or plan is None:
            obstacle = "There is no plan yet."
        elif isinstance(self._awaited, PlanJump):
            obstacle = "The jump is still being planned."
        elif not plan.solved:
            obstacle = "The planner did not converge, so there is no motion to follow."
        if plan is None or obstacle:
            self._panel.notify("Not simulated", obstacle)
            return
        conditions, complaints = self._panel.simulation.read()
        if complaints:
            self._panel.notify("Corrected", "; ".join(complaints))
            self._panel.simulation.show(conditions)
        self._submit(SimulateJump(plan, conditions))
        self._panel.show_status("Simulating", "...", busy=True)

    def _submit(self, task: Task) -> None:
        self._awaited = task
        self._job = self._pool.submit(self._client.client_id, task, self._inbox.put)

    # ---- hearing

    def _hear(self, report: Report) -> None:
        newest = report.job == self._job
        task = self._awaited
        if newest and not isinstance(report, Progress):
            self._awaited = None
        match report:
            case Progress():
                if newest:
                    self._tell_progress(report)
            case Prepared():
                if newest:
                    self._show_robot(report.robot)
            case Planned():
                # An older one is still worth showing while the slider moves.
                self._show_plan(report.plan, report.job)
                if newest:
                    self._panel.show_status("Planned", summaries.planned_line(report.plan))
            case Simulated():
                # An older one is of another plan, or of another world.
                if newest:
                    self._stage.show_rollout(report.rollout)
                    self._panel.show_status(*summaries.simulated_line(report.rollout))
            case Failed():
                if newest:
                    self._fail(report, task)
            case Cancelled():
                if newest:
                    self._tell_cancelled(task)

    def _tell_progress(self, report: Progress) -> None:
        simulating = isinstance(self._awaited, SimulateJump)
        told = f"({report.text}) ..." if report.share is None else f"{report.share:.0%}"
        self._panel.show_status("Simulating" if simulating else "Planning", told, busy=True)

    def _tell_cancelled(self, task: Task | None) -> None:
        if isinstance(task, SimulateJump):
            self._panel.show_status("Cancelled", "The plan is still there.")
            return
        self._asked = None
        self._panel.show_status("Cancelled", "Move a slider to plan again.")

    def _show_robot(self, name: str) -> None:
        try:
            robot = load_robot(name)
        except Error as error:
            self._panel.show_status("Failed", str(error))
            return
        self._robot = robot
        self._stage.show_robot(robot)
        self._request()
        if self._asked is None:
            self._plan()

    def _show_plan(self, plan: Plan, job: int) -> None:
        if self._robot is None or plan.jump.robot != self._robot.name or job < self._shown_job:
            return
        self._shown_job = job
        self._stage.show_plan(plan)

    def _fail(self, report: Failed, task: Task | None) -> None:
        message = report.message
        if not isinstance(task, SimulateJump):
            self._asked = None
        if report.plan is not None and presentable(report.plan):
            self._show_plan(report.plan, report.job)
            message += " The picture shows where the solver stopped; it is no feasible motion."
        self._panel.show_status("Failed", message)

    # ---- files

    def _export(self) -> None:
        # What is drawn solid.
        shown = self.rollout or self.plan
        if shown is None:
            self._panel.notify("Nothing to export", "There is no plan yet.")
            return
        name, complaints = self._panel.read_format()
        if complaints:
            self._panel.notify("Corrected", "; ".join(complaints))
        try:
            file_name, content = exported(shown, name)
        except Error as error:
            self._panel.notify("Not exported", str(error))
            return
        self._client.send_file_download(file_name, content, save_immediately=True)
