"""One tab's controls and what they show. Labels are part of the contract.

One scroll, from the top: undo and files as icons; robot, jump and sliders; the verdict; the model;
Simulate with its scenario, folded; the export; details, folded, in tabs. The panel holds no facts:
it is read and drawn by the session's thread.
"""

from collections.abc import Callable, Mapping, Sequence
from html import escape
from typing import Any

import viser

from app.panel import html, summaries
from app.panel.acts import Act, Put, add_buttons
from app.panel.atlas_controls import AtlasControls
from app.panel.certificate import certificate_table
from app.panel.comparison import ComparisonControls
from app.panel.file_controls import FileControls
from app.panel.jump_controls import JumpControls
from app.panel.plot_controls import PlotControls
from app.panel.route_controls import RouteControls
from app.panel.scenario_controls import ScenarioControls
from app.panel.status import Status
from app.panel.tuning import TuningControls
from app.panel.view_controls import View, ViewControls
from app.plots.choice import PlotChoice
from app.viser_private import uuid_of
from llsrbm.certificate import Certificate
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.request.design import Design
from llsrbm.robots import Robot, RobotFile

_WHAT_IT_IS = "Design a jump; see why inertia matters."
_NO_PLAN = "No plan yet: choose a robot, move a slider, and its figures appear here."
_NO_SIMULATION = "No simulation yet: Simulate has the whole robot follow the plan."
_NO_CERTIFICATE = (
    "Stops, drives, friction, slip, distances and dynamics of the motion shown, at 1 kHz."
)
_NO_RESIDUALS = "The largest violation of each constraint appears with the first plan."


