"""A tab's state as picture, panel and plots: what has changed since it was drawn last is drawn."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import viser

from app.link import PageLink
from app.motion import colours
from app.motion.foreign_motion import ForeignMotion
from app.panel.actions import Act
from app.panel.comparison_table import Column
from app.panel.jump_controls import titled
from app.panel.panel import Panel
from app.panel.summaries import seeds_table
from app.panel.view_controls import configure_theme
from app.picture.landing_handle import Grip, LandingHandle
from app.picture.overlays.landing_marks import LandingMarks
from app.picture.picture import Picture
from app.picture.push_handle import PushGrip, PushHandle
from app.picture.scene import Scene
from app.plots.charts import Layer, shown_layers
from app.plots.plots import PlotChoice, Plots
from app.tab.atlas_drawing import AtlasDrawing
from app.tab.atlases import Atlases
from app.tab.comparison import free_colour
from app.tab.events import Event, JumpChosen, ScenarioChosen, ViewChosen
from app.tab.pushing import push_shown
from app.tab.state import Shown, TabState, View
from app.workers.protocol import SimulateJump
from llsrbm.analysis.figures import figures_of_plan
from llsrbm.look.timeline import timeline
from llsrbm.look.titles import Decisions, titles_of
from llsrbm.motion.rollout import Rollout
from llsrbm.request.design import Design
from llsrbm.request.push import Push


class Rendering:
    """One tab's picture, panel and plots; for the session's thread.

    It holds handles and what was drawn last, and no other fact.

    Attributes:
        panel: the controls; atlas: its map.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        link: PageLink,
        state: TabState,
        examples: Mapping[str, Design],
        atlases: Atlases,
        *,
        act: Act,
        choose_example: Callable[[Design], None],
        open_file: Callable[[str, bytes], None],
        choose_plots: Callable[[PlotChoice], None],
        drag_target: Callable[[Grip], None],
        drag_push: Callable[[PushGrip], None],
    ) -> None:
        """Build what every tab has, whatever its state.

        Args:
            client: the tab.
            link: to the scripts in its page.
            state: to begin with; it is drawn by `draw`.
            examples, atlases: to choose from.
            act, choose_example, open_file, choose_plots, drag_target, drag_push: called on viser's
                event loop with what the visitor does; must return at once.
        """
        self._client = client
        self._link = link
        self.panel = Panel(
            client,
            state.design,
            state.robots,
            examples,
            state.view.layers,
            atlases.names,
            act=act,
            choose_example=choose_example,
            open_file=open_file,
        )
        link.arrange(self.panel.arrangement)
        self.atlas = AtlasDrawing(self.panel.atlas, link, atlases)
        with self.panel.plots_tab:
            self._plots = Plots(client, choose_plots)
        self._scene = Scene(client)
        self._handle = LandingHandle(client, drag_target)
        self._push = PushHandle(client, drag_push)
        self._drawn: TabState | None = None
        # Where the controls stand, as far as they were read or set: what a hand is moving must not
        # be set to where it was a moment ago.
        self._controls: Design = state.design
        self._view: View = state.view
        self._figures_of: tuple[object, object] = (None, None)
        self._layers: tuple[Layer, ...] = ()

    def note(self, event: Event) -> None:
        """Take note of where the controls stand: the event was read from them."""
        match event:
            case JumpChosen(jump, tuning):
                tuning = self._controls.tuning if tuning is None else tuning
                self._controls = replace(self._controls, jump=jump, tuning=tuning)
            case ScenarioChosen(scenario):
                self._controls = replace(self._controls, scenario=scenario)
            case ViewChosen(layers, night):
                self._view = replace(self._view, layers=layers, night=night)

    def reset_controls(self, state: TabState) -> None:
        """Put the controls where the state has them, wherever they were read."""
        self._show_design(state, anew=True)

    def draw(self, state: TabState) -> None:
        """Draw what has changed."""
        before = self._drawn
        if before is state:
            return
        self._drawn = state
        with self._client.atomic():
            self._draw_panel(state, before)
            self._draw_picture(state)
            self._draw_numbers(state)
            self.atlas.draw(state)
        # viser would gather messages for up to a sixtieth of a second.
        self._client.flush()

    # ---- panel

    def _draw_panel(self, state: TabState, before: TabState | None) -> None:
        panel = self.panel
        if before is None or state.status is not before.status:
            panel.show_status(state.status)
        panel.show_busy(state.status.busy or state.files.saving > 0)
        if before is None or state.history is not before.history:
            panel.show_history(back=bool(state.history.back), forth=bool(state.history.forth))
        nearest = state.work.nearest
        if before is None or nearest is not before.work.nearest:
            panel.offer_nearest(None if nearest is None else nearest.changes)
        self._show_design(state, anew=before is not None and state.file is not before.file)
        if before is None or (state.note, state.design.title, state.csv_rate) != (
            before.note,
            before.design.title,
            before.csv_rate,
        ):
            panel.designs.show(state.design.title, state.note, rate=state.csv_rate)
        if before is None or state.files is not before.files or state.shown is not before.shown:
            busy = state.files.saving_note or state.files.opening_note
            panel.export.show(there=state.shown is not None, busy=busy)
        if before is None or (state.rollout is None) != (before.rollout is None):
            panel.export_options.show(simulated=state.rollout is not None)
        if before is None or _legend(state) != _legend(before):
            simulated, pushed, replans = _legend(state)[1]
            panel.view.show_legend(
                state.view.layers, simulated=simulated, pushed=pushed, replans=replans
            )
        if before is None or state.seeds is not before.seeds:
            seeds = state.seeds
            worst = None if seeds is None or seeds.worst is None else seeds.worst.scenario.seed
            panel.simulation.show_seeds(
                "" if seeds is None else seeds_table(seeds.results, worst), worst=worst is not None
            )
        if state.view.night != (before is not None and before.view.night):
            configure_theme(self._client.gui, dark=state.view.night)
        if (state.view.layers, state.view.night) != (self._view.layers, self._view.night):
            panel.view.show(state.view.layers, night=state.view.night)
            self._view = state.view

    def _show_design(self, state: TabState, *, anew: bool) -> None:
        """Put the controls where the design has them, as far as they stand elsewhere."""
        design, panel, controls = state.design, self.panel, self._controls
        robot = state.robot if state.ready else None
        other_types = robot is not None and panel.jump.show_robot(robot, design.jump.type)
        if anew or design.jump != controls.jump:
            panel.jump.show(design.jump)
        elif other_types:  # sliders stay where a hand may just have put them
            panel.jump.show_asked(design.jump)
        if anew or design.scenario != controls.scenario:
            panel.simulation.show(design.scenario, state.file)
        if robot is not None and panel.tuning.show_robot(robot, design.jump.type):
            anew = True
        if robot is not None and (anew or design.tuning != controls.tuning):
            panel.tuning.show(design.tuning)
            self._link.show_tuning(design.tuning)
        self._controls = design

    # ---- picture

    def _draw_picture(self, state: TabState) -> None:
        clip = self._scene.draw(picture_of(state))
        if clip is not None:
            shown = state.shown
            events = None if shown is None else timeline(shown.plan, state.rollout)
            # A motion that is pinned may go on when the one that is shown stands.
            self._link.load(clip, events and replace(events, end=max(events.end, clip.end)))
        robot = state.robot if state.ready else None
        visible = LandingMarks.name in state.view.layers and state.shown is not None
        self._handle.draw(state.design.jump, robot, visible=visible)
        if self._push.draw(push_shown(state)):
            self._link.settle()

    # ---- numbers and curves

    def _draw_numbers(self, state: TabState) -> None:
        shown = state.shown
        if state.planning and shown is not None:
            return  # the next plan follows soon: only what is seen at a glance is drawn
        if (shown, state.pins) != self._figures_of:
            self._figures_of = (shown, state.pins)
            self._layers = ()
            if shown is None:
                self.panel.show_figures(None, None)
                self.panel.compare.show(None, (), -1, full=False)
            else:
                self._compare(state, shown)
        elif shown is not None and self.panel.compare.chosen != state.pin_chosen:
            self._compare(state, shown)
        end = 0.0 if shown is None else float(timeline(shown.plan, state.rollout).end)
        self._plots.draw(self._layers, end, state.plots, moving=False)

    def _compare(self, state: TabState, shown: Shown) -> None:
        rollout = shown.rollout
        current: Decisions = (
            shown.plan.jump,
            shown.plan.tuning,
            None if rollout is None else rollout.scenario,
        )
        decisions = [pin.decisions for pin in state.pins]
        known = [current, *(each for each in decisions if each is not None)]
        title, *titles = titles_of(
            [(titled(jump, state.robots), tuning, scene) for jump, tuning, scene in known]
        )
        next_title = iter(titles)
        layers, columns = [*shown_layers(shown.planned, rollout)], []
        for pin in state.pins:
            name = pin.motion.name if isinstance(pin.motion, ForeignMotion) else next(next_title)
            layers.append(Layer(name, pin.colour, pin.motion, pin.rollout, pinned=True))
            columns.append(Column(name, pin.colour, pin.figures, _recovered(pin.rollout)))
        self._layers = tuple(layers)
        self.panel.show_figures(shown.plan, rollout)
        colour = colours.PLANNED if rollout is None else colours.SIMULATED
        self.panel.compare.show(
            Column(title, colour, figures_of_plan(shown.plan, rollout), _recovered(rollout)),
            columns,
            state.pin_chosen,
            full=free_colour(state.pins) is None,
        )


