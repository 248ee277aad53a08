"""The controls that keep designs beside the current one, and the table of their figures."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import viser

from app.panel.comparison import Column, comparison_table
from app.panel.validation import put

_NONE = "nothing pinned"


class CompareControls:
    """Added to the folder that is open."""

    def __init__(self, gui: viser.GuiApi) -> None:
        """Nothing is pinned."""
        self.pin = gui.add_button(
            "Pin", disabled=True, hint="Keep this design as a ghost and compare others with it"
        )
        self._table = gui.add_html("", visible=False)
        self._choice = gui.add_dropdown("Pinned", (_NONE,), visible=False)
        self.take_up = gui.add_button(
            "Take up", visible=False, hint="Make the pinned design the current one"
        )
        self.unpin = gui.add_button("Unpin", visible=False)
        self._titles: tuple[str, ...] = ()

    @property
    def chosen(self) -> int:
        """Number of the pin that is chosen; -1 for none."""
        value: Any = self._choice.value
        return self._titles.index(value) if value in self._titles else -1

    def show(self, current: Column | None, pinned: Sequence[Column], *, full: bool) -> None:
        """Figures of the current design and of what is pinned."""
        there = len(pinned) > 0
        self._table.content = (
            comparison_table([*([current] if current else []), *pinned]) if there else ""
        )
        titles = tuple(f"{index}. {column.title}" for index, column in enumerate(pinned, start=1))
        if titles != self._titles:
            self._titles = titles
            self._choice.options = titles or (_NONE,)
            put(self._choice, titles[-1] if titles else _NONE)
        for handle in (self._table, self._choice, self.take_up, self.unpin):
            handle.visible = there
        self.pin.disabled = current is None or full
