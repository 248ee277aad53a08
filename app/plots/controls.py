"""Controls by which charts are chosen: they show a choice and report a changed one."""

from __future__ import annotations

from collections.abc import Callable, Coroutine, Sequence
from dataclasses import replace
from typing import Any

import viser

from app.guard.validation import option, put
from app.plots.charts import Layer, components_offered, name_of
from app.plots.choice import (
    ALL,
    ALL_JOINTS,
    DEFAULT,
    EACH,
    MOST_CHARTS,
    OWN,
    PRESETS,
    ChartChoice,
    PlotChoice,
)
from app.plots.signals import SIGNALS, joint_kinds

_KEYS = {signal.title: key for key, signal in SIGNALS.items()}
_NONE = "none"

Change = Callable[[PlotChoice], PlotChoice]


class PlotControls:
    """Dropdowns and buttons, in the container that is open when they are made."""

    def __init__(self, gui: viser.GuiApi, changed: Callable[[PlotChoice], None]) -> None:
        """`changed` is called on the event loop with the user's choice."""
        self._choice = DEFAULT
        self._changed = changed
        # by which the area is opened
        self.open = gui.add_checkbox(
            "Plot area", True, hint="Charts over time below the picture, as wide as it"
        )
        # hidden; the page's script sets it when the area is opened or minimised
        self.seen = gui.add_checkbox("", True, visible=False)
        self.area_open = True  # state of the area, as far as the server knows
        self._preset = gui.add_dropdown("Preset", (*PRESETS, OWN), hint="Charts shown together")
        self._joints = gui.add_dropdown("Joints", (ALL_JOINTS,), visible=False)
        self._landing = gui.add_checkbox(
            "Landing zoom", False, hint="Show the time around the touchdown closely"
        )
        self._quantity = gui.add_dropdown("Quantity", tuple(_KEYS), hint="To be added as a chart")
        self._component = gui.add_dropdown(
            "Component", (ALL,), hint="Axes, feet or joints: together, or a chart each"
        )
        self.add = gui.add_button(
            "Add chart", hint="Or drag this button, or a chart's title, onto a chart"
        )
        self._chart = gui.add_dropdown("Chart", (_NONE,), hint="To be removed")
        self._remove = gui.add_button("Remove chart")
        # saves the lines that are shown
        self.download = gui.add_button(
            "Download", disabled=True, hint="All lines that are shown, at their own instants, CSV"
        )
        for handle, change in (
            (self.open, lambda choice: replace(choice, open=bool(self.open.value))),
            (self.seen, self._seen),
            (self._preset, self._preset_chosen),
            (self._joints, self._joints_chosen),
            (self._landing, lambda choice: replace(choice, landing=bool(self._landing.value))),
            (self._quantity, self._quantity_chosen),
            (self._component, self._component_chosen),
        ):
            handle.on_update(self._reported(change))
        self.add.on_click(self._reported(PlotChoice.with_offered))
        self._remove.on_click(self._reported(self._removed))

    def show(self, choice: PlotChoice, layers: Sequence[Layer]) -> None:
        """Show a choice; the last layer's robot has the joints and feet to choose from."""
        self._choice = choice
        _set(self.open, choice.open)
        _set(self._preset, choice.preset)
        _set(self._landing, choice.landing)
        self._joints.visible = choice.joints is not None and bool(layers)
        if self._joints.visible and choice.joints is not None:
            _offer(self._joints, joint_kinds(layers[-1].series.robot), choice.joints)
        offered = choice.offered
        _set(self._quantity, SIGNALS[offered.signal].title)
        components = components_offered(offered.signal, layers[::-1])
        _offer(self._component, components, _component_name(offered))
        names = [name_of(chart) for chart in choice.charts]
        shown = self._chart.value if self._chart.value in names else None
        _offer(self._chart, names or [_NONE], shown or (names or [_NONE])[-1])
        self.add.disabled = offered in choice.charts or len(names) >= MOST_CHARTS
        self._remove.disabled = not names
        self.download.disabled = not (names and layers)

    # ---- choices; a browser's script can send anything

    def _reported(
        self, change: Change
    ) -> Callable[[viser.GuiEvent[Any]], Coroutine[Any, Any, None]]:
        async def callback(event: viser.GuiEvent[Any]) -> None:
            if event.client_id is None:
                return  # set by `show`
            chosen = change(self._choice)
            if chosen != self._choice:
                # The next change may come before this one is drawn.
                self._choice = chosen
                self._changed(chosen)

        return callback

    def _seen(self, choice: PlotChoice) -> PlotChoice:
        self.area_open = bool(self.seen.value)
        return replace(choice, open=self.area_open)

    def _preset_chosen(self, choice: PlotChoice) -> PlotChoice:
        name = option("Preset", self._preset.value, (*PRESETS, OWN), next(iter(PRESETS)), [])
        return choice if name == OWN else choice.with_preset(name)

    def _joints_chosen(self, choice: PlotChoice) -> PlotChoice:
        kinds = tuple(self._joints.options)
        return choice.with_joints(option("Joints", self._joints.value, kinds, ALL_JOINTS, []))

    def _quantity_chosen(self, choice: PlotChoice) -> PlotChoice:
        title = option("Quantity", self._quantity.value, tuple(_KEYS), next(iter(_KEYS)), [])
        same = choice.offered.signal == _KEYS[title]
        return choice if same else replace(choice, offered=ChartChoice(_KEYS[title]))

    def _component_chosen(self, choice: PlotChoice) -> PlotChoice:
        offered = tuple(self._component.options)
        name = option("Component", self._component.value, offered, ALL, [])
        components = () if name in (ALL, EACH) else (name,)
        chart = ChartChoice(choice.offered.signal, components, each=name == EACH)
        return replace(choice, offered=chart)

    def _removed(self, choice: PlotChoice) -> PlotChoice:
        names = [name_of(chart) for chart in choice.charts]
        if self._chart.value not in names:
            return choice
        return choice.without(names.index(self._chart.value))


def _component_name(chart: ChartChoice) -> str:
    if chart.each:
        return EACH
    return chart.components[0] if chart.components else ALL


def _set(handle: Any, value: str | bool) -> None:
    if handle.value != value:
        put(handle, value)


def _offer(handle: Any, options: Sequence[str], value: str) -> None:
    if tuple(handle.options) != tuple(options):
        handle.options = tuple(options)
    _set(handle, value if value in options else options[0])
