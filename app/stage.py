"""What one tab plays: the motion that is shown, in the picture and in the panel, over time."""

from __future__ import annotations

import time
from collections.abc import Callable

import viser

from app.pace import Pace
from app.panel import Panel
from app.player import Player, ServerPlayer
from app.replay import Replay, bake
from app.scene import Scene
from app.simulated_replay import bake_rollout
from llsrbm.robots import Robot
from llsrbm.simulation.surroundings import surroundings
from llsrbm.trajectory.plan import Plan
from llsrbm.trajectory.rollout import Conditions, Rollout

_TIME_SHOWN_EVERY = 0.1  # s; the timeline follows the picture more slowly, to spare the line
_FRAMES_A_PLOT = 15  # the plots still more slowly, the more so in a browser that draws slowly


class Stage:
    """Scene, player and the panel's view of time, for one thread.

    Attributes:
        player: plays what is shown.
        plan: what is shown, or None.
        rollout: the simulation of it that is shown, or None.
    """

    def __init__(
        self, client: viser.ClientHandle, panel: Panel, computing: Callable[[], bool]
    ) -> None:
        """An empty scene.

        Args:
            client: whose tab.
            panel: where time, figures and plots are shown.
            computing: whether this tab waits for the computing process.
        """
        self._client = client
        self._panel = panel
        self._computing = computing
        self._scene = Scene(client)
        self.player: Player = ServerPlayer(self._show_instant, self._frame_rate)
        self._pace = Pace(self._ask_tab, lambda: self.player.playing)
        self._robot: Robot | None = None
        self._replay: Replay | None = None
        self.rollout: Rollout | None = None
        self._time_shown = 0.0
        self._frames = 0  # since the plots were told the time

    def start(self) -> None:
        """Begin to follow the browser's pace."""
        self._pace.start()

    def close(self) -> None:
        """Follow it no longer."""
        self._pace.close()

    @property
    def plan(self) -> Plan | None:
        """The plan that is shown."""
        return None if self._replay is None else self._replay.plan

    def show_robot(self, robot: Robot) -> None:
        """Show a robot without a motion."""
        self._robot = robot
        self._replay = self.rollout = None
        self._panel.clear_plan()
        self._scene.show_robot(robot)

    def show_plan(self, plan: Plan) -> None:
        """Show a plan of the robot that is shown; a simulation of another plan goes."""
        assert self._robot is not None
        first = self._replay is None
        replay = bake(plan, self._robot)
        around = surroundings(self._robot, plan, Conditions())
        self._replay, self.rollout = replay, None
        with self._client.atomic():
            self._scene.show_motion(replay, blocks=around.blocks)
            self._panel.show_plan(replay)
            self._load(plan.duration)
            if first:
                self.player.play()

    def show_rollout(self, rollout: Rollout) -> None:
        """Show a simulation of the plan that is shown, beside it."""
        assert self._robot is not None
        assert self._replay is not None
        simulated = bake_rollout(rollout, self._robot)
        around = surroundings(self._robot, self._replay.plan, rollout.conditions)
        self.rollout = rollout
        with self._client.atomic():
            self._scene.show_motion(self._replay, simulated.frames, around.blocks)
            self._panel.show_rollout(self._replay, rollout)
            self._load(max(self._replay.plan.duration, simulated.frames.end))

    def show_layers(self) -> None:
        """Draw what the panel's boxes say."""
        self._scene.show_layers(**self._panel.read_layers())
        self.player.seek(self.player.time)

    def show_time(self) -> None:
        """Tell the panel where the motion is."""
        self._time_shown = time.monotonic()
        self._panel.show_time(self.player.time, playing=self.player.playing)
        if not self.player.playing or self._frames >= _FRAMES_A_PLOT:
            self._frames = 0
            self._panel.show_plots_time(self.player.time)

    def _load(self, duration: float) -> None:
        self._frames = _FRAMES_A_PLOT
        self.player.load(duration)
        self.show_time()

    def _show_instant(self, instant: float) -> None:
        self._scene.show_instant(instant)
        self._frames += 1
        if not self.player.playing or time.monotonic() - self._time_shown > _TIME_SHOWN_EVERY:
            self.show_time()

    def _frame_rate(self) -> float:
        return self._pace.rate_while_planning() if self._computing() else self._pace.rate()

    def _ask_tab(self) -> None:
        """Return when the browser has worked off what it was sent."""
        self._client.local_storage.get_item("llsrbm", timeout=2.0)
