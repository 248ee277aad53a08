"""One tab: its design, its plan, its simulation. One thread does everything, in order.

viser calls back from threads of its own, and a browser may skip values, so callbacks only say that
something happened; this thread then reads the controls as they stand. The latest counts.
"""

from __future__ import annotations

import queue
import threading
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import closing
from dataclasses import replace
from enum import Enum

import viser

from app import summaries
from app.bridge import Bridge, PageEvent
from app.files import Files
from app.live import Live
from app.opening import Opening
from app.panel import Action, Chosen, Panel, Uploaded
from app.protocol import (
    Cancelled,
    Failed,
    FindNearest,
    Found,
    Nearest,
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
from app.stored_design import recall, remember
from app.worker_pool import WorkerPool
from llsrbm.design import Design
from llsrbm.errors import Error
from llsrbm.examples import examples
from llsrbm.jump import Jump
from llsrbm.robots import Robot, load_robot, read_robot_file
from llsrbm.robots.assets import robot_files
from llsrbm.trajectory.plan import Plan
from llsrbm.trajectory.rollout import Rollout

_RECALL = 1.5  # s to wait for what the browser kept; it answers as soon as it shows the panel


class _Stop(Enum):
    STOP = 0


Event = Action | Chosen | Uploaded | PageEvent | Report | _Stop


class Session:
    """A tab's state; `start` runs its thread until `close`."""

    def __init__(self, client: viser.ClientHandle, pool: WorkerPool, opening: Opening) -> None:
        """Nothing happens before `start`.

        Args:
            client: the tab.
            pool: plans and simulates for all tabs.
            opening: plans that are there from the beginning.
        """
        self._client = client
        self._pool = pool
        self._opening = opening
        self._inbox: queue.SimpleQueue[Event] = queue.SimpleQueue()
        self._thread = threading.Thread(
            target=self._run, name=f"session-{client.client_id}", daemon=True
        )
        file = read_robot_file(robot_files()[Jump().robot])
        self.design = Design(Jump(robot=file.name, **file.example.model_dump()))
        self._file = file
        self._robot: Robot | None = None
        self._live = Live()
        self._awaited: Task | None = None  # the newest job's, until its outcome is there
        self._job = 0  # the newest job; reports of older ones are news, but not the end
        self._shown_job = 0
        self._simulate_next = False  # once the plan that is being made is there
        self._nearest: Nearest | None = None  # on offer
        self._failure = ""  # why the newest request cannot be planned

    @property
    def jump(self) -> Jump:
        """What is asked for."""
        return self.design.jump

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
        complaints: list[str] = []
        with ThreadPoolExecutor(1) as beside:
            # Asked before anything is sent, so that the answer is there when the panel is.
            kept = beside.submit(recall, self._client, _RECALL, complaints)
            self._panel = Panel(self._client, self.design, self._file, examples(), self._inbox.put)
            self._files = Files(self._client, self._panel)
            bridge = Bridge(self._client, self._inbox.put)
            try:
                with closing(
                    Stage(
                        self._client,
                        self._panel,
                        bridge,
                        lambda: self._inbox.put(Action.TARGET),
                    )
                ) as self._stage:
                    self._open(kept, complaints)
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
                match event:
                    case Action():
                        self._act(event)
                    case Chosen(design):
                        self._take_up(design)
                    case Uploaded():
                        opened = self._files.opened(event)
                        if opened is not None:
                            self._take_up(opened)
                    case _Stop():
                        pass
                    case _ if isinstance(event, PageEvent):
                        self._stage.hear(event)
                    case _:
                        self._hear(event)
            rested = self._live.due()
            if rested is not None:
                self._submit(rested)
            self._stage.step()

    def _next_events(self) -> list[Event]:
        """What has happened, each kind of action once; waits until something has or is due."""
        waits = [wait for wait in (self._stage.wait, self._live.wait) if wait is not None]
        try:
            first = self._inbox.get(timeout=min(waits) if waits else None)
        except queue.Empty:
            return []
        events = [first]
        while True:
            try:
                event = self._inbox.get_nowait()
            except queue.Empty:
                return events
            # The latest of its kind counts: play, pause, play is play.
            if isinstance(event, Action) and event in events:
                events.remove(event)
            events.append(event)

    def _act(self, action: Action) -> None:
        player = self._stage.player
        match action:
            case Action.REQUEST:
                self._request()
            case Action.TARGET:
                self._panel.jump.show(self._stage.read_target(self.jump, self._file.task))
                self._request()
            case Action.SIMULATE:
                self._simulate()
            case Action.CANCEL:
                self._simulate_next = False
                self._pool.cancel(self._client.client_id)
            case Action.NEAREST:
                self._take_nearest()
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
            case Action.PIN:
                self._stage.pin(self.design.conditions)
            case Action.UNPIN:
                self._stage.unpin()
            case Action.TAKE_UP:
                pin = self._stage.chosen_pin
                if pin is not None:
                    self._take_up(pin.design)
            case Action.SAVE:
                self._files.save(self.design)
            case Action.EXPORT:
                # What is drawn solid.
                self._files.export(self.rollout or self.plan)

    # ---- asking

    def _open(self, kept: Future[Design | None], complaints: list[str]) -> None:
        """Show a jump at once: the one this browser kept, or the example of the first robot."""
        if self._opening.plan(self.jump.robot) is not None:
            self._show_robot(self.jump.robot)
        design = kept.result()
        if complaints:
            self._panel.notify("The last design was not opened", "; ".join(complaints))
        if design is not None and design != self.design:
            self._take_up(design)
            return
        plan = self._opening.plan(self.jump.robot)
        if plan is None:
            self._request()
            return
        self._live.ask(self.jump, self.design.tuning, None)
        self._stage.show_target(self.jump)
        self._stage.show_plan(plan)
        self._panel.show_status("Planned", summaries.planned_line(plan))

    def _take_up(self, design: Design) -> None:
        """Put the controls where a design has them, and plan it."""
        self._use_robot(design.jump.robot)
        self._panel.jump.show(design.jump)
        self._panel.simulation.show(design.conditions)
        self._panel.designs.show(design.title, design.note)
        self.design = design
        if self._robot is not None:
            self._panel.tuning.show_robot(self._robot)
        self._panel.tuning.show(design.tuning)
        self._request()

    def _use_robot(self, name: str) -> None:
        """Ranges, drawing and numbers of this robot from now on."""
        if name != self._file.name:
            self._file = read_robot_file(robot_files()[name])
            self._panel.show_robot(self._file)
            self._robot = None

    def _request(self) -> None:
        jump, complaints = self._panel.jump.read(self.jump)
        if jump.robot != self._file.name:
            # What was asked of the other robot is not for this one.
            self._use_robot(jump.robot)
            jump, complaints = self._panel.jump.read(jump)
            self.design = Design(jump)
        tuning, wrong = self._panel.tuning.read()
        if self._robot is None:
            tuning = self.design.tuning
        complaints += wrong
        if complaints:
            self._panel.notify("Corrected", "; ".join(complaints))
            self._panel.jump.show(jump)
            self._panel.tuning.show(tuning)
        if (jump, tuning) != (self.design.jump, self.design.tuning):
            self.design = replace(self.design, jump=jump, tuning=tuning, title="", note="")
            self._panel.designs.show("")
        self._stage.show_target(jump)
        if self._robot is None:
            self._prepare()
            return
        task = self._live.ask(jump, tuning, self.plan)
        if task is not None:
            self._offer(None)
            self._submit(task)

    def _prepare(self) -> None:
        if isinstance(self._awaited, Prepare) and self._awaited.robot == self.jump.robot:
            return
        self._live.forget()
        self._submit(Prepare(self.jump.robot))

    def _simulate(self) -> None:
        plan = self.plan
        planning = isinstance(self._awaited, PlanJump) or not self._live.settled
        if self._robot is not None and planning:
            self._simulate_next = True
            return
        if self._robot is None or plan is None:
            self._panel.notify("Not simulated", "There is no plan yet.")
            return
        if not plan.solved:
            self._panel.notify(
                "Not simulated",
                "The planner did not converge, so there is no motion to follow.",
            )
            return
        conditions, complaints = self._panel.simulation.read(self.design.conditions)
        if complaints:
            self._panel.notify("Corrected", "; ".join(complaints))
            self._panel.simulation.show(conditions)
        self.design = replace(self.design, conditions=conditions)
        remember(self._client, self.design)
        self._submit(SimulateJump(plan, conditions))

    def _submit(self, task: Task) -> None:
        self._awaited = task
        self._job = self._pool.submit(self._client.client_id, task, self._inbox.put)
        match task:
            case SimulateJump():
                self._panel.show_status("Simulating", "...", busy=True)
            case FindNearest():
                pass
            case Prepare():
                self._panel.show_status("Planning", "begins when the robot is ready.", busy=True)
            case PlanJump():
                self._panel.show_status("Planning", "...", busy=True)

    # ---- hearing

    def _hear(self, report: Report) -> None:
        newest = report.job == self._job
        task = self._awaited
        if newest and not isinstance(report, Progress):
            self._awaited = None
            if isinstance(task, PlanJump):
                self._live.answered(task)
        match report:
            case Progress():
                if newest:
                    self._tell_progress(report)
            case Prepared():
                if newest:
                    self._show_robot(report.robot)
                    self._request()
            case Planned():
                self._show_planned(report, newest=newest)
            case Found():
                if newest:
                    self._offer(report.nearest)
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
        match self._awaited:
            case SimulateJump():
                told = f"({report.text}) ..." if report.share is None else f"{report.share:.0%}"
                self._panel.show_status("Simulating", told, busy=True)
            case FindNearest():
                self._panel.show_status("Failed", f"{self._failure} ({report.text}) ...", busy=True)
            case _:
                self._panel.show_status("Planning", summaries.progress_line(report), busy=True)

    def _tell_cancelled(self, task: Task | None) -> None:
        match task:
            case SimulateJump():
                self._panel.show_status("Cancelled", "The plan is still there.")
            case FindNearest():
                self._panel.show_status("Cancelled", "The search for a jump that works.")
            case _:
                self._live.forget()
                self._panel.show_status("Cancelled", "Move a slider to plan again.")

    def _show_robot(self, name: str) -> None:
        try:
            robot = load_robot(name)
        except Error as error:
            self._panel.show_status("Failed", str(error))
            return
        self._robot = robot
        self._stage.show_robot(robot)
        self._panel.tuning.show_robot(robot)
        self._panel.tuning.show(self.design.tuning)

    def _show_planned(self, report: Planned, *, newest: bool) -> None:
        plan = report.plan
        # An older one is still worth showing while the slider moves.
        if self._robot is None or plan.jump.robot != self._robot.name:
            return
        if report.job < self._shown_job:
            return
        self._shown_job = report.job
        moving = not newest or not self._live.settled
        self._stage.show_plan(plan, moving=moving)
        if not newest:
            return
        if moving:
            self._panel.show_status("Planning", summaries.live_line(plan), busy=True)
            return
        self._panel.show_status("Planned", summaries.planned_line(plan))
        remember(self._client, self.design)
        if self._simulate_next:
            self._simulate_next = False
            self._simulate()

    def _fail(self, report: Failed, task: Task | None) -> None:
        self._simulate_next = False
        if isinstance(task, FindNearest):
            # Why there is no such jump is told beside what stopped the one that was asked for.
            self._panel.show_status("Failed", f"{self._failure} {report.message}")
            return
        self._failure = report.message
        match task:
            case PlanJump(patient=False):
                # It rests before it is looked at with patience; a hand is still moving.
                self._panel.show_status("Planning", "nothing found quickly ...", busy=True)
                return
            case PlanJump(jump, tuning) if report.plan is not None:
                if presentable(report.plan):
                    self._stage.show_plan(report.plan)
                    self._failure += (
                        " The picture shows where the solver stopped; it is no feasible motion."
                    )
                self._submit(FindNearest(jump, tuning))
                self._panel.show_status(
                    "Failed", f"{self._failure} Looking for the nearest jump ...", busy=True
                )
                return
            case PlanJump():
                self._live.forget()
        self._panel.show_status("Failed", self._failure)

    def _offer(self, nearest: Nearest | None) -> None:
        """Show a button that takes a jump that works; None: no such offer any more."""
        self._nearest = nearest
        self._panel.offer_nearest(None if nearest is None else nearest.changes)
        if nearest is not None:
            self._panel.show_status("Failed", f"{self._failure} {nearest.changes} works.")

    def _take_nearest(self) -> None:
        if self._nearest is not None:
            jump = self._nearest.jump
            self._offer(None)
            self._panel.jump.show(jump)
            self._request()
