"""The controls that keep designs beside the current one, and the table of their figures."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import viser

from app.guard.validation import put
from app.panel.comparison_table import Column, comparison_table
from app.panel.html import note

_NONE = "nothing pinned"


class CompareControls:
    """Added to the folder that is open."""

    def __init__(self, gui: viser.GuiApi) -> None:
        """Nothing is pinned."""
        gui.add_html('<div class="llsrbm-pair"></div>')
        self._empty = gui.add_html(
            note("Nothing pinned. Pin this design: it stays as a ghost beside the next ones.")
        )
        self.pin = gui.add_button(
            "Pin", disabled=True, hint="Keep this design as a ghost and compare others with it"
        )
        self._table = gui.add_html("", visible=False)
        self.choice = gui.add_dropdown("Pinned", (_NONE,), visible=False)
        self.take_up = gui.add_button(
            "Take up", visible=False, hint="Make the pinned design the current one"
        )
        self.unpin = gui.add_button("Unpin", visible=False)
        self._titles: tuple[str, ...] = ()

    @property
    def chosen(self) -> int:
        """Number of the pin that is chosen; -1 for none."""
        value: Any = self.choice.value
        return self._titles.index(value) if value in self._titles else -1

    def show(
        self, current: Column | None, pinned: Sequence[Column], chosen: int, *, full: bool
    ) -> None:
        """Figures of the current design and of what is pinned, and which pin is chosen."""
        there = len(pinned) > 0
        self._table.content = (
            comparison_table([*([current] if current else []), *pinned]) if there else ""
        )
        titles = tuple(f"{index}. {column.title}" for index, column in enumerate(pinned, start=1))
        if titles != self._titles:
            self._titles = titles
            self.choice.options = titles or (_NONE,)
        put(self.choice, titles[chosen] if 0 <= chosen < len(titles) else (titles or (_NONE,))[0])
        self._empty.visible = not there
        for handle in (self._table, self.choice, self.take_up, self.unpin):
            handle.visible = there
        self.pin.disabled = current is None or full