class Panel:
    """The controls of one tab; for the session's thread."""

    def __init__(
        self,
        client: viser.ClientHandle,  # whose tab
        design: Design,  # design, view, plots: to start from
        view: View,
        plots: PlotChoice,
        robots: Mapping[str, RobotFile],  # name -> file of each robot to choose from
        sweeps: Sequence[str],  # names of the sweeps whose atlases can be chosen
        *,
        put: Put,  # called with what the visitor did
        open_file: Callable[[str, bytes], None],  # called with the name and content of a file
    ) -> None:
        """The callbacks are called on viser's event loop, and must return at once."""
        gui = client.gui
        gui.add_html(html.note(_WHAT_IT_IS, kind="h1"))
        self.buttons = add_buttons(gui, "examples", put)  # all of them, by their acts
        self.buttons |= add_buttons(gui, "share", put)
        self.files = FileControls(client, put, open_file)
        self.buttons |= add_buttons(gui, "help", put)
        self.buttons |= add_buttons(gui, "history", put)
        self.jump = JumpControls(gui, design.jump, robots, put)
        self._far = gui.add_html("", visible=False)
        self.buttons |= add_buttons(gui, "far", put)
        self._status = gui.add_html("")
        self.buttons |= add_buttons(gui, "verdict", put)
        self.jump.add_model()
        self.buttons |= add_buttons(gui, "compare", put)
        self.buttons |= add_buttons(gui, "main", put)
        self.files.add_progress()
        with gui.add_folder("Scenario", expand_by_default=False):
            self.scenario = ScenarioControls(gui, robots[design.jump.robot], put)
        self.files.add_export()
        with gui.add_folder("Details", expand_by_default=False):
            self._add_details(gui, design, view, plots, sweeps, put)
        details = self.comparison, self.plots, self.route, self.tuning
        groups = (self.jump, self.files, self.scenario, *details)
        for group in groups:
            self.buttons |= group.buttons

    def _add_details(
        self,
        gui: viser.GuiApi,
        design: Design,
        view: View,
        plots: PlotChoice,
        sweeps: Sequence[str],
        put: Put,
    ) -> None:
        """The rest, which a first jump does not need, in tabs."""
        tabs = gui.add_tab_group()
        with tabs.add_tab("View"):
            self.view = ViewControls(gui, view, put)
        with tabs.add_tab("Results"):
            self._certificate = gui.add_html("")
            self.buttons |= add_buttons(gui, "certificate", put)
            self.comparison = ComparisonControls(gui, put)
            self._rollout_figures = gui.add_html(html.note(_NO_SIMULATION))
            self._plan_figures = gui.add_html(html.note(_NO_PLAN))
            self._drives = gui.add_html("")
            with gui.add_folder("Residuals", expand_by_default=False):
                self._residuals = gui.add_html(html.note(_NO_RESIDUALS))
        with tabs.add_tab("Plots"):
            self.plots = PlotControls(gui, plots, put)
        with tabs.add_tab("Files"):
            self.files.add_tab()
        with tabs.add_tab("More"):
            self.jump.add_whole_body()
            with gui.add_folder("Footholds", expand_by_default=False):
                self.buttons |= self.jump.footholds.add()
            with gui.add_folder("Slopes", expand_by_default=False):
                self.jump.add_slopes()
            with gui.add_folder("Route", expand_by_default=False):
                self.route = RouteControls(gui, design.jump, put)
            with gui.add_folder("Limits", expand_by_default=False):
                self.jump.add_payload()
                self.tuning = TuningControls(gui, put)
            with gui.add_folder("Atlas", expand_by_default=False):
                self.atlas = AtlasControls(gui, sweeps, put)

    @property
    def arrangement(self) -> dict[str, Any]:
        """Uuids of the controls that stand in rows (static/panel.js)."""
        robot, kind, arms = map(uuid_of, self.jump.menus)
        icons = [self.buttons[act] for act in (Act.SHARE, Act.HELP, Act.UNDO, Act.REDO)]
        return {
            "examples": uuid_of(self.buttons[Act.EXAMPLES]),
            "icons": [uuid_of(button) for button in (*icons, self.files.open)],
            "undo": uuid_of(self.buttons[Act.UNDO]),
            "redo": uuid_of(self.buttons[Act.REDO]),
            "far": self.jump.how_far,
            "largest": uuid_of(self.buttons[Act.USE_LARGEST]),
            "nearest": uuid_of(self.buttons[Act.NEAREST]),
            "format": uuid_of(self.files.format),
            "save": uuid_of(self.buttons[Act.EXPORT]),
            "choose": uuid_of(self.buttons[Act.CHOOSE_EXPORT]),
            "menus": [robot, kind, arms],
            "model": [uuid_of(self.jump.model), uuid_of(self.buttons[Act.COMPARE_MODELS])],
            "main": uuid_of(self.buttons[Act.SIMULATE]),
            "cancel": uuid_of(self.buttons[Act.CANCEL]),
        }

    @property
    def hints(self) -> dict[str, tuple[str, str]]:
        """Label and meaning of each control, by its uuid."""
        view, files, scenario = self.view, self.files, self.scenario
        return {
            **self.jump.hints,
            **self.route.fields.hints,
            **scenario.fields.hints,
            **scenario.automatic.hints,
            **view.fields.hints,
            **files.hints,
            **self.plots.fields.hints,
            **self.atlas.hints,
            **self.comparison.hints,
            **{
                uuid_of(handle): (act.value.label, act.value.hint)
                for act, handle in self.buttons.items()
                if act.value.hint
            },
        }

    def show_robot(self, robot: Robot) -> None:
        """The numbers of its drives, and how they are known."""
        self._drives.content = summaries.drive_figures(robot)

    def show_status(self, status: Status) -> None:
        """The verdict, or the progress with a bar."""
        self._status.content = status.html

    def show_far(self, sentence: str, *, busy: bool, old: bool) -> None:
        """How far the robot jumps, or how far the search for it has come; "": nobody has asked."""
        kind = f"llsrbm-far{' busy' if busy else ''}{' old' if old else ''}"
        words = f'<p class="{kind}" aria-live="polite">{escape(sentence)}</p>'
        self._far.content = words if sentence else ""
        self._far.visible = bool(sentence)

    def show_certificate(self, certificate: Certificate | None, of: str, note: str) -> None:
        """Findings of what is shown (`of`: in words), or a note in their place."""
        self._certificate.content = (
            html.note(note or _NO_CERTIFICATE)
            if certificate is None
            else certificate_table(certificate, of)
        )

    def show_figures(self, plan: Plan | None, rollout: Rollout | None) -> None:
        """A motion's numbers."""
        if plan is None:
            self._plan_figures.content = html.note(_NO_PLAN)
            self._residuals.content = html.note(_NO_RESIDUALS)
        else:
            self._plan_figures.content = summaries.plan_figures(plan)
            self._residuals.content = summaries.residuals(plan.violations)
        self._rollout_figures.content = (
            html.note(_NO_SIMULATION) if rollout is None else summaries.rollout_figures(rollout)
        )
