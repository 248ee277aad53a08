"""One tab: its request, its plan, its picture. One thread does everything, in order.

viser calls back from threads of its own, and a browser may skip values, so callbacks only say that
something happened; this thread then reads the controls as they stand. The latest counts.
"""

from __future__ import annotations

import math
import queue
import tempfile
import threading
import time
from enum import Enum
from pathlib import Path

import viser

from app import markup
from app.pace import Pace
from app.panel import Action, Panel
from app.player import ServerPlayer
from app.protocol import Cancelled, Failed, PlanJump, Planned, Prepare, Prepared, Progress, Report
from app.replay import bake, figures, presentable
from app.scene import Scene
from app.worker_client import WorkerClient
from llsrbm.errors import Error
from llsrbm.exporters import export, suffix
from llsrbm.jump import Jump
from llsrbm.robots import Robot, load_robot
from llsrbm.trajectory.plan import Plan

_TIME_SHOWN_EVERY = 0.1  # s; the timeline follows the picture more slowly, to spare the line
FIRST_JUMP = Jump(twist=math.radians(90))
"""What a tab begins with: the motion that shows most clearly what drawing in the legs does."""


class _Stop(Enum):
    STOP = 0


class Session:
    """A tab's state; `start` runs its thread until `close`."""

    def __init__(self, client: viser.ClientHandle, worker: WorkerClient) -> None:
        """Nothing happens before `start`.

        Args:
            client: the tab.
            worker: plans for all tabs.
        """
        self._client = client
        self._worker = worker
        self._inbox: queue.SimpleQueue[Action | Report | _Stop] = queue.SimpleQueue()
        self._thread = threading.Thread(
            target=self._run, name=f"session-{client.client_id}", daemon=True
        )
        self._pace = Pace(self._ask_tab, lambda: self._player.playing)
        self.jump = FIRST_JUMP
        self.plan: Plan | None = None
        self._robot: Robot | None = None
        self._preparing = False
        self._awaiting = False  # an outcome of the newest job
        self._asked: Jump | None = None  # what the newest job plans
        self._job = 0  # the newest job; reports of older ones are news, but not the end
        self._shown_job = 0
        self._time_shown = 0.0

    def start(self) -> None:
        """Build the page and begin to plan."""
        self._thread.start()

    def close(self) -> None:
        """The tab has gone, or the server ends."""
        self._worker.forget(self._client.client_id)
        self._pace.close()
        self._inbox.put(_Stop.STOP)
        self._thread.join()

    # ---- the thread

    def _run(self) -> None:
        self._panel = Panel(
            self._client, self.jump, load_robot(self.jump.robot).file, self._inbox.put
        )
        try:
            self._scene = Scene(self._client)
            self._player = ServerPlayer(self._show_instant, self._frame_rate)
            self._pace.start()
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
                elif not isinstance(event, _Stop):
                    self._hear(event)
            self._player.step()

    def _next_events(self) -> list[Action | Report | _Stop]:
        """What has happened, each kind of action once; waits until something has or is due."""
        try:
            first = self._inbox.get(timeout=self._player.wait)
        except queue.Empty:
            return []
        events: dict[Action | Report | _Stop, None] = {first: None}
        while True:
            try:
                event = self._inbox.get_nowait()
            except queue.Empty:
                return list(events)
            # The latest of its kind counts: play, pause, play is play.
            events.pop(event, None)
            events[event] = None

    def _act(self, action: Action) -> None:
        match action:
            case Action.REQUEST:
                self._request()
            case Action.CANCEL:
                self._worker.cancel(self._client.client_id)
            case Action.PLAY:
                self._player.play()
            case Action.PAUSE:
                self._player.pause()
                self._show_time()
            case Action.SCRUB:
                self._player.pause()
                self._player.seek(self._panel.read_time())
            case Action.PACE:
                speed, loop = self._panel.read_pace()
                self._player.set_speed(speed)
                self._player.set_loop(loop)
            case Action.LAYERS:
                self._scene.show_layers(**self._panel.read_layers())
                self._player.seek(self._player.time)
            case Action.EXPORT:
                self._export()

    # ---- planning

    def _request(self) -> None:
        jump, complaints = self._panel.read_jump(self.jump)
        if complaints:
            self._panel.notify("Corrected", "; ".join(complaints))
            self._panel.show_jump(jump)
        robot_changed = jump.robot != self.jump.robot
        self.jump = jump
        if robot_changed or (self._robot is None and not self._preparing):
            self._prepare()
        elif self._robot is not None and jump != self._asked:
            self._ask()

    def _prepare(self) -> None:
        self._robot = None
        self._asked = None
        self._preparing = self._awaiting = True
        self._job = self._worker.submit(
            self._client.client_id, Prepare(self.jump.robot), self._inbox.put
        )
        self._panel.show_status("Planning", "begins when the robot is ready.", busy=True)

    def _ask(self) -> None:
        self._asked = self.jump
        self._awaiting = True
        self._job = self._worker.submit(
            self._client.client_id, PlanJump(self.jump), self._inbox.put
        )
        self._panel.show_status("Planning", "...", busy=True)

    def _hear(self, report: Report) -> None:
        newest = report.job == self._job
        if newest and not isinstance(report, Progress):
            self._preparing = self._awaiting = False
        match report:
            case Progress():
                if newest:
                    self._panel.show_status("Planning", f"({report.text}) ...", busy=True)
            case Prepared():
                if newest:
                    self._show_robot(report.robot)
            case Planned():
                # An older one is still worth showing while the slider moves.
                self._show_plan(report.plan, report.job)
                if newest:
                    self._panel.show_status("Planned", markup.planned_line(report.plan))
            case Failed():
                if newest:
                    self._fail(report)
            case Cancelled():
                if newest:
                    self._asked = None
                    self._panel.show_status("Cancelled", "Move a slider to plan again.")

    def _show_robot(self, name: str) -> None:
        try:
            robot = load_robot(name)
        except Error as error:
            self._panel.show_status("Failed", str(error))
            return
        self._robot = robot
        self.plan = None
        self._panel.clear_plan()
        self._panel.show_robot(robot.file)
        self._scene.show_robot(robot)
        self._request()
        if self._asked is None:
            self._ask()

    def _show_plan(self, plan: Plan, job: int) -> None:
        if self._robot is None or plan.jump.robot != self._robot.name or job < self._shown_job:
            return
        first = self.plan is None
        self._shown_job = job
        self.plan = plan
        replay = bake(plan, self._robot)
        with self._client.atomic():
            self._scene.show_replay(replay)
            self._panel.show_plan(plan, figures(replay, self._robot))
            self._player.load(plan.duration)
            if first:
                self._player.play()
            self._show_time()

    def _fail(self, report: Failed) -> None:
        self._asked = None
        message = report.message
        if report.plan is not None and presentable(report.plan):
            self._show_plan(report.plan, report.job)
            message += " The picture shows where the solver stopped; it is no feasible motion."
        self._panel.show_status("Failed", message)

    # ---- playing

    def _show_instant(self, instant: float) -> None:
        self._scene.show_instant(instant)
        now = time.monotonic()
        if not self._player.playing or now - self._time_shown > _TIME_SHOWN_EVERY:
            self._show_time()

    def _show_time(self) -> None:
        self._time_shown = time.monotonic()
        self._panel.show_time(self._player.time, playing=self._player.playing)

    def _frame_rate(self) -> float:
        return self._pace.rate_while_planning() if self._awaiting else self._pace.rate()

    def _ask_tab(self) -> None:
        """Return when the browser has worked off what it was sent."""
        self._client.local_storage.get_item("llsrbm", timeout=2.0)

    # ---- files

    def _export(self) -> None:
        if self.plan is None:
            self._panel.notify("Nothing to export", "There is no plan yet.")
            return
        name, complaints = self._panel.read_format()
        if complaints:
            self._panel.notify("Corrected", "; ".join(complaints))
        jump = self.plan.jump
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / f"{jump.robot}-{jump.model}{suffix(name)}"
            try:
                export(self.plan, path, format=name)
            except Error as error:
                self._panel.notify("Not exported", str(error))
                return
            self._client.send_file_download(path.name, path.read_bytes(), save_immediately=True)
