"""One tab's controls and what they show. Labels are part of the contract.

What is used all the time stands above: the status, the jump, its simulation and its export. The
rest is in tabs below. The panel holds no facts: it is read (`app.tab.controls`) and drawn
(`app.tab.rendering`) by the session's thread.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import viser

from app.panel import html, summaries
from app.panel.actions import Act, Action, callback
from app.panel.atlas_controls import AtlasControls
from app.panel.compare_controls import CompareControls
from app.panel.design_controls import DesignControls
from app.panel.export_controls import ExportControls, ExportOptions
from app.panel.jump_controls import JumpControls
from app.panel.simulation_controls import SimulationControls
from app.panel.status import Status, Word
from app.panel.tuning_controls import TuningControls
from app.panel.view_controls import ViewControls
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
    """The controls of one tab; for the session's thread.

    Attributes:
        jump: the controls of the request.
        simulation: those of the scenario.
        tuning: of weights and limits.
        view: of what is drawn.
        compare: of what is pinned.
        designs: of examples and files.
        atlas: of what sweeps have found out.
        export, export_options: of what is saved.
        plots_tab: the container for the controls of the plots.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        design: Design,
        robots: Mapping[str, RobotFile],
        examples: Mapping[str, Design],
        shown: frozenset[str],
        sweeps: Sequence[str],
        *,
        act: Act,
        choose_example: Callable[[Design], None],
        open_file: Callable[[str, bytes], None],
    ) -> None:
        """Build the controls.

        Args:
            client: whose tab.
            design: to start from.
            robots: name -> file of each robot to choose from.
            examples: to choose from.
            shown: names of the overlays that are drawn.
            sweeps: names of the sweeps whose atlases can be chosen.
            act: called with what the visitor did.
            choose_example: called with the one that was chosen.
            open_file: called with the name and content of a file.

        The callbacks are called on viser's event loop, and must return at once.
        """
        gui = client.gui
        file = robots[design.jump.robot]
        self._status = gui.add_html(html.status(Status(Word.PLANNING, "")))
        self._nearest = gui.add_button("Use nearest feasible", visible=False)
        self.jump = JumpControls(gui, design.jump, robots)
        self._simulate = gui.add_button(
            "Simulate", hint="Follow the plan with the whole robot in MuJoCo"
        )
        self._cancel = gui.add_button("Cancel", visible=False, hint="Stop what is being computed")
        self.export = ExportControls(gui)
        self.designs = DesignControls(client, examples, choose_example, open_file)
        self._undo = gui.add_button("Undo", disabled=True, hint="The design before the last change")
        self._redo = gui.add_button("Redo", disabled=True, hint="The design that was undone")
        self._share = gui.add_button("Share", hint="A link that opens this design")
        tabs = gui.add_tab_group()
        with tabs.add_tab("View"):
            self.view = ViewControls(gui, shown)
        with tabs.add_tab("Scenario"):
            self.simulation = SimulationControls(gui, file)
        with tabs.add_tab("Figures"):
            self.compare = CompareControls(gui)
            self._rollout_figures = gui.add_html(html.note(_NO_SIMULATION))
            self._plan_figures = gui.add_html(html.note(_NO_PLAN))
            with gui.add_folder("Residuals", expand_by_default=False):
                self._residuals = gui.add_html(html.note(_NO_RESIDUALS))
        self.plots_tab = tabs.add_tab("Plots")
        with tabs.add_tab("Atlas"):
            self.atlas = AtlasControls(gui, sweeps)
        with tabs.add_tab("Limits"):
            self.tuning = TuningControls(gui)
        with tabs.add_tab("Files"):
            self.designs.add_examples()
            self.export_options = ExportOptions(gui, self.export)
        with tabs.add_tab("Help"):
            gui.add_html(html.TOUR_BUTTON)
            gui.add_markdown(_HELP.read_text(encoding="utf-8"))
        self._listen(act)

    @property
    def arrangement(self) -> dict[str, str | list[str]]:
        """Which controls stand where, by their uuids (static/panel.js)."""
        row = (self.designs.open, self._undo, self._redo, self._share)
        return {
            "quarters": [uuid_of(button) for button in row],
            "main": uuid_of(self._simulate),
            "cancel": uuid_of(self._cancel),
            "format": uuid_of(self.export.format),
            "save": uuid_of(self.export.button),
        }

    # ---- drawn from the state

    def show_status(self, status: Status) -> None:
        """One line on how it goes, and how much of it is done."""
        self._status.content = html.status(status)

    def show_busy(self, busy: bool) -> None:
        """Offer to cancel, while there is something to cancel."""
        self._cancel.visible = busy

    def show_history(self, *, back: bool, forth: bool) -> None:
        """Whether there is a design to go back to, and one to go forth to."""
        self._undo.disabled = not back
        self._redo.disabled = not forth

    def offer_nearest(self, changes: str | None) -> None:
        """A jump that can be planned, in place of one that cannot; None: no offer any more."""
        if changes is not None:
            self._nearest.label = f"Use nearest feasible: {changes}"
        self._nearest.visible = changes is not None

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

    # ---- inside

    def _listen(self, act: Act) -> None:
        for handle in self.jump.handles:
            handle.on_update(callback(act, Action.JUMP))
        for handle in self.simulation.handles:
            handle.on_update(callback(act, Action.SCENARIO))
        for handle in self.view.handles:
            handle.on_update(callback(act, Action.VIEW))
        for handle in self.atlas.handles:
            handle.on_update(callback(act, Action.ATLAS))
        self.compare.choice.on_update(callback(act, Action.PIN_CHOSEN))
        for button, action in (
            (self._simulate, Action.SIMULATE),
            (self.simulation.seeds, Action.SEEDS),
            (self.simulation.push.with_and_without, Action.COMPARE_REPLANNING),
            (self.simulation.push.other_model, Action.COMPARE_MODEL),
            (self.simulation.worst, Action.WORST),
            (self._cancel, Action.CANCEL),
            (self._nearest, Action.NEAREST),
            (self.export.button, Action.EXPORT),
            (self.export.stop, Action.STOP_EXPORT),
            (self.designs.save, Action.SAVE),
            (self.compare.pin, Action.PIN),
            (self.compare.unpin, Action.UNPIN),
            (self.compare.take_up, Action.TAKE_UP),
            (self.tuning.reset, Action.RESET_TUNING),
            (self._undo, Action.UNDO),
            (self._redo, Action.REDO),
            (self._share, Action.SHARE),
        ):
            button.on_click(callback(act, action))
