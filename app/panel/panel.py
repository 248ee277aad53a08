"""One tab's controls and what they show. Labels are part of the contract.

What is used all the time stands above: the status, the jump, its simulation and its export. The
rest is in tabs below. The panel holds no facts: it is read and drawn by the session's thread.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import viser

from app.panel import html, summaries
from app.panel.acts import Act, Put, add_buttons
from app.panel.atlas_controls import AtlasControls
from app.panel.comparison import ComparisonControls
from app.panel.file_controls import FileControls
from app.panel.jump_controls import JumpControls
from app.panel.scenario_controls import ScenarioControls
from app.panel.status import Status
from app.panel.tuning import TuningControls
from app.panel.view_controls import View, ViewControls
from app.viser_private import uuid_of
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.request.design import Design
from llsrbm.robots import RobotFile

_HELP = Path(__file__).parents[1] / "static" / "help.md"
_NO_PLAN = "No plan yet: choose a robot, move a slider, and its figures appear here."
_NO_SIMULATION = "No simulation yet: Simulate has the whole robot follow the plan."
_NO_RESIDUALS = "The largest violation of each constraint appears with the first plan."


class Panel:
    """The controls of one tab; for the session's thread."""

    def __init__(
        self,
        client: viser.ClientHandle,  # whose tab
        design: Design,  # design, view: to start from
        view: View,
        robots: Mapping[str, RobotFile],  # name -> file of each robot to choose from
        examples: Mapping[str, Design],  # to choose from
        sweeps: Sequence[str],  # names of the sweeps whose atlases can be chosen
        *,
        put: Put,  # called with what the visitor did
        choose_example: Callable[[Design], None],  # called with the one that was chosen
        open_file: Callable[[str, bytes], None],  # called with the name and content of a file
    ) -> None:
        """The callbacks are called on viser's event loop, and must return at once."""
        gui = client.gui
        self._status = gui.add_html("")
        self.buttons = add_buttons(gui, "top", put)  # all of them, by their acts
        self.jump = JumpControls(gui, design.jump, robots, put)
        self.buttons |= add_buttons(gui, "main", put)
        self.files = FileControls(client, examples, put, choose_example, open_file)
        self.buttons |= add_buttons(gui, "history", put)
        tabs = gui.add_tab_group()
        with tabs.add_tab("View"):
            self.view = ViewControls(gui, view, put)
        with tabs.add_tab("Scenario"):
            self.scenario = ScenarioControls(gui, robots[design.jump.robot], put)
        with tabs.add_tab("Figures"):
            self.comparison = ComparisonControls(gui, put)
            self._rollout_figures = gui.add_html(html.note(_NO_SIMULATION))
            self._plan_figures = gui.add_html(html.note(_NO_PLAN))
            with gui.add_folder("Residuals", expand_by_default=False):
                self._residuals = gui.add_html(html.note(_NO_RESIDUALS))
        self.plots_tab = tabs.add_tab("Plots")  # the container for the controls of the plots
        with tabs.add_tab("Atlas"):
            self.atlas = AtlasControls(gui, sweeps, put)
        with tabs.add_tab("Limits"):
            self.tuning = TuningControls(gui, put)
        with tabs.add_tab("Files"):
            self.files.add_tab()
        with tabs.add_tab("Help"):
            gui.add_html(html.TOUR_BUTTON)
            gui.add_markdown(_HELP.read_text(encoding="utf-8"))
        for group in (self.files, self.scenario, self.comparison, self.tuning):
            self.buttons |= group.buttons

    @property
    def arrangement(self) -> dict[str, str | list[str]]:
        """Uuids of the controls that stand in rows (static/panel.js)."""
        row = (self.files.open, *(self.buttons[act] for act in (Act.UNDO, Act.REDO, Act.SHARE)))
        return {
            "quarters": [uuid_of(button) for button in row],
            "main": uuid_of(self.buttons[Act.SIMULATE]),
            "cancel": uuid_of(self.buttons[Act.CANCEL]),
            "format": uuid_of(self.files.format),
            "save": uuid_of(self.buttons[Act.EXPORT]),
        }

    def show_status(self, status: Status) -> None:
        """One line on the progress, with a bar."""
        self._status.content = status.html

    def offer_nearest(self, changes: str | None) -> None:
        """Name a jump that can be planned, in place of one that cannot; None: there is none."""
        if changes is not None:
            self.buttons[Act.NEAREST].label = f"{Act.NEAREST.value.label}: {changes}"

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
