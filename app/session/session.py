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
from functools import partial

import viser

from app.compute.opened_file import OpenedFile, States
from app.compute.pool import WorkerPool
from app.compute.protocol import Report
from app.motion.foreign_motion import bake_foreign
from app.panel.panel import Action, Chosen, Panel, Uploaded
from app.session.desk import Desk
from app.session.files import FileReport, Files, forget_files
from app.session.initial_plan import InitialPlans, example
from app.session.stage import Stage
from app.session.stored_design import recall, remember
from app.viser_link.page_link import PageEvent, PageLink
from llsrbm.design import Design
from llsrbm.errors import Error
from llsrbm.examples import examples
from llsrbm.jump import Jump
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.motion.whole_body import WholeBodyMotion
from llsrbm.robots import Robot, load_robot, read_robot_file
from llsrbm.robots.assets import robot_files
from llsrbm.scenario import Scenario

_RECALL = 1.5  # s to wait for what the browser kept; it answers as soon as it shows the panel


class _Stop(Enum):
    STOP = 0


Event = Action | Chosen | Uploaded | PageEvent | FileReport | Report | _Stop


class Session:
    """A tab's state; `start` runs its thread until `close`."""

    def __init__(self, client: viser.ClientHandle, pool: WorkerPool, opening: InitialPlans) -> None:
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
        self._simulate_next = False  # once the plan that is being made is there

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
        forget_files(self._pool, self._client.client_id)
        self._inbox.put(_Stop.STOP)
        self._thread.join()

    # ---- the thread

    def _run(self) -> None:
        complaints: list[str] = []
        # Asked before anything is sent, so that the answer is there when the panel is.
        beside = ThreadPoolExecutor(1)
        kept = beside.submit(recall, self._client, _RECALL, complaints)
        beside.shutdown(wait=False)
        self._panel = Panel(self._client, self.design, self._file, examples(), self._inbox.put)
        self._files = Files(self._client, self._panel, self._pool, self._inbox.put)
        bridge = PageLink(self._client, self._inbox.put)
        moved = partial(self._inbox.put, Action.TARGET)
        try:
            with closing(Stage(self._client, self._panel, bridge, moved)) as self._stage:
                self._desk = Desk(
                    self._client.client_id,
                    self._pool,
                    self._panel,
                    self._stage,
                    listener=self._inbox.put,
                    prepared=self._prepared,
                    planned=self._planned,
                )
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
                        self._files.open(event, self.jump.robot)
                    case FileReport(report):
                        opened = self._files.hear(report)
                        if opened is not None:
                            self._show_opened(opened)
                    case _Stop():
                        pass
                    case _ if isinstance(event, PageEvent):
                        self._stage.hear(event)
                    case _:
                        self._desk.hear(event)
            self._desk.step()
            self._stage.step()

    def _next_events(self) -> list[Event]:
        """What has happened, each kind of action once; waits until something has or is due."""
        waits = [wait for wait in (self._stage.wait, self._desk.wait) if wait is not None]
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
                self._files.cancel()
                self._desk.cancel()
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
                self._stage.pin(self.design.scenario)
            case Action.UNPIN:
                self._stage.unpin()
            case Action.TAKE_UP:
                pin = self._stage.chosen_pin
                if pin is not None and pin.design is not None:
                    self._take_up(pin.design)
                elif pin is not None:
                    self._panel.notify(
                        "Not taken up",
                        "A motion of another tool is for looking: nothing says what was asked for.",
                    )
            case Action.SAVE:
                self._files.save(self.design)
            case Action.EXPORT:
                self._files.export(self.plan, self.rollout)
            case Action.STOP_EXPORT:
                self._files.cancel()

    # ---- asking

    def _open(self, kept: Future[Design | None], complaints: list[str]) -> None:
        """Show a jump at once: the one this browser kept, or the example of the first robot."""
        file = self._opening.file
        if file is not None:
            if file.is_alone:  # beside the example of its robot
                self._take_up(Design(example(file.robot)))
            self._show_opened(file)
            return
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
        self._stage.show_target(self.jump)
        self._desk.show(plan)

    def _take_up(self, design: Design) -> None:
        """Put the controls where a design has them, and plan it."""
        self._use_robot(design.jump.robot)
        self._panel.jump.show(design.jump)
        self._panel.simulation.show(design.scenario)
        self._panel.designs.show(design.title, design.note)
        self.design = design
        if self._robot is not None:
            self._panel.tuning.show_robot(self._robot)
        self._panel.tuning.show(design.tuning)
        self._request()

    def _show_opened(self, file: OpenedFile) -> None:
        """What a file holds: a design is planned, a plan or a simulation of one shown as it is.

        Any other motion becomes a pin: it is for looking and comparing.
        """
        match file.holds:
            case Design() as design:
                self._take_up(design)
            case Plan() as plan:
                self._take_up_motion(file, Design(plan.jump, plan.tuning, self._scenario()), plan)
            case Rollout(plan=Plan() as plan) as rollout:
                design = Design(plan.jump, plan.tuning, rollout.scenario)
                self._take_up_motion(file, design, plan, rollout)
            case Rollout() as rollout:
                self._pin(file, rollout, Design(rollout.jump, scenario=rollout.scenario))
            case States() as states:
                self._pin(file, states.motion(), None)

    def _take_up_motion(
        self, file: OpenedFile, design: Design, plan: Plan, rollout: Rollout | None = None
    ) -> None:
        """Put the controls where a motion has them, and show it without planning it again."""
        self._simulate_next = False
        self._use_robot(design.jump.robot)
        self.design = design
        if self._robot is None:  # it was prepared when the file was opened
            self._show_robot(design.jump.robot)
        if self._robot is None:
            return  # the panel says why
        self._panel.jump.show(design.jump)
        self._panel.simulation.show(design.scenario)
        self._panel.tuning.show(design.tuning)
        self._panel.designs.show("", " ".join((f"Opened {file.name}.", *file.remarks)))
        self._stage.show_target(design.jump)
        self._desk.show(plan, rollout, f"from file {file.name}")
        remember(self._client, design)

    def _pin(
        self, file: OpenedFile, motion: Rollout | WholeBodyMotion, design: Design | None
    ) -> None:
        """Keep a motion beside the one that is shown."""
        if self._stage.pin_foreign(bake_foreign(file.name, motion), design):
            rate = getattr(motion, "fps", None)
            at = "" if rate is None else f", at {rate:g} frames/s"
            told = f"{file.name} is pinned for looking and comparing{at}."
            self._panel.designs.show("", " ".join((told, *file.remarks)))
        else:
            self._panel.notify(
                "Not opened", f"{file.name}: unpin something first; all colours are taken"
            )
        if self.plan is None:
            self._request()

    def _scenario(self) -> Scenario:
        """As the panel has it."""
        return self._panel.simulation.read(self.design.scenario)[0]

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
            self._simulate_next = False
        self._stage.show_target(jump)
        if self._robot is None:
            self._desk.prepare(jump.robot)
        else:
            self._desk.plan(jump, tuning)

    def _simulate(self) -> None:
        plan = self.plan
        if self._robot is not None and self._desk.planning:
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
        scenario, complaints = self._panel.simulation.read(self.design.scenario)
        if complaints:
            self._panel.notify("Corrected", "; ".join(complaints))
            self._panel.simulation.show(scenario)
        self.design = replace(self.design, scenario=scenario)
        remember(self._client, self.design)
        self._desk.simulate(plan, scenario)

    def _take_nearest(self) -> None:
        nearest = self._desk.nearest
        if nearest is not None:
            self._desk.withdraw_nearest()
            self._panel.jump.show(nearest.jump)
            self._request()

    # ---- what has come

    def _prepared(self, robot: str) -> None:
        self._show_robot(robot)
        if self._robot is not None:
            self._request()

    def _planned(self) -> None:
        remember(self._client, self.design)
        if self._simulate_next:
            self._simulate_next = False
            self._simulate()

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
