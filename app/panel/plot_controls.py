"""The controls by which charts are chosen."""

from collections.abc import Sequence
from dataclasses import replace

import viser

from app.panel.acts import Act, Buttons, Put, add_buttons, callback
from app.panel.fields import Field, Fields
from app.plots.charts import Layer, components_offered, name_of
from app.plots.choice import ALL, EACH, OWN, PRESETS, ChartChoice, PlotChoice
from app.plots.signals import SIGNALS, joint_kinds
from app.viser_private import uuid_of

_KEYS = {signal.title: key for key, signal in SIGNALS.items()}

# What the menus are about: the layers that are drawn, of which the last one's robot has the joints
# and feet to choose from.
About = Sequence[Layer]


def _component(choice: PlotChoice) -> str:
    chart = choice.offered
    return EACH if chart.each else (*chart.components, ALL)[0]


def _with_component(choice: PlotChoice, name: str) -> PlotChoice:
    components = () if name in (ALL, EACH) else (name,)
    chart = ChartChoice(choice.offered.signal, components, each=name == EACH)
    return replace(choice, offered=chart)


_SHOWN: tuple[Field[PlotChoice], ...] = (
    Field(
        "Plot area",
        "Show charts over time below the picture",
        get=lambda choice: choice.open,
        put=lambda choice, on: replace(choice, open=on),
    ),
    Field(
        "Preset",
        "Set of charts",
        get=lambda choice: choice.preset,
        put=lambda choice, name: choice.with_preset(name) if name in PRESETS else choice,
        options=(*PRESETS, OWN),
    ),
    Field(
        "Joints",
        "The joints whose loads are shown",
        get=lambda choice: choice.joints or "",
        put=PlotChoice.with_joints,
        options=lambda choice, layers: (
            joint_kinds(layers[-1].series.robot) if choice.joints and layers else ()
        ),
        there=lambda choice: choice.joints is not None,
    ),
    Field(
        "Landing zoom",
        "Show the time around the touchdown closely",
        get=lambda choice: choice.landing,
        put=lambda choice, on: replace(choice, landing=on),
    ),
)
_OFFERED: tuple[Field[PlotChoice], ...] = (
    Field(
        "Quantity",
        "Quantity to add as a chart",
        get=lambda choice: SIGNALS[choice.offered.signal].title,
        put=lambda choice, title: replace(choice, offered=ChartChoice(_KEYS[title])),
        options=tuple(_KEYS),
    ),
    Field(
        "Component",
        "Axes, feet or joints, in one chart or in one chart each",
        get=_component,
        put=_with_component,
        options=lambda choice, layers: components_offered(choice.offered.signal, layers[::-1]),
    ),
)
_REMOVED: Field[PlotChoice] = Field(
    "Chart",
    "Chart to remove",
    get=lambda choice: name_of(choice.to_remove),
    put=lambda choice, name: replace(
        choice, removable=next((c for c in choice.charts if name_of(c) == name), None)
    ),
    options=lambda choice, _: tuple(map(name_of, choice.charts)),
    there=lambda choice: bool(choice.charts),
    stays=True,
)


class PlotControls:
    """Menus and buttons, in the container that is open."""

    def __init__(self, gui: viser.GuiApi, choice: PlotChoice, put: Put) -> None:
        self.fields = Fields(gui, choice, (), put, Act.PLOTS)
        self.fields.add(*_SHOWN)
        self.fields.add(*_OFFERED)
        self.buttons: Buttons = add_buttons(gui, "add chart", put)
        self.fields.add(_REMOVED)
        self.buttons |= add_buttons(gui, "charts", put)
        # Hidden; the page's script sets it when the area is opened or minimised.
        self._area = gui.add_checkbox("", True, visible=False)
        self._area.on_update(callback(put, Act.PLOT_AREA))
        self.area_open = True  # as it was read last

    def read_area(self, choice: PlotChoice) -> PlotChoice:
        """The choice with the area as the page says that it is."""
        self.area_open = self._area.value is True
        return replace(choice, open=self.area_open)

    @property
    def watched(self) -> tuple[str, ...]:
        """Uuids for static/plots.js: what opens the area, what is told that it is, what adds."""
        handles = (self.fields.handle(_SHOWN[0]), self._area, self.buttons[Act.ADD_CHART])
        return tuple(map(uuid_of, handles))
