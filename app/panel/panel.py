"""One tab's controls and what they tell. Labels are part of the contract."""

from __future__ import annotations

from collections.abc import Callable, Coroutine, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum, auto
from pathlib import Path
from typing import Any

import viser

from app.panel import html, summaries
from app.panel import timeline as timeline_html
from app.panel.compare_controls import CompareControls
from app.panel.design_controls import DesignControls
from app.panel.export_controls import ExportControls
from app.panel.jump_controls import JumpControls
from app.panel.simulation_controls import SimulationControls
from app.panel.tuning_controls import TuningControls
from app.panel.validation import number, option, put
from app.panel.view_controls import ViewControls
from app.plots.charts import Layer
from app.plots.choice import DEFAULT, PlotChoice
from app.plots.plots import Plots
from app.session.player import SPEEDS
from llsrbm.design import Design
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.motion.timeline import Timeline
from llsrbm.robots import RobotFile

_HELP = Path(__file__).parents[1] / "static" / "help.md"


class Action(Enum):
    """What a user did; which value it led to is read from the panel afterwards."""

    REQUEST = auto()
    TARGET = auto()
    SIMULATE = auto()
    CANCEL = auto()
    NEAREST = auto()
    PLAY = auto()
    PAUSE = auto()
    SCRUB = auto()
    PACE = auto()
    LAYERS = auto()
    PIN = auto()
    UNPIN = auto()
    TAKE_UP = auto()
    SAVE = auto()
    EXPORT = auto()
    STOP_EXPORT = auto()


@dataclass(frozen=True)
class Chosen:
    """An example was chosen."""

    design: Design


@dataclass(frozen=True)
class Uploaded:
    """A file was opened, whatever it is."""

    name: str
    content: bytes


