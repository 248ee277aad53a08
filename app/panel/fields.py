"""Controls made from a table: a row a control, each for one number or switch of a value.

The value is a frozen dataclass: a jump, a scenario, what is viewed, what is exported. A script may
send anything for a control, so it is checked where it is read.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import viser

from app.guard.validation import number, option, put
from app.panel.acts import Act, Put, callback
from llsrbm.errors import InputError

V = TypeVar("V")
Ends = tuple[float, float]


def _always(_: Any) -> bool:
    return True


@dataclass(frozen=True, eq=False)
class Field(Generic[V]):
    """A control: a checkbox, or a menu if it has options, or for numbers if it has ends."""

    label: str  # label, hint: for people; labels are part of the contract
    hint: str | None
    get: Callable[[V], Any]  # what the control shows of any value, in display units, unrounded
    put: Callable[[V, Any], V]  # the value with what the control shows
    # lowest and highest number, in display units; may depend on what `Fields` is about
    ends: Ends | Callable[[Any], Ends] | None = None
    step: float = 1.0  # of the number, in display units; it is shown in whole steps
    slider: bool = False  # a slider rather than a field for a number
    options: tuple[str, ...] = ()  # of a menu
    # whether a value has this number at all; else it is not read, and hidden
    there: Callable[[V], bool] = _always
    stays: bool = False  # it is seen all the same, and keeps what was entered
    disabled: bool = False  # it cannot be changed

    def ends_for(self, about: Any) -> Ends:
        """Lowest and highest number."""
        assert self.ends is not None
        return self.ends(about) if callable(self.ends) else self.ends

    def shown(self, value: V) -> Any:
        """The value as the control shows it, numbers in whole steps."""
        shown = self.get(value)
        if self.ends is None:
            return shown
        return float(round(round(shown / self.step) * self.step, 6))


class Fields(Generic[V]):
    """The controls of a table, for the session's thread; its acts say that they were moved."""

    def __init__(self, gui: viser.GuiApi, value: V, about: Any, put: Put, act: Act) -> None:
        self._gui, self._value, self._about = gui, value, about
        self._moved = callback(put, act)
        self._handles: dict[Field[V], Any] = {}

    def add(self, fields: Sequence[Field[V]]) -> None:
        """Add rows to the container that is open."""
        for field in fields:
            handle = self._made(field)
            handle.on_update(self._moved)
            self._handles[field] = handle

    def handle(self, field: Field[V]) -> Any:
        """The control of a row."""
        return self._handles[field]

    def read(self, value: V, about: Any) -> tuple[V, list[str]]:
        """A value as the controls stand, and what had to be corrected in it.

        A number of `value` that nobody touched stays as it is, however it is rounded for show.
        """
        complaints: list[str] = []
        for field, handle in self._handles.items():
            if not field.there(value):
                continue
            now = field.shown(value)
            found = self._found(field, handle.value, now, about, complaints)
            touched = (
                found != now if field.ends is None else not math.isclose(found, now, abs_tol=1e-9)
            )
            if touched:
                try:
                    value = field.put(value, found)
                except InputError as error:
                    complaints.append(str(error))
        return value, complaints

    def show(self, value: V, about: Any) -> None:
        """Put the controls where a value has them; what it has not keeps its number, hidden."""
        for field, handle in self._handles.items():
            there = field.there(value)
            handle.visible = there or field.stays
            if field.ends is not None:
                handle.min, handle.max = field.ends_for(about)
            if there:
                put(handle, field.shown(value))

    def show_there(self, value: V) -> None:
        """Show and hide controls, and leave their numbers."""
        for field, handle in self._handles.items():
            handle.visible = field.there(value) or field.stays

    def _found(
        self, field: Field[V], shown: Any, now: Any, about: Any, complaints: list[str]
    ) -> Any:
        if field.ends is not None:
            return number(field.label, shown, field.ends_for(about), complaints)
        if field.options:
            return option(field.label, shown, field.options, now, complaints)
        return shown is True

    def _made(self, field: Field[V]) -> Any:
        gui, shown = self._gui, field.shown(self._value)
        plain: dict[str, Any] = {"hint": field.hint, "disabled": field.disabled}
        plain["visible"] = field.there(self._value) or field.stays
        if field.ends is not None:
            low, high = field.ends_for(self._about)
            if field.slider:
                return gui.add_slider(field.label, low, high, field.step, shown, **plain)
            return gui.add_number(field.label, shown, min=low, max=high, step=field.step, **plain)
        if field.options:
            return gui.add_dropdown(field.label, field.options, initial_value=shown, **plain)
        return gui.add_checkbox(field.label, shown, **plain)
