"""One tab's controls and what they tell. Labels are part of the contract."""

from __future__ import annotations

from collections.abc import Callable, Coroutine
from enum import Enum, auto
from typing import Any

import viser

from app import markup, summaries
from app.checked import number, option, put
from app.curves import shown_layers
from app.jump_controls import JumpControls
from app.player import SPEEDS
from app.plots import Plots
from app.replay import Replay
from app.simulation_controls import SimulationControls
from app.timeline import timeline
from llsrbm.exporters import formats
from llsrbm.jump import Jump
from llsrbm.robots import RobotFile
from llsrbm.trajectory.plan import Plan
from llsrbm.trajectory.rollout import Rollout


class Action(Enum):
    """What a user did; which value it led to is read from the panel afterwards."""

    REQUEST = auto()
    SIMULATE = auto()
    CANCEL = auto()
    PLAY = auto()
    PAUSE = auto()
    SCRUB = auto()
    PACE = auto()
    LAYERS = auto()
    EXPORT = auto()


class Panel:
    """The controls; to be used by one thread, except for the callbacks viser makes.

    Attributes:
        jump: the controls of the request.
        simulation: those of the simulated world.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        jump: Jump,
        robot_file: RobotFile,
        act: Callable[[Action], None],
    ) -> None:
        """Build the controls.

        Args:
            client: whose tab.
            jump: the request to start from.
            robot_file: of its robot.
            act: told what the user did; called from viser's thread, must return at once.
        """
        self._client = client
        self._act = act
        self._plan: Plan | None = None
        self._rollout: Rollout | None = None
        self._end = 0.0
        self._scrubbed = 0.0
        gui = client.gui
        self._status = gui.add_html(markup.status("Planning", ""))
        self._cancel = gui.add_button("Cancel", disabled=True, hint="Stop what is going on")
        with gui.add_folder("Jump"):
            self.jump = JumpControls(gui, jump, robot_file)
        with gui.add_folder("Whole body"):
            self.simulation = SimulationControls(gui, robot_file)
        with gui.add_folder("Playback"):
            self._transport = gui.add_button_group("Motion", ("Play", "Pause"))
            self._time = gui.add_slider("Time [s]", 0.0, 1.0, 0.01, 0.0)
            self._timeline = gui.add_html("")
            self._speed = gui.add_dropdown("Speed", SPEEDS, initial_value=SPEEDS[-1])
            self._loop = gui.add_checkbox("Loop", initial_value=True)
        with gui.add_folder("Plots"):
            self._plots = Plots(client)
        with gui.add_folder("Figures"):
            self._rollout_figures = gui.add_html("", visible=False)
            self._plan_figures = gui.add_html("")
        with gui.add_folder("Residuals", expand_by_default=False):
            self._residuals = gui.add_html("")
        with gui.add_folder("Show"):
            self._ellipsoids = gui.add_checkbox("Inertia ellipsoids", initial_value=True)
            self._forces = gui.add_checkbox("Forces", initial_value=True)
            self._trails = gui.add_checkbox("Trails", initial_value=True)
            self._ghost = gui.add_checkbox("Ghost", initial_value=True)
            self._legend = gui.add_html(markup.legend(simulated=False))
        with gui.add_folder("File"):
            self._format = gui.add_dropdown("Format", tuple(formats()))
            self._export = gui.add_button(
                "Export",
                disabled=True,
                hint="Saves what is drawn solid: the simulation if there is one, else the plan",
            )
        with gui.add_folder("Help", expand_by_default=False):
            gui.add_html(markup.HELP)
        self._listen()

    # ---- what the user asks for

    def read_time(self) -> float:
        """Where the user put the time slider, s."""
        return number("Time [s]", self._scrubbed, (0.0, self._end), [])

    def read_pace(self) -> tuple[float, bool]:
        """Speed (seconds of motion a second) and whether to loop."""
        speed = option("Speed", self._speed.value, SPEEDS, SPEEDS[-1], [])
        return float(speed.removesuffix("×")), bool(self._loop.value)

    def read_layers(self) -> dict[str, bool]:
        """What to draw, as arguments of `Scene.show_layers`."""
        return {
            "ellipsoids": bool(self._ellipsoids.value),
            "forces": bool(self._forces.value),
            "trails": bool(self._trails.value),
            "ghost": bool(self._ghost.value),
        }

    def read_format(self) -> tuple[str, list[str]]:
        """The file format to export, and what had to be corrected."""
        complaints: list[str] = []
        valid = tuple(formats())
        return option("Format", self._format.value, valid, valid[0], complaints), complaints

    # ---- what the user is told

    def show_status(self, word: str, rest: str, *, busy: bool = False) -> None:
        """The status line; `busy` while there is something to cancel."""
        self._status.content = markup.status(word, rest)
        self._cancel.disabled = not busy

    def show_robot(self, robot_file: RobotFile) -> None:
        """The ranges of another robot, and its example."""
        self.jump.show_robot(robot_file)
        self.simulation.show_robot(robot_file)

    def show_plan(self, replay: Replay) -> None:
        """A plan's numbers, and no simulation's."""
        self._plan, self._rollout = replay.plan, None
        self._plan_figures.content = summaries.plan_figures(replay.plan)
        self._residuals.content = summaries.residuals(replay.plan.violations)
        self._export.disabled = False
        self._rollout_figures.visible = False
        self._show_motion(replay)

    def show_rollout(self, replay: Replay, rollout: Rollout) -> None:
        """The numbers of a simulation of the plan that is shown."""
        self._rollout = rollout
        self._rollout_figures.content = summaries.rollout_figures(rollout)
        self._rollout_figures.visible = True
        self._show_motion(replay)

    def clear_plan(self) -> None:
        """No plan's numbers."""
        self._plan = self._rollout = None
        for html in (self._timeline, self._plan_figures, self._residuals):
            html.content = ""
        self._plots.clear()
        self._rollout_figures.visible = False
        self._export.disabled = True

    def show_time(self, time: float, *, playing: bool) -> None:
        """Where the motion is, s.

        While it plays, only the timeline moves: a browser loses what a user enters into a control
        that is being set.
        """
        if self._plan is None:
            return
        if not playing:
            put(self._time, round(min(time, self._end), 2))
        self._timeline.content = timeline(self._plan, time, self._rollout)

    def show_plots_time(self, time: float) -> None:
        """Where the motion is, s, in the plots: these cost more than `show_time`."""
        self._plots.show_time(time)

    def notify(self, title: str, body: str) -> None:
        """A passing remark."""
        self._client.add_notification(title, body, auto_close_seconds=6.0, color="orange")

    # ---- inside

    def _show_motion(self, replay: Replay) -> None:
        rollout = self._rollout
        ends = [replay.plan.duration] + ([] if rollout is None else [float(rollout.time[-1])])
        self._end = max(ends)
        self._time.max = round(max(self._end, 0.01), 2)
        self._plots.draw(shown_layers(replay, rollout), self._end)
        self._legend.content = markup.legend(simulated=rollout is not None)

    def _listen(self) -> None:
        for handle in self.jump.handles:
            handle.on_update(self._told(Action.REQUEST))

        @self._time.on_update
        async def _(event: viser.GuiEvent[Any]) -> None:
            if event.client_id is not None:
                # Kept apart, because the session sets the same slider.
                self._scrubbed = event.target.value
                self._act(Action.SCRUB)

        for handle in (self._speed, self._loop):
            handle.on_update(self._told(Action.PACE))
        for handle in (self._ellipsoids, self._forces, self._trails, self._ghost):
            handle.on_update(self._told(Action.LAYERS))
        self.simulation.button.on_click(self._told(Action.SIMULATE))
        self._cancel.on_click(self._told(Action.CANCEL))
        self._export.on_click(self._told(Action.EXPORT))

        @self._transport.on_click
        async def _(event: viser.GuiEvent[Any]) -> None:
            self._act(Action.PAUSE if event.target.value == "Pause" else Action.PLAY)

    def _told(self, action: Action) -> Callable[[viser.GuiEvent[Any]], Coroutine[Any, Any, None]]:
        # Asynchronous, so that it runs on the event loop as soon as the value is there; viser would
        # hand a plain function to one of 32 threads.
        async def callback(event: viser.GuiEvent[Any]) -> None:
            # Without a client, it was this panel that set the value.
            if event.client_id is not None:
                self._act(action)

        return callback
