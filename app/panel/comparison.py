"""Designs beside each other: the controls that keep them, and the table of their figures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import NamedTuple

import viser

from app.motion.colours import Rgb
from app.panel.acts import Act, Buttons, Put, add_buttons
from app.panel.fields import Field, Fields
from app.panel.html import DIM, SMALL, note, swatch
from llsrbm.analysis.figure_table import FIGURES, Figure
from llsrbm.analysis.figures import DesignFigures

_CELL = "padding:0.1em 0 0.1em 0.6em;text-align:right;vertical-align:bottom"


class Pins(NamedTuple):
    """The pinned designs, by their titles."""

    titles: tuple[str, ...]
    chosen: int  # number of one of them; -1: none

    @property
    def names(self) -> tuple[str, ...]:
        """Titles that differ."""
        return tuple(f"{number}. {title}" for number, title in enumerate(self.titles, start=1))


_PINNED: Field[Pins] = Field(
    "Pinned",
    "The pinned design that the buttons below it are about",
    get=lambda pins: pins.names[max(pins.chosen, 0)],
    put=lambda pins, name: pins._replace(chosen=pins.names.index(name)),
    options=lambda pins, _: pins.names,
    there=lambda pins: bool(pins.titles),
)


class ComparisonControls:
    """Pins to choose from and their figures, in the container that is open."""

    def __init__(self, gui: viser.GuiApi, put_act: Put) -> None:
        gui.add_html('<div class="llsrbm-pair"></div>')
        self._empty = gui.add_html(
            note("Nothing pinned. Pin this design: it stays as a ghost beside the next ones.")
        )
        self.buttons: Buttons = add_buttons(gui, "pin", put_act)  # to pin and unpin
        self._table = gui.add_html("", visible=False)
        self._pins = Pins((), -1)
        self._fields = Fields(gui, self._pins, None, put_act, Act.PINNED)
        self._fields.add(_PINNED)
        self.buttons |= add_buttons(gui, "pinned", put_act)

    @property
    def hints(self) -> dict[str, tuple[str, str]]:
        """As `Fields.hints`."""
        return self._fields.hints

    @property
    def chosen(self) -> int:
        """Number of the pin that is chosen; -1 for none."""
        self._pins, _ = self._fields.read(self._pins, None)
        return self._pins.chosen

    def show(self, current: Column | None, pinned: Sequence[Column], chosen: int) -> None:
        """Figures of the current design and of what is pinned, and which pin is chosen."""
        columns = [*([current] if current else []), *pinned]
        self._table.content = comparison_table(columns) if pinned else ""
        self._pins = Pins(tuple(column.title for column in pinned), chosen)
        self._fields.show(self._pins, None)
        self._empty.visible = not pinned
        self._table.visible = bool(pinned)


@dataclass(frozen=True)
class Column:
    """One design."""

    title: str  # its name (`llsrbm.look.titles`)
    colour: Rgb  # of its ghost in the picture and its curves in the plots
    figures: DesignFigures  # its row
    # whether it landed by the strict measure but for the feet's place; None: it was not pushed
    recovered: bool | None = None


def comparison_table(columns: Sequence[Column]) -> str:
    """Figures as rows and designs as columns, the first the current one; "" for none.

    The best of a row is bold, and a cell shows on hover how it differs from the current design.
    Colours and fonts are inherited, so that it can be read in the dark, too; figures that no
    design has are left out.
    """
    if not columns:
        return ""
    names = "".join(
        f"<div>{swatch(column.colour)}{escape(column.title)}</div>" for column in columns
    )
    head = "".join(
        f'<th scope="col" style="{_CELL}" title="{escape(column.title)}">'
        f"{swatch(column.colour)}</th>"
        for column in columns
    )
    status = "".join(
        f'<td style="{_CELL}">{escape(column.figures.status)}</td>' for column in columns
    )
    recovered = ""
    if any(column.recovered is not None for column in columns):
        words = {True: "yes", False: "no", None: "–"}
        cells = "".join(f'<td style="{_CELL}">{words[column.recovered]}</td>' for column in columns)
        recovered = f"<tr>{_name('Recovered from the push')}{cells}</tr>"
    rows = "".join(
        _row(figure, columns)
        for figure in FIGURES
        if any(figure.value(column.figures) is not None for column in columns)
    )
    return (
        f'<div style="{SMALL}">{names}'
        '<table style="border-spacing:0;width:100%;margin-top:0.4em;line-height:1.3;'
        'font-size:12px;color:inherit">'
        f"<thead><tr><td></td>{head}</tr></thead>"
        f"<tbody><tr>{_name('Status')}{status}</tr>{recovered}{rows}</tbody></table></div>"
    )


def _row(figure: Figure, columns: Sequence[Column]) -> str:
    designs = [column.figures for column in columns]
    best = figure.best(designs)
    cells = []
    for index, design in enumerate(designs):
        difference = figure.difference(design, designs[0]) if index else ""
        hover = f' title="{escape(difference)} against the current design"' if difference else ""
        weight = ";font-weight:bold" if index in best else ""
        cells.append(
            f'<td style="{_CELL};font-variant-numeric:tabular-nums{weight}"{hover}>'
            f"{escape(figure.shown(design))}</td>"
        )
    return f"<tr>{_name(figure.title, figure.unit)}{''.join(cells)}</tr>"


def _name(title: str, unit: str = "") -> str:
    shown = f' <span style="white-space:nowrap">[{escape(unit)}]</span>' if unit else ""
    return (
        f'<th scope="row" style="text-align:left;font-weight:normal;{DIM}">'
        f"{escape(title)}{shown}</th>"
    )
