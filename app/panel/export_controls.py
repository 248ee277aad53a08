"""The controls that say what is saved in which formats, made from the registry of formats."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape
from typing import Any

import viser

from app.guard.validation import number, option, put
from app.panel.html import SMALL
from llsrbm.formats import FORMATS, ORDERS, Format, Options

SIMULATION, PLAN = "simulation", "plan"

_FASTEST, _FASTEST_FILM = 1000.0, 60.0  # frames/s; every one of a film is drawn
_LONGEST_PAD = 10.0  # s


@dataclass(frozen=True)
class Choice:
    """A motion to save, and how.

    Attributes:
        of: `SIMULATION` or `PLAN`.
        formats: names, the one of the list first.
        zipped: whether it shall be a zip, with what describes the files.
        options: those that were changed.
    """

    of: str
    formats: tuple[str, ...]
    zipped: bool
    options: dict[str, Any]


class ExportControls:
    """Format and button, in the container that is open; further options are in `ExportOptions`.

    Attributes:
        button: that saves.
        stop: that gives it up.
        format: the format's dropdown.
    """

    def __init__(self, gui: viser.GuiApi) -> None:
        """Nothing to save yet."""
        self._there = False
        missing = [name for name, each in FORMATS.items() if _missing(each)]
        hint = f"Not installed: {', '.join(missing)}" if missing else None
        self.format = gui.add_dropdown("Format", tuple(FORMATS), hint=hint)
        self.button = gui.add_button(
            "Export", disabled=True, hint="Saves the simulation if there is one, else the plan"
        )
        self._busy = gui.add_html("", visible=False)
        self.stop = gui.add_button("Stop", visible=False, hint="Stop writing this file")

    @property
    def chosen(self) -> str:
        """Name of the format."""
        return option("Format", self.format.value, tuple(FORMATS), next(iter(FORMATS)), [])

    def show(self, *, there: bool, busy: str) -> None:
        """Draw whether there is a motion to save, and what is being saved; "": nothing."""
        self._busy.content = f'<div role="alert" style="{SMALL}">{escape(busy)}</div>'
        self._busy.visible = self.stop.visible = bool(busy)
        self.button.disabled = not there or bool(busy)


class ExportOptions:
    """Which motion, further formats and how they are written, in the container that is open."""

    def __init__(self, gui: viser.GuiApi, controls: ExportControls) -> None:
        """Those of the format that is chosen.

        Args:
            gui: of the tab.
            controls: where the format is chosen.
        """
        self._controls = controls
        self._of = gui.add_dropdown("Trajectory", (SIMULATION, PLAN), visible=False)
        self._line = gui.add_html("")
        defaults = Options()
        self._fps = gui.add_number(
            "Frames per second", defaults.fps, min=1, max=_FASTEST, step=1, visible=False
        )
        self._pad = gui.add_number(
            "Standing still [s]",
            defaults.pad,
            min=0,
            max=_LONGEST_PAD,
            step=0.1,
            visible=False,
            hint="Before the motion and after it",
        )
        self._order = gui.add_dropdown("Order of bodies", ORDERS, visible=False)
        with gui.add_folder("Several in one zip", expand_by_default=False):
            self._ticked = {
                name: gui.add_checkbox(
                    name, initial_value=False, disabled=_missing(each), hint=_line(each)
                )
                for name, each in FORMATS.items()
            }
        self._show_format()
        controls.format.on_update(self._chosen)
        for box in self._ticked.values():
            box.on_update(self._chosen)

    def read(self) -> tuple[Choice, list[str]]:
        """The choice as the controls stand, and the corrections in them."""
        complaints: list[str] = []
        of = option("Trajectory", self._of.value, (SIMULATION, PLAN), SIMULATION, complaints)
        first = option(
            "Format",
            self._controls.format.value,
            tuple(FORMATS),
            next(iter(FORMATS)),
            complaints,
        )
        also = self._also()
        names = tuple(dict.fromkeys((first, *also)))
        fastest = _FASTEST_FILM if _take(names, "size") else _FASTEST
        values = {
            "fps": number("Frames per second", self._fps.value, (1, fastest), complaints),
            "pad": number("Standing still [s]", self._pad.value, (0, _LONGEST_PAD), complaints),
            "order": option("Order of bodies", self._order.value, ORDERS, ORDERS[0], complaints),
        }
        # What stands as the format has it is left to each of them.
        given = {
            name: value
            for name, value in values.items()
            if _take(names, name) and value != getattr(_defaults(names, name), name)
        }
        return Choice(of, names, bool(also), given), complaints

    def show(self, *, simulated: bool) -> None:
        """Draw whether there is a simulation to choose besides the plan; it is chosen then."""
        self._of.visible = simulated
        put(self._of, SIMULATION)

    def _also(self) -> tuple[str, ...]:
        return tuple(name for name, box in self._ticked.items() if box.value is True)

    async def _chosen(self, event: viser.GuiEvent[Any]) -> None:
        if event.client_id is not None:
            self._show_format()

    def _show_format(self) -> None:
        first = self._controls.chosen
        names = tuple(dict.fromkeys((first, *self._also())))
        self._line.content = f'<div style="{SMALL}">{escape(_line(FORMATS[first]))}</div>'
        for name, handle in (("fps", self._fps), ("pad", self._pad), ("order", self._order)):
            handle.visible = _take(names, name)
            # The first one's own, whenever another is chosen.
            put(handle, getattr(_defaults(names, name), name))


def _missing(format_: Format) -> bool:
    return format_.extra is not None and format_.extra.missing


def _line(format_: Format) -> str:
    """A format's title, and the packages that it lacks."""
    needs = f'; not installed: pip install "llsrbm[{format_.extra.name}]"' if format_.extra else ""
    return f"{format_.title}{needs if _missing(format_) else ''}"


def _take(names: tuple[str, ...], option_: str) -> bool:
    return any(option_ in FORMATS[name].options for name in names)


def _defaults(names: tuple[str, ...], option_: str) -> Options:
    """Those of the first format that takes the option."""
    takers = [FORMATS[name].defaults for name in names if option_ in FORMATS[name].options]
    return takers[0] if takers else Options()
