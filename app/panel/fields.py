"""Controls made from a table: a row a control, each for one number, choice or switch of a value.

The value is frozen: a jump, a scenario, what is viewed, what is plotted. A script may send anything
for a control, so it is checked where it is read.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import viser

from app.guard.validation import number, option, put
from app.panel.acts import Act, Put, callback
from app.viser_private import uuid_of
from llsrbm.errors import InputError

V = TypeVar("V")
Ends = tuple[float, float]

_NONE = "none"  # the only option of a menu that has none
_LOST = object()  # where a control stands that a browser has put where it cannot be


@dataclass(frozen=True, eq=False)
class Field(Generic[V]):
    """A control: a checkbox, or a menu if it has options, or for numbers if it has ends."""

    label: str  # label, hint: for people; labels are part of the contract
    hint: str
    # what the control shows of a value, in display units, unrounded; a menu, of one that has it
    get: Callable[[V], Any]
    put: Callable[[V, Any], V]  # the value with what the control shows
    # lowest and highest number, in display units; may depend on what `Fields` is about
    ends: Ends | Callable[[Any], Ends] | None = None
    step: float = 1.0  # of the number, in display units; it is shown in whole steps
    slider: bool = False  # a slider rather than a field for a number
    # of a menu; may depend on the value, and on what `Fields` is about. What a value has is offered
    # too, as long as it has it
    options: tuple[str, ...] | Callable[[V, Any], Sequence[str]] | None = None
    aliases: tuple[str, ...] = ()  # that a script may choose in a menu besides its options
    # whether a value has this number at all; else it is not read, and hidden
    there: Callable[[V], bool] = lambda _: True
    stays: bool = False  # it is seen all the same, and keeps what was entered
    disabled: Callable[[V], bool] = lambda _: False  # whether it cannot be changed

    def ends_for(self, about: Any) -> Ends:
        """Lowest and highest number."""
        assert self.ends is not None
        return self.ends(about) if callable(self.ends) else self.ends

    def options_for(self, value: V, about: Any) -> tuple[str, ...]:
        """A menu's options, and the one that the value has."""
        offered = self.options(value, about) if callable(self.options) else self.options or ()
        chosen = (self.get(value),) if self.there(value) else ()
        return tuple(dict.fromkeys((*offered, *chosen))) or (_NONE,)

    def shown(self, value: V) -> Any:
        """The value as the control shows it, numbers in whole steps."""
        shown = self.get(value)
        if self.ends is None:
            return shown
        return float(round(round(shown / self.step) * self.step, 6))


class Fields(Generic[V]):
    """The controls of a table, for the session's thread; its acts say that they were moved.

    A control is read only where it does not stand as it was read or shown last, and shown only
    then: neither does a control that nobody touched take back what has changed meanwhile, nor is
    one that a hand is moving put back to where it was a moment ago.
    """

    def __init__(self, gui: viser.GuiApi, value: V, about: Any, put: Put, act: Act) -> None:
        self._gui, self._value, self._about = gui, value, about
        self._moved = callback(put, act)
        self._handles: dict[Field[V], Any] = {}
        self._stands: dict[Field[V], Any] = {}  # as they were read or shown last
        self._shown: tuple[V, Any] | None = None  # None: something was moved since

    def add(self, *fields: Field[V]) -> None:
        """Add rows to the container that is open."""
        self._shown = None
        for field in fields:
            handle = self._handles[field] = self._made(field)
            self._stands[field] = handle.value
            handle.on_update(self._moved)

    @property
    def hints(self) -> dict[str, tuple[str, str]]:
        """Label and meaning of each control, by its uuid: static/tips.js shows it on both."""
        handles = self._handles.items()
        return {uuid_of(handle): (field.label, field.hint) for field, handle in handles}

    def handle(self, field: Field[V]) -> Any:
        """The control of a row."""
        return self._handles[field]

    def read(self, value: V, about: Any) -> tuple[V, list[str]]:
        """A value with what was moved since, and what had to be corrected in it.

        A number of `value` that nobody touched stays as it is, however it is rounded for show.
        """
        complaints: list[str] = []
        for field, handle in self._handles.items():
            stands = handle.value
            if not field.there(value) or _same(stands, self._stands[field]):
                continue
            self._shown, before = None, len(complaints)
            found = self._checked(field, handle, field.shown(value), about, complaints)
            try:
                value = field.put(value, found)
            except InputError as error:
                complaints.append(str(error))
            self._stands[field] = stands if len(complaints) == before else _LOST
        return value, complaints

    def show(self, value: V, about: Any) -> None:
        """Put the controls where a value has them; what it has not keeps its number, hidden."""
        if self._shown == (value, about):
            return
        self._shown = value, about
        for field, handle in self._handles.items():
            there = field.there(value)
            handle.visible = there or field.stays
            handle.disabled = field.disabled(value)
            if field.ends is not None:
                handle.min, handle.max = field.ends_for(about)
            if callable(field.options):
                options = field.options_for(value, about)
                if tuple(handle.options) != options:
                    handle.options = options  # and another value, where that is none of them
                    if self._stands[field] not in options:
                        self._stands[field] = options[0]
            stands = self._stands[field]
            shown = field.shown(value) if there else stands
            # One that was moved since it was read keeps what it was moved to: it is read next.
            moved = stands is not _LOST and not _same(handle.value, stands)
            if not moved and not _same(shown, stands):
                put(handle, shown)
                self._stands[field] = shown

    def _checked(
        self, field: Field[V], handle: Any, now: Any, about: Any, complaints: list[str]
    ) -> Any:
        if field.ends is not None:
            return number(field.label, handle.value, field.ends_for(about), complaints)
        if field.options is not None:
            if handle.value in field.aliases:
                return handle.value
            return option(field.label, handle.value, tuple(handle.options), now, complaints)
        return handle.value is True

    def _made(self, field: Field[V]) -> Any:
        gui, there = self._gui, field.there(self._value)
        plain: dict[str, Any] = {"disabled": field.disabled(self._value)}
        plain["visible"] = there or field.stays
        if field.options is not None:
            options = field.options_for(self._value, self._about)
            chosen = field.get(self._value) if there else options[0]
            return gui.add_dropdown(field.label, options, initial_value=chosen, **plain)
        shown = field.shown(self._value)
        if field.ends is not None:
            low, high = field.ends_for(self._about)
            if field.slider:
                return gui.add_slider(field.label, low, high, field.step, shown, **plain)
            return gui.add_number(field.label, shown, min=low, max=high, step=field.step, **plain)
        return gui.add_checkbox(field.label, shown, **plain)


def switch(gui: viser.GuiApi, label: str, hint: str, put: Put, act: Act) -> Fields[bool]:
    """A box for a value that is nothing but ticked or not, in the container that is open."""
    fields = Fields(gui, False, None, put, act)
    fields.add(Field(label, hint, get=lambda on: on, put=lambda _, on: on))
    return fields


def _same(one: Any, other: Any) -> bool:
    """Whether a control stands alike; a browser rounds numbers."""
    if isinstance(one, float) and isinstance(other, float):
        return math.isclose(one, other, abs_tol=1e-9)
    return bool(one == other)
