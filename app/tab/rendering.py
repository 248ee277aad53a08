"""A tab's state as picture, panel and plots: what has changed since it was drawn last is drawn."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import viser

from app.link import PageLink
from app.motion import colours
from app.motion.baked import ForeignMotion
from app.motion.colours import Rgb
from app.panel.acts import Act
from app.panel.comparison import Column
from app.panel.file_controls import FileChoice
from app.panel.jump_controls import titled
from app.panel.panel import Panel
from app.panel.view_controls import View, configure_theme
from app.picture.landing_handle import LandingHandle
from app.picture.overlays.landing_marks import LandingMarks
from app.picture.picture import Picture
from app.picture.push_handle import PushHandle
from app.picture.scene import Scene
from app.plots.charts import Layer, pinned_layer, shown_layers
from app.plots.plots import Plots
from app.tab.acts import is_enabled, is_visible
from app.tab.atlas import AtlasDrawing, Atlases
from app.tab.planning.feasible import Tint
from app.tab.pushing import push_shown
from app.tab.simulating import status_of
from app.tab.start.preferences import preferences
from app.tab.state import Shown, TabState
from llsrbm.analysis.figures import figures_of_plan
from llsrbm.look.timeline import timeline
from llsrbm.look.titles import Decisions, titles_of
from llsrbm.motion.rollout import Rollout
from llsrbm.request.design import Design
from llsrbm.request.jump import Jump
from llsrbm.request.scenario import Scenario


class Rendering:
    """One tab's picture, panel and plots, for the session's thread; it holds no fact."""

    def __init__(
        self,
        client: viser.ClientHandle,  # the tab
        link: PageLink,  # to the scripts in its page
        state: TabState,  # to begin with; it is drawn by `draw`
        examples: Mapping[str, Design],  # examples, atlases: to choose from
        atlases: Atlases,
        *,
        # put, open_file: called on viser's event loop with what the visitor does; must return at
        # once
        put: Callable[[Any], None],
        open_file: Callable[[str, bytes], None],
    ) -> None:
        self._client = client
        self._link = link
        # the controls
        self.panel = Panel(
            client,
            state.design,
            state.view,
            state.robots,
            examples,
            atlases.names,
            put=put,
            choose_example=put,
            open_file=open_file,
        )
        link.arrange(self.panel.arrangement)
        self.atlas = AtlasDrawing(self.panel.atlas, link, atlases)  # its map
        self._tint = Tint(link, self.panel.jump.tinted)
        with self.panel.plots_tab:
            self.plots = Plots(client, put)
        self._scene = Scene(client)
        self._handle = LandingHandle(client, put)
        link.paint_handle(LandingHandle.node, colours.TARGET)
        self._push = PushHandle(client)
        self._drawn: TabState | None = None
        # Where the controls stand, as far as they were read or set: what a hand is moving must not
        # be set to where it was a moment ago.
        self._controls: Design = state.design
        self._view: View = state.view
        self._scenario: Scenario = state.design.scenario  # that is drawn
        self._choice: FileChoice | None = None
        self._buttons: dict[Act, tuple[bool, bool]] = {}
        self._remark = ""  # over the picture
        self._numbers_of: tuple[Any, ...] = ()
        self._compared: tuple[Any, ...] = ()
        self._chips: tuple[list[tuple[str, Rgb]], bool] | None = None
        self._layers: tuple[Layer, ...] = ()
        self._swatches: dict[str, list[str]] = {}
        self._kept: tuple[Any, ...] = ()

    def note(self, event: Any) -> None:
        """Take note of where the controls stand: the event was read from them."""
        match event:
            case Jump():
                self._controls = replace(self._controls, jump=event)
            case Scenario():
                self._controls = replace(self._controls, scenario=event)
            case View():
                self._view = event
            case FileChoice():
                self._choice = event

    def reset_controls(self, state: TabState) -> None:
        """Put the controls where the state has them, wherever they were read."""
        self._show_design(state, anew=True)
        self.panel.files.show_choice(state.file_choice, anew=True)

    def draw(self, state: TabState) -> None:
        """Draw what has changed."""
        before = self._drawn
        if before is state:
            return
        self._drawn = state
        with self._client.atomic():
            picture = picture_of(state)
            self._draw_panel(state, before)
            swatches = self.panel.view.swatches(picture)
            if swatches != self._swatches:
                self._swatches = swatches
                self._link.show_swatches(swatches)
            self._draw_picture(state, picture)
            self._draw_numbers(state)
            self.atlas.draw(state)
            self._keep_preferences(state)
            self._tint.draw(state)
        # viser would gather messages for up to a sixtieth of a second.
        self._client.flush()

    def _keep_preferences(self, state: TabState) -> None:
        kept = (state.view, state.plots, state.export.format, state.dark)
        if state.page and kept != self._kept:  # before that, the page has not said what it kept
            self._kept = kept
            self._link.prefer(preferences(state))

    # ---- panel

    def _draw_panel(self, state: TabState, before: TabState | None) -> None:
        """Set what the panel shows; viser sends what has changed of it."""
        panel = self.panel
        panel.show_status(status_of(state))
        buttons = {act: (is_enabled(act, state), is_visible(act, state)) for act in panel.buttons}
        for act, (enabled, visible) in buttons.items() - self._buttons.items():
            panel.buttons[act].disabled = not enabled
            panel.buttons[act].visible = visible
        self._buttons = buttons
        self._show_design(state, anew=before is not None and state.file != before.file)
        panel.files.show_design(state.design.title, state.note)
        panel.files.show_busy(state.files.saving_note or state.files.opening_note)
        choice = state.file_choice
        if before is None or choice != before.file_choice:
            panel.files.show_choice(choice, anew=choice != self._choice)
            self._choice = choice
        panel.scenario.show_automatic(state.automatic)
        panel.jump.show_whole_body(state.whole_body)
        seeds = state.seeds
        if before is None or seeds is not before.seeds:
            worst = None if seeds is None or seeds.worst is None else seeds.worst.scenario.seed
            panel.scenario.show_seeds(() if seeds is None else seeds.results, worst)
        if state.view.night != (before is not None and before.view.night):
            configure_theme(self._client.gui, dark=state.view.night)
        if before is None or state.view.shortcuts != before.view.shortcuts:
            self._link.set_shortcuts(state.view.shortcuts)
        if state.view != self._view:
            self._view = state.view
            panel.view.fields.show(state.view, None)

        self._draw_certificate(state)

    def _draw_certificate(self, state: TabState) -> None:
        """Of what is shown: that of another motion is of no interest."""
        check, of = state.check, "plan" if state.rollout is None else "simulation"
        if check is None or check.motion is not state.motion:
            self.panel.show_certificate(None, of, "")
        else:
            self.panel.show_certificate(check.certificate, of, check.note)

    def _show_design(self, state: TabState, *, anew: bool) -> None:
        design, panel, controls = state.design, self.panel, self._controls
        robot = state.robot if state.ready else None
        other_types = robot is not None and panel.jump.show_robot(robot, design.jump.type)
        if anew or design.jump != controls.jump:
            panel.jump.show(design.jump)
        elif other_types:  # sliders stay where a hand may just have put them
            panel.jump.show_type(design.jump)
        if robot is not None:
            panel.jump.show_picture(robot, design.jump)
        if anew or design.scenario != controls.scenario:
            panel.scenario.fields.show(design.scenario, state.file)
        elif design.scenario is not self._scenario:
            panel.scenario.fields.show_there(design.scenario)
        self._scenario = design.scenario
        if robot is not None and panel.tuning.show_robot(robot, design.jump.type):
            anew = True
        if robot is not None and (anew or design.tuning != controls.tuning):
            panel.tuning.show(design.tuning)
            self._link.show_tuning(design.tuning)
        self._controls = design

    # ---- picture

    def _draw_picture(self, state: TabState, picture: Picture) -> None:
        clip = self._scene.draw(picture)
        if clip is not None:
            shown = state.shown
            if shown is not None:
                clip = replace(clip, request=shown.request.as_dict())
            events = None if shown is None else timeline(shown.plan, state.rollout)
            # A motion that is pinned may go on when the one that is shown stands.
            self._link.load(clip, events and replace(events, end=max(events.end, clip.end)))
        if state.remark != self._remark:
            self._remark = state.remark
            self._link.remark(state.remark)
        robot = state.robot if state.ready else None
        visible = LandingMarks.name in state.view.layers and state.shown is not None
        self._handle.draw(state.design.jump, robot, visible=visible)
        if self._push.draw(push_shown(state)):
            self._link.settle()

    # ---- numbers and curves

    def _draw_numbers(self, state: TabState) -> None:
        shown = state.shown
        wanted = (state.pins, state.pin_chosen, state.beside, state.plots)
        if state.planning and shown is not None and wanted == self._numbers_of:
            return  # the next plan follows soon: only what is seen at a glance is drawn
        self._numbers_of = wanted
        compared = (shown, state.pins, state.pin_chosen, state.beside)
        if compared != self._compared:
            self._compared = compared
            self._compare(state, shown)
        end = 0.0 if shown is None else float(timeline(shown.plan, state.rollout).end)
        self.plots.draw(self._layers, end, state.plots)

    def _compare(self, state: TabState, shown: Shown | None) -> None:
        if shown is None:
            self._layers = ()
            self.panel.show_figures(None, None)
            self.panel.comparison.show(None, (), -1)
            self._show_chips([], state)
            return
        rollout = shown.rollout
        scenario = None if rollout is None else rollout.scenario
        current: Decisions = (shown.plan.jump, shown.plan.tuning, scenario)
        decisions = [pin.decisions for pin in state.pins]
        known = [current, *(each for each in decisions if each is not None)]
        title, *titles = titles_of(
            [(titled(jump, state.robots), tuning, scene) for jump, tuning, scene in known]
        )
        next_title = iter(titles)
        layers, columns = [*shown_layers(shown.planned, rollout)], []
        for pin in state.pins:
            name = pin.motion.name if isinstance(pin.motion, ForeignMotion) else next(next_title)
            layers.append(pinned_layer(name, pin.colour, pin.motion, pin.rollout))
            columns.append(Column(name, pin.colour, pin.figures, _recovered(pin.rollout)))
        self._layers = tuple(layers)
        self.panel.show_figures(shown.plan, rollout)
        colour = colours.PLANNED if rollout is None else colours.SIMULATED
        figures = figures_of_plan(shown.plan, rollout)
        self.panel.comparison.show(
            Column(title, colour, figures, _recovered(rollout)), columns, state.pin_chosen
        )
        chips = [(title, colour), *((column.title, column.colour) for column in columns)]
        self._show_chips(chips if columns else [], state)

    def _show_chips(self, chips: list[tuple[str, Rgb]], state: TabState) -> None:
        if (chips, state.beside) != self._chips:
            self._chips = (chips, state.beside)
            self._link.show_pins(chips, state.beside)


def picture_of(state: TabState) -> Picture:
    """The picture of a state."""
    shown, view = state.shown, state.view
    return Picture(
        robot=state.robot,
        planned=None if shown is None else shown.planned,
        simulated=None if shown is None else shown.solid,
        rollout=state.rollout,
        pushes=state.pushes,
        blocks=() if shown is None else shown.blocks,
        ghosts=tuple(
            replace(pin.ghost, place=place if state.beside else 0)
            for place, pin in enumerate(state.pins, start=1)
        ),
        layers=view.layers,
        target=state.design.jump,
        night=view.night,
        fine=state.fine,
        prepared=state.prepared,
    )


def _recovered(rollout: Rollout | None) -> bool | None:
    """Whether a robot that was pushed recovered; None: it was not pushed."""
    if rollout is None or not rollout.pushes:
        return None
    return rollout.outcome.recovered
