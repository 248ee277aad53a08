"""What one tab plays: the motion that is shown, in the picture and in the panel, over time."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

import viser

from app.motion import colours
from app.motion.clip import Clip
from app.motion.foreign_motion import ForeignMotion
from app.motion.planned_motion import PlannedMotion, bake_plan
from app.motion.simulated_motion import SimulatedMotion, bake_rollout
from app.panel.comparison import Column
from app.panel.panel import Panel
from app.plots.charts import Layer, shown_layers
from app.scene.landing_handle import TargetHandle
from app.scene.scene import Scene
from app.session.pace import Pace
from app.session.pins import Pin, Pins
from app.session.player import BrowserPlayer, Player, ServerPlayer
from app.viser_link.page_link import PaceChosen, PageEvent, PageLink, PageReady, PlayerMoved
from llsrbm.analysis.figures import figures_of_plan
from llsrbm.design import Design
from llsrbm.jump import Jump
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.motion.timeline import Timeline, timeline
from llsrbm.robots import Robot
from llsrbm.robots.schema import Task
from llsrbm.scenario import Scenario
from llsrbm.simulation.surroundings import surroundings
from llsrbm.titles import titles_of

_PATIENCE = 8.0  # s for the page to say that its scripts run; a slow one takes 3 s to open
_TIME_SHOWN_EVERY = 0.1  # s; the timeline follows the picture more slowly, to spare the line


class Stage:
    """Scene, player and the panel's view of time, for one thread.

    The page plays by itself. One that does not say that it can is played for by the server.

    Attributes:
        player: plays what is shown.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        panel: Panel,
        bridge: PageLink,
        target_moved: Callable[[], None],
    ) -> None:
        """An empty scene.

        Args:
            client: whose tab.
            panel: where time, figures and plots are shown.
            bridge: to the scripts in the page.
            target_moved: called from viser's thread when the landing handle was dragged.
        """
        self._client = client
        self._panel = panel
        self._bridge = bridge
        self._scene = Scene(client)
        self._target = TargetHandle(client, target_moved)
        self._pins = Pins()
        self.player: Player = BrowserPlayer(bridge)
        self._answered = False
        self._give_up_at = time.monotonic() + _PATIENCE
        self._pace: Pace | None = None
        self._robot: Robot | None = None
        self._replay: PlannedMotion | None = None
        self._simulated: SimulatedMotion | None = None
        self._events: Timeline | None = None
        self._time_shown = 0.0

    def close(self) -> None:
        """Follow the browser's pace no longer."""
        if self._pace is not None:
            self._pace.close()

    @property
    def plan(self) -> Plan | None:
        """The plan that is shown."""
        return None if self._replay is None else self._replay.plan

    @property
    def robot(self) -> str | None:
        """Name of the robot that is shown."""
        return None if self._robot is None else self._robot.name

    @property
    def rollout(self) -> Rollout | None:
        """The simulation of it that is shown, or None."""
        return None if self._simulated is None else self._simulated.rollout

    # ---- what is shown

    def show_robot(self, robot: Robot) -> None:
        """Show a robot without a motion."""
        if robot is self._robot and self._replay is None:
            return
        self._robot = robot
        self._replay = self._simulated = self._events = None
        self._panel.clear_plan()
        self.player.clear()
        self._scene.show_robot(robot)
        self._target.show_robot(robot)

    def show_plan(self, plan: Plan, *, moving: bool = False) -> None:
        """Show a plan of the robot that is shown; a simulation of another plan goes.

        Args:
            plan: to show.
            moving: the next one will follow soon: only what can be seen at a glance is shown.
        """
        assert self._robot is not None
        first = self._replay is None
        replay = bake_plan(plan, self._robot)
        around = surroundings(self._robot, plan, Scenario())
        self._replay, self._simulated = replay, None
        with self._client.atomic():
            self._scene.show_motion(replay, blocks=around.blocks)
            self._load()
            if not moving:
                self._tell()
            if first:
                self.show_layers()
                self.player.play()
        # viser would gather messages for up to a sixtieth of a second.
        self._client.flush()

    def show_rollout(self, rollout: Rollout) -> None:
        """Show a simulation of the plan that is shown, beside it."""
        assert self._robot is not None
        assert self._replay is not None
        self._simulated = bake_rollout(rollout)
        around = surroundings(self._robot, self._replay.plan, rollout.scenario)
        with self._client.atomic():
            self._scene.show_motion(self._replay, self._simulated.frames, around.blocks)
            self._load()
            self._tell()

    def show_target(self, jump: Jump) -> None:
        """Put the landing handle where a jump shall land."""
        self._target.show(jump)

    def read_target(self, jump: Jump, task: Task) -> Jump:
        """The request with the landing place where the handle was dragged to."""
        return self._target.read(jump, task)

    def show_layers(self) -> None:
        """Draw what the panel's boxes say."""
        layers = self._panel.view.read()
        self._target.set_visible(layers.pop("target") and self._replay is not None)
        self._scene.show_layers(**layers)
        self._panel.show_plots()

    # ---- what is compared

    def pin(self, scenario: Scenario) -> None:
        """Keep the motion that is shown.

        Args:
            scenario: in which it would be simulated, if it has not been.
        """
        if self._robot is None or self._replay is None or self._pins.full:
            return
        plan = self._replay.plan
        design = Design(plan.jump, plan.tuning, _scenario(self.rollout) or scenario)
        self._pins.add(self._replay, self._simulated, design)
        self._show_pins()

    def pin_foreign(self, motion: ForeignMotion, design: Design | None) -> bool:
        """Keep a motion from a file; False if there is no colour left.

        Args:
            motion: to be looked at beside the one that is shown.
            design: what was asked for, if that is known.
        """
        if self._pins.full:
            return False
        self._pins.add(motion, None, design)
        self._show_pins()
        return True

    def unpin(self) -> None:
        """Let go of the pin that is chosen in the panel."""
        pin = self.chosen_pin
        if pin is not None:
            self._pins.remove(pin)
            self._show_pins()

    @property
    def chosen_pin(self) -> Pin | None:
        """The one that is chosen in the panel."""
        return self._pins.at(self._panel.compare.chosen)

    def _show_pins(self) -> None:
        self._scene.show_ghosts([pin.ghost for pin in self._pins])
        if self._replay is not None:
            self._load()
            self._tell()

    def _tell(self) -> None:
        """Numbers, curves and comparison of what is shown."""
        assert self._robot is not None
        assert self._replay is not None
        replay, rollout = self._replay, self.rollout
        current = (replay.plan.jump, replay.plan.tuning, _scenario(rollout))
        decisions = [pin.decisions for pin in self._pins]
        title, *titles = titles_of([current, *(d for d in decisions if d is not None)])
        told = iter(titles)
        layers = [*shown_layers(replay, rollout)]
        columns = []
        for pin in self._pins:
            name = pin.motion.name if isinstance(pin.motion, ForeignMotion) else next(told)
            layers.append(Layer(name, pin.colour, pin.motion, pin.rollout, pinned=True))
            columns.append(Column(name, pin.colour, pin.figures))
        figures_now = figures_of_plan(replay.plan, rollout)
        self._panel.show_figures(replay.plan, rollout, layers)
        self._panel.compare.show(
            Column(title, colours.SIMULATED if rollout else colours.PLANNED, figures_now),
            columns,
            full=self._pins.full,
        )

    def _load(self) -> None:
        assert self._replay is not None
        clip, events = self._scene.clip(), timeline(self._replay.plan, self.rollout)
        # What is pinned may go on when the motion that is shown stands.
        self._events = replace(events, end=max(events.end, clip.end))
        self._panel.show_end(self._events.end)
        self.player.load(clip, self._events)
        self.show_time()

    # ---- time

    def hear(self, event: PageEvent) -> None:
        """What the page told."""
        match event:
            case PageReady(software):
                self._answered = True
                if not software:
                    self._scene.refine()
                    # New nodes stand where the robot stands; the clip moves them on.
                    if self._events is not None:
                        self.player.load(self._scene.clip(), self._events)
                if isinstance(self.player, ServerPlayer):
                    self._play_there()
            case PlayerMoved():
                if isinstance(self.player, BrowserPlayer):
                    self.player.hear(event)
                    self.show_time()
            case PaceChosen(speed, loop):
                self._panel.show_pace(speed, loop)

    def step(self) -> None:
        """Do what is due; called when `wait` has passed."""
        if not self._answered and time.monotonic() >= self._give_up_at:
            self._answered = True
            self._play_from_here()
        self.player.step()

    @property
    def wait(self) -> float | None:
        """Seconds until `step` is due, or None when nothing is."""
        if not self._answered:
            return max(0.0, self._give_up_at - time.monotonic())
        return self.player.wait

    def show_time(self) -> None:
        """Tell the panel where the motion is."""
        self._time_shown = time.monotonic()
        self._panel.show_time(self.player.time, playing=self.player.playing)
        if isinstance(self.player, ServerPlayer) and self._events is not None:
            self._panel.show_timeline(self._events, self.player.time)

    def _play_from_here(self) -> None:
        """The page's scripts do not answer: send every frame."""
        self._panel.notify(
            "Played by the server", "The page's own player does not answer; motion is less smooth."
        )
        self._pace = Pace(self._ask_tab, lambda: self.player.playing)
        self._pace.start()
        before, self.player = self.player, ServerPlayer(self._show_instant, self._pace.rate)
        speed, loop = self._panel.read_pace()
        self.player.set_speed(speed)
        self.player.set_loop(loop)
        if self._events is not None:
            self._load()
            self.player.seek(before.time)
            if before.playing:
                self.player.play()

    def _play_there(self) -> None:
        """The page answers after all: it was slow to open."""
        playing = self.player.playing
        self.close()
        self.player = BrowserPlayer(self._bridge)
        self._panel.hide_timeline()
        if self._events is not None:
            self._load()
        if playing:
            self.player.play()

    def _show_instant(self, clip: Clip, instant: float) -> None:
        self._scene.show_instant(clip, instant)
        if not self.player.playing or time.monotonic() - self._time_shown > _TIME_SHOWN_EVERY:
            self.show_time()

    def _ask_tab(self) -> None:
        """Return when the browser has worked off what it was sent."""
        self._client.local_storage.get_item("llsrbm", timeout=2.0)


def _scenario(rollout: Rollout | None) -> Scenario | None:
    return None if rollout is None else rollout.scenario
