"""A tab's state as picture, panel and plots: what has changed since it was drawn last is drawn."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import viser

from app.link import PageLink
from app.motion import colours
from app.motion.colours import Rgb
from app.panel.comparison import Column
from app.panel.panel import Panel
from app.panel.view_controls import configure_theme
from app.picture.drawing import Meaning
from app.picture.foothold_handles import FootholdHandles
from app.picture.ground_clicks import GroundClicks
from app.picture.landing_handles import LandingHandles
from app.picture.overlays import OVERLAYS
from app.picture.overlays.inertia_ellipsoids import InertiaEllipsoids
from app.picture.overlays.landing_marks import LandingMarks
from app.picture.picture import Picture, Standing
from app.picture.push_handle import PushHandle
from app.picture.scene import Scene
from app.plots.charts import Layer
from app.plots.plots import Plots
from app.tab.acts import is_enabled, is_visible
from app.tab.atlas import AtlasDrawing, Atlases
from app.tab.contenders import Comparing, Contender, card
from app.tab.foreign import card as repair_card
from app.tab.planning.feasible import Tint
from app.tab.plotting import layers_of, titles
from app.tab.pushing import push_shown
from app.tab.repairing import offer
from app.tab.routing import DRAWING
from app.tab.shaping import handles_of
from app.tab.simulating import status_of
from app.tab.start.preferences import preferences
from app.tab.state import TabState
from llsrbm.analysis.figures import figures_of_plan
from llsrbm.look.palette import css
from llsrbm.look.timeline import timeline
from llsrbm.motion.rollout import Rollout


class Rendering:
    """One tab's picture, panel and plots, for the session's thread; it holds no fact."""

    def __init__(
        self,
        client: viser.ClientHandle,  # the tab
        link: PageLink,  # to the scripts in its page
        state: TabState,  # to begin with; it is drawn by `draw`
        atlases: Atlases,  # to choose from
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
            state.plots,
            state.robots,
            atlases.names,
            put=put,
            open_file=open_file,
        )
        link.call("panel.arrange", self.panel.arrangement)
        link.call("tips.set", self.panel.hints)
        self.atlas = AtlasDrawing(self.panel.atlas, link, atlases)  # its map
        self._tint = Tint(link, self.panel.jump.tinted)
        self._plots = Plots(client, self.panel.plots.watched)
        self._scene = Scene(client)

        def paint(node: str) -> None:
            link.call("handles.paint", node, colours.TARGET)

        # where to land, in the picture, and where single feet land
        self.handles = LandingHandles(client, put, paint)
        self.footholds = FootholdHandles(client, put, paint)
        self._clicks = GroundClicks(client, put)
        self._push = PushHandle(client)
        self._drawn: TabState | None = None
        self._layers: tuple[Layer, ...] = ()
        # name -> what was drawn of it last
        self._last: dict[str, Any] = {
            "remark": "",
            "shortcuts": True,
            "night": False,
            "drawing": False,
        }

    def _changed(self, name: str, value: Any) -> bool:
        """Whether something is to be drawn that differs from what was drawn of that name."""
        same = name in self._last and self._last[name] == value
        self._last[name] = value
        return not same

    def draw(self, state: TabState) -> None:
        """Draw what has changed."""
        before = self._drawn
        if before is state:
            return
        self._drawn = state
        with self._client.atomic():
            picture = picture_of(state)
            self._draw_panel(state)
            swatches = self.panel.view.swatches(picture)
            if self._changed("swatches", swatches):
                self._link.call("panel.swatches", swatches)
            self._draw_picture(state, picture)
            self._draw_numbers(state)
            self.atlas.draw(state)
            # Before it is there, the page has not said what it kept.
            kept = (state.view, state.plots, state.export.format, state.dark)
            if state.page and self._changed("preferences", kept):
                self._link.call("page.prefer", preferences(state))
            self._tint.draw(state)
        # viser would gather messages for up to a sixtieth of a second.
        self._client.flush()

    # ---- panel

    def _draw_panel(self, state: TabState) -> None:
        """Set what the panel shows; viser sends what has changed of it."""
        panel, design = self.panel, state.design
        panel.show_status(status_of(state))
        self._draw_card(state)
        for act, button in panel.buttons.items():
            button.disabled = not is_enabled(act, state)
            button.visible = is_visible(act, state)
        robot = state.robot if state.ready else None
        panel.jump.show(design.jump, robot, state.ends)
        panel.route.show(state.chosen_landing)
        far = state.far
        sentence = "" if far is None else far.sentence(design)
        old = far is not None and not far.answers(design)
        panel.show_far(sentence, busy=far is not None and far.running, old=old)
        panel.jump.whole_body.show(state.whole_body, None)
        panel.scenario.fields.show(design.scenario, state.file)
        panel.scenario.automatic.show(state.automatic, None)
        panel.view.fields.show(state.view, None)
        busy = state.files.saving_note or state.files.opening_note
        panel.files.show(state.note, state.file_choice, busy)
        if robot is not None:
            if self._changed("robot", robot):
                panel.show_robot(robot)
            other_table = panel.tuning.show_robot(robot, design.jump.type)
            if self._changed("tuning", design.tuning) or other_table:
                panel.tuning.show(design.tuning)
                self._link.call("tuning.show", design.tuning)
        if self._changed("seeds", state.seeds):
            seeds = state.seeds
            worst = None if seeds is None or seeds.worst is None else seeds.worst.scenario.seed
            panel.scenario.show_seeds(() if seeds is None else seeds.results, worst)
        if self._changed("night", state.view.night):
            configure_theme(self._client.gui, dark=state.view.night)
        if self._changed("shortcuts", state.view.shortcuts):
            self._link.call("panel.setShortcuts", state.view.shortcuts)
        # The certificate of another motion is of no interest.
        check, of = state.check, "plan" if state.rollout is None else "simulation"
        if check is None or check.motion is not state.motion:
            panel.show_certificate(None, of, "")
        else:
            panel.show_certificate(check.certificate, of, check.note)

    def _draw_card(self, state: TabState) -> None:
        """The comparison, or the motion of a file that is open."""
        foreign = state.foreign
        if state.comparing is not None or foreign is None:
            if self._changed("card", state.comparing):
                self._link.call("compare.show", card(state.comparing))
            return
        repaired, repairing = foreign.is_shown(state.plan), state.repairing
        offered = offer(state)
        if self._changed("card", (foreign, repaired, repairing, offered)):
            words = repair_card(foreign, repaired=repaired, repairing=repairing, offer=offered)
            self._link.call("compare.show", words)

    # ---- picture

    def _draw_picture(self, state: TabState, picture: Picture) -> None:
        clip = self._scene.draw(picture)
        if clip is not None:
            shown = state.seen
            if shown is not None:
                clip = replace(clip, request=shown.request.as_dict())
            events = None if shown is None else timeline(shown.plan, shown.rollout)
            # A motion that is pinned may go on when the one that is shown stands.
            self._link.load(clip, events and replace(events, end=max(events.end, clip.end)))
        handles = handles_of(state)
        if self._changed("handles", handles):
            self._link.call("shaping.show", handles and handles.plain())
        drawing = state.drawing is not None and not state.comparing
        self._clicks.draw(wanted=drawing)
        if self._changed("drawing", drawing):
            self._link.call("parts.setQuiet", drawing)
        remark = DRAWING if drawing else "" if state.comparing else state.remark
        legend = legend_of(picture)
        if self._changed("legend", legend):
            self._link.call("legend.show", [(css(colour), words) for colour, words in legend])
        if self._changed("remark", remark):
            self._link.call("remark.show", remark)
        robot = state.robot if state.ready else None
        visible = LandingMarks.name in picture.layers and state.shown is not None
        appears = self._scene.appeared
        appears |= self.handles.draw(state.design.jump, robot, visible=visible)
        # A click on a foot's square would be its own.
        of_feet = visible and not drawing
        appears |= self.footholds.draw(state.design.jump, robot, visible=of_feet)
        if self._push.draw(None if picture.row else push_shown(state)) or appears:
            self._link.call("player.settle")

    # ---- numbers and curves

    def _draw_numbers(self, state: TabState) -> None:
        shown, last = state.seen, self._last
        plots = state.plots_seen
        wanted = (state.pins, state.pin_chosen, state.beside, state.comparing, plots)
        if state.moving and shown is not None and wanted == last.get("numbers"):
            return  # the next draft follows: only what is seen at a glance is drawn
        last["numbers"] = wanted
        of_pins = (state.pins, state.pin_chosen, state.beside)
        if self._changed("compared", (shown, state.comparing, of_pins)):
            self._layers = layers_of(state)
            self._compare(state)
        end = 0.0 if shown is None else float(timeline(shown.plan, shown.rollout).end)
        area_open = self.panel.plots.area_open
        layers = self._plots.draw(self._layers, end, plots, area_open=area_open)
        self.panel.plots.fields.show(plots, layers)

    def _compare(self, state: TabState) -> None:
        shown, comparing = state.seen, state.comparing
        if shown is None:
            self.panel.show_figures(None, None)
            self.panel.comparison.show(None, (), -1)
            self._show_chips([], state)
            return
        if comparing is not None and comparing.last is not None:
            self.panel.show_figures(shown.plan, shown.rollout)
            last, *others = [_column(each) for each in reversed(comparing.present)]
            self.panel.comparison.show(last, others, -1)
            self._show_chips([], state)
            return
        rollout = shown.rollout
        title, *names = titles(state)
        colour = colours.PLANNED if rollout is None else colours.SIMULATED
        figures = figures_of_plan(shown.plan, rollout)
        current = Column(title, colour, figures, _recovered(rollout))
        columns = [
            Column(name, pin.colour, pin.figures, _recovered(pin.rollout))
            for name, pin in zip(names, state.pins, strict=True)
        ]
        self.panel.show_figures(shown.plan, rollout)
        self.panel.comparison.show(current, columns, state.pin_chosen)
        chips = [(column.title, column.colour) for column in (current, *columns)]
        self._show_chips(chips if columns else [], state)

    def _show_chips(self, chips: list[tuple[str, Rgb]], state: TabState) -> None:
        if self._changed("chips", (chips, state.beside)):
            named = [{"title": title, "colour": css(colour)} for title, colour in chips]
            self._link.call("pins.show", named, state.beside)


def picture_of(state: TabState) -> Picture:
    """The picture of a state."""
    shown, view, comparing = state.seen, state.view, state.comparing
    solid = None if shown is None else shown.solid
    compared = comparing is not None and comparing.last is not None
    row = _compared(comparing) if comparing and compared else _pinned_beside(state)
    return Picture(
        robot=state.robot,
        planned=None if shown is None else shown.planned,
        simulated=solid,
        rollout=None if shown is None else shown.rollout,
        pushes=() if compared else state.pushes,
        blocks=() if shown is None else shown.blocks,
        ghosts=() if row else tuple(pin.ghost for pin in state.pins),
        row=row,
        layers=view.layers & _OF_ROWS if compared else view.layers,
        target=state.design.jump,
        night=view.night,
        fine=state.fine,
        # while a slider moves there are drafts
        still=not (row or state.playback.playing or shown is None)
        and shown.plan.refinement is not None,
        prepared=state.prepared,
    )


_OF_ROWS = frozenset({InertiaEllipsoids.name})  # overlays that every robot of a row has


def _compared(comparing: Comparing) -> tuple[Standing, ...]:
    return tuple(
        Standing(
            each.name,
            each.solid.planned.motion.robot,
            each.simulated.frames,
            each.solid.planned.frames,
            each.colour,
            each.solid.blocks,
        )
        for each in comparing.present
    )


def _pinned_beside(state: TabState) -> tuple[Standing, ...]:
    """The robot that is shown, and those that are pinned; none where they are not side by side."""
    shown = state.shown
    if not (state.beside and state.pins) or shown is None or state.robot is None:
        return ()
    first, *names = titles(state)
    planned = shown.planned.frames
    colour = colours.PLANNED if shown.solid is None else colours.SIMULATED
    standing = Standing(first, state.robot, shown.solid or planned, planned, colour, shown.blocks)
    pins = [
        Standing(name, pin.ghost.robot, pin.ghost.frames, pin.motion.frames, pin.colour)
        for name, pin in zip(names, state.pins, strict=True)
    ]
    # A motion that was repaired stands to the left: it is what was before.
    before = None if state.foreign is None else state.foreign.motion.frames
    lefts = [each for each in pins if each.frames is before]
    return (*lefts, standing, *(each for each in pins if each.frames is not before))


def _column(contender: Contender) -> Column:
    shown = contender.solid
    figures = figures_of_plan(shown.plan, shown.rollout)
    return Column(contender.name, contender.colour, figures, _recovered(shown.rollout))


def legend_of(picture: Picture) -> list[Meaning]:
    """The colours of the overlays that are drawn, and what they mean.

    Where two share a colour, as forces and pushes do, the common one says what it means.
    """
    if picture.planned is None or picture.row:
        return []
    drawn = [OVERLAYS[name] for name in OVERLAYS if name in picture.layers]
    meanings = [each for overlay in drawn if overlay.common for each in overlay.legend(picture)]
    others = [each for overlay in drawn if not overlay.common for each in overlay.legend(picture)]
    taken = {colour for colour, _ in meanings}
    return [*meanings, *((colour, words) for colour, words in others if colour not in taken)]


def _recovered(rollout: Rollout | None) -> bool | None:
    """Whether a robot that was pushed recovered; None: it was not pushed."""
    if rollout is None or not rollout.pushes:
        return None
    return rollout.outcome.recovered