class Panel:
    """The controls; to be used by one thread, except for the callbacks viser makes.

    Attributes:
        jump: the controls of the request.
        simulation: those of the scenario.
        tuning: of weights and limits.
        view: of what is drawn.
        compare: of what is pinned.
        designs: of examples and files.
        export: of what is saved.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        design: Design,
        robot_file: RobotFile,
        examples: Mapping[str, Design],
        act: Callable[[Action | Chosen | Uploaded], None],
    ) -> None:
        """Build the controls.

        Args:
            client: whose tab.
            design: to start from.
            robot_file: of its robot.
            examples: to choose from.
            act: told what the user did; called from viser's thread, must return at once.
        """
        self._client = client
        self._act = act
        self._end = 0.0
        self._scrubbed = 0.0
        self._busy = self._exporting = False
        gui = client.gui
        self._status = gui.add_html(html.status("Planning", ""))
        self._nearest = gui.add_button("Take the nearest", visible=False)
        self._cancel = gui.add_button("Cancel", disabled=True, hint="Stop what is going on")
        with gui.add_folder("Jump"):
            self.jump = JumpControls(gui, design.jump, robot_file)
        with gui.add_folder("Whole body"):
            self.simulation = SimulationControls(gui, robot_file)
        self._transport = gui.add_button_group("Motion", ("Play", "Pause"))
        with gui.add_folder("Design"):
            self.designs = DesignControls(
                client,
                examples,
                on_example=lambda design: act(Chosen(design)),
                on_upload=lambda name, content: act(Uploaded(name, content)),
                on_save=lambda: act(Action.SAVE),
            )
        with gui.add_folder("Compare"):
            self.compare = CompareControls(gui)
        with gui.add_folder("Plots"):
            self._plots = Plots(client, self._plots_chosen)
        self._plot_choice: PlotChoice = DEFAULT
        self._layers: tuple[Layer, ...] = ()
        with gui.add_folder("Figures"):
            self._rollout_figures = gui.add_html("", visible=False)
            self._plan_figures = gui.add_html("")
        with gui.add_folder("Show"):
            self.view = ViewControls(gui)
        with gui.add_folder("File"):
            self.export = ExportControls(gui)
        with gui.add_folder("Weights and limits", expand_by_default=False):
            self.tuning = TuningControls(client, lambda: act(Action.REQUEST))
        with gui.add_folder("Residuals", expand_by_default=False):
            self._residuals = gui.add_html("")
        with gui.add_folder("Playback", expand_by_default=False):
            self._time = gui.add_slider("Time [s]", 0.0, 1.0, 0.01, 0.0)
            self._timeline = gui.add_html("", visible=False)
            self._speed = gui.add_dropdown("Speed", SPEEDS, initial_value=SPEEDS[-1])
            self._loop = gui.add_checkbox("Loop", initial_value=True)
        with gui.add_folder("Help", expand_by_default=False):
            gui.add_markdown(_HELP.read_text(encoding="utf-8"))
        self._listen()

    # ---- what the user asks for

    def read_time(self) -> float:
        """Where the user put the time slider, s."""
        return number("Time [s]", self._scrubbed, (0.0, self._end), [])

    def read_pace(self) -> tuple[float, bool]:
        """Speed (seconds of motion a second) and whether to loop."""
        speed = option("Speed", self._speed.value, SPEEDS, SPEEDS[-1], [])
        return float(speed.removesuffix("×")), bool(self._loop.value)

    def show_pace(self, speed: float, loop: bool) -> None:
        """What was chosen in the page's own bar."""
        name = f"{speed:g}×"
        if name in SPEEDS:
            put(self._speed, name)
        put(self._loop, loop)

    # ---- what the user is told

    def show_status(self, word: str, rest: str, *, busy: bool = False) -> None:
        """The status line; `busy` while there is something to cancel."""
        self._status.content = html.status(word, rest)
        self._busy = busy
        self._show_cancel()

    def show_exporting(self, told: str | None) -> None:
        """What is being saved beside all the rest; None: nothing."""
        self._exporting = told is not None
        self.export.show_busy(told)
        self._show_cancel()

    def offer_nearest(self, changes: str | None) -> None:
        """A jump that can be planned, in place of one that cannot; None: no offer any more."""
        if changes is not None:
            self._nearest.label = f"Take {changes}"
        self._nearest.visible = changes is not None

    def show_robot(self, robot_file: RobotFile) -> None:
        """The ranges of another robot, and its example."""
        self.jump.show_robot(robot_file)
        self.simulation.show_robot(robot_file)

    def show_figures(self, plan: Plan, rollout: Rollout | None, layers: Sequence[Layer]) -> None:
        """A motion's numbers and curves."""
        self._plan_figures.content = summaries.plan_figures(plan)
        self._residuals.content = summaries.residuals(plan.violations)
        self.export.show_motion(simulated=rollout is not None)
        self._rollout_figures.visible = rollout is not None
        if rollout is not None:
            self._rollout_figures.content = summaries.rollout_figures(rollout)
        self._layers = tuple(layers)
        self.show_plots()
        self.view.show_legend(simulated=rollout is not None)

    def clear_plan(self) -> None:
        """No plan's numbers."""
        for handle in (self._timeline, self._plan_figures, self._residuals):
            handle.content = ""
        self._layers = ()
        self.show_plots()
        self._rollout_figures.visible = False
        self.export.clear()

    def show_end(self, end: float) -> None:
        """How long the motion is, s."""
        self._end = end
        self._time.max = round(max(end, 0.01), 2)

    def show_time(self, time: float, *, playing: bool) -> None:
        """Where the motion is, s.

        Nothing moves while it plays: a browser loses what a user enters into a control that is
        being set.
        """
        if not playing:
            put(self._time, round(min(time, self._end), 2))

    def show_timeline(self, events: Timeline, time: float) -> None:
        """The timeline, where the page does not draw its own."""
        self._timeline.visible = True
        self._timeline.content = timeline_html.html(events, time)

    def hide_timeline(self) -> None:
        """The page draws its own."""
        self._timeline.visible = False

    def show_plots(self) -> None:
        """The curves that were chosen, of what is shown."""
        self._plots.draw(self._layers, self._end, self._plot_choice, moving=False)

    def _plots_chosen(self, choice: PlotChoice) -> None:
        self._plot_choice = choice
        self._act(Action.LAYERS)

    def notify(self, title: str, body: str) -> None:
        """A passing remark."""
        self._client.add_notification(title, body, auto_close_seconds=6.0, color="orange")

    # ---- inside

    def _show_cancel(self) -> None:
        self._cancel.disabled = not (self._busy or self._exporting)

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
        for handle in self.view.handles:
            handle.on_update(self._told(Action.LAYERS))
        for button, action in (
            (self.simulation.button, Action.SIMULATE),
            (self._cancel, Action.CANCEL),
            (self._nearest, Action.NEAREST),
            (self.export.button, Action.EXPORT),
            (self.export.stop, Action.STOP_EXPORT),
            (self.compare.pin, Action.PIN),
            (self.compare.unpin, Action.UNPIN),
            (self.compare.take_up, Action.TAKE_UP),
        ):
            button.on_click(self._told(action))

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