def picture_of(state: TabState) -> Picture:
    """The picture of a state."""
    shown, view = state.shown, state.view
    return Picture(
        robot=state.robot,
        planned=None if shown is None else shown.planned,
        simulated=None if shown is None else shown.solid,
        rollout=state.rollout,
        pushes=_pushes(state),
        blocks=() if shown is None else shown.blocks,
        ghosts=tuple(pin.ghost for pin in state.pins),
        layers=view.layers,
        target=state.design.jump,
        night=view.night,
        fine=view.fine,
        prepared=state.prepared,
    )


def _legend(state: TabState) -> tuple[frozenset[str], tuple[bool, bool, bool]]:
    """What the legend is of: overlays; whether simulated, pushed, and planned anew."""
    rollout = state.rollout
    if rollout is None:
        return state.view.layers, (False, False, False)
    return state.view.layers, (True, bool(_pushes(state)), rollout.scenario.replan)


def _recovered(rollout: Rollout | None) -> bool | None:
    """Whether a robot that was pushed recovered; None: it was not pushed."""
    if rollout is None or not rollout.pushes:
        return None
    return rollout.outcome.recovered


def _pushes(state: TabState) -> tuple[Push, ...]:
    """Pushes of the simulation that is shown."""
    shown, task = state.shown, state.work.awaited
    if shown is None:
        return ()
    if shown.so_far is not None and isinstance(task, SimulateJump):
        return task.scenario.pushes
    return () if shown.rollout is None else shown.rollout.pushes
