"""The controls for files: open, save, and what is exported in which formats."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, partial
from html import escape
from typing import Any

import viser
from viser import Icon

from app.panel.acts import Act, Buttons, Put, add_buttons
from app.panel.fields import Field, Fields
from app.panel.html import SMALL, note
from app.viser_private import take_upload, uuid_of
from llsrbm.formats import FORMATS, ORDERS, Options, availability, readable
from llsrbm.robots import Robot

SIMULATION, PLAN = "simulation", "plan"

_FASTEST, _FASTEST_FILM = 1000.0, 60.0  # frames/s; every one of a film is drawn
_LONGEST_PAD = 10.0  # s
_OPEN = "A design, a plan, a simulation or another tool's motion; or drop it on the page"


@dataclass(frozen=True)
class FileChoice:
    """The choices of exports and of reading files; part of a tab's state."""

    format: str = next(iter(FORMATS))  # its name
    also: tuple[str, ...] = ()  # names of further ones, which makes it a zip
    of: str = SIMULATION  # `SIMULATION`, if there is one, or `PLAN`
    fps: float = Options().fps  # frames/s
    pad: float = Options().pad  # s of standing before and after
    order: str = Options().order  # of bodies
    rate: float = 30.0  # frames/s of files that do not say their own
    simulated: bool = False  # there is a simulation to choose; `TabState.file_choice` says it
    rate_needed: bool = False  # a file came that does not say its rate
    robot: Robot | None = None  # of which; None: not known yet; `TabState.file_choice` says it

    def hindrance(self, name: str) -> str:
        """Why a format cannot be written here, or of the robot; "" if it can."""
        return _hindrance(name, self.robot)

    def title(self, name: str) -> str:
        """A format in menus: its name, and whether it cannot be written."""
        return f"{name} (not available)" if self.hindrance(name) else name

    def line(self, name: str) -> str:
        """A format in one sentence, which says why it cannot be written."""
        why = self.hindrance(name)
        return f"{FORMATS[name].title}{f'; {why}' if why else ''}"

    @property
    def formats(self) -> tuple[str, ...]:
        """All names, the one of the menu first."""
        return tuple(dict.fromkeys((self.format, *self.also)))

    @property
    def options(self) -> dict[str, Any]:
        """Options that differ from those of the formats, which each has by itself."""
        return {
            name: getattr(self, name)
            for name in ("fps", "pad", "order")
            if self.takes(name) and getattr(self, name) != getattr(self.own(name), name)
        }

    def takes(self, option: str) -> bool:
        """Whether one of the formats has this option."""
        return any(option in FORMATS[name].options for name in self.formats)

    def own(self, option: str) -> Options:
        """Options of the first format that takes this one."""
        takers = (FORMATS[name] for name in self.formats if option in FORMATS[name].options)
        return next((each.defaults for each in takers), Options())

    def with_own(self) -> FileChoice:
        """With the formats' own options, as when other formats were chosen."""
        return replace(
            self, **{name: getattr(self.own(name), name) for name in ("fps", "pad", "order")}
        )


def _field(label: str, name: str, hint: str, **how: Any) -> Field[FileChoice]:
    return Field(
        label,
        hint,
        get=lambda choice: getattr(choice, name),
        put=lambda choice, shown: replace(choice, **{name: shown}),
        **how,
    )


@cache
def _hindrance(name: str, robot: Robot | None) -> str:
    return availability(FORMATS[name], robot)


def _is_hindered(name: str, choice: FileChoice) -> bool:
    return bool(choice.hindrance(name))


def _is_also(name: str, choice: FileChoice) -> bool:
    return name in choice.also


def _with_also(name: str, choice: FileChoice, on: bool) -> FileChoice:
    wanted = {*choice.also, name} if on else {*choice.also} - {name}
    return replace(choice, also=tuple(each for each in FORMATS if each in wanted))


FORMAT: Field[FileChoice] = Field(
    "Format",
    "The file that Export writes; Export… says what each is for",
    get=lambda choice: choice.title(choice.format),
    put=lambda choice, title: replace(choice, format=title.partition(" ")[0]),
    options=lambda choice, _: [choice.title(name) for name in FORMATS],
    aliases=tuple(FORMATS),
)
RATE = _field(
    "Rate of the file [1/s]",
    "rate",
    "Frame rate of the next opened file that does not state its own",
    ends=(1.0, _FASTEST),
    there=lambda choice: choice.rate_needed,
)
OPTIONS = (
    _field(
        "Trajectory",
        "of",
        "Motion that is written: of the simulation, or of the plan that it followed",
        options=(SIMULATION, PLAN),
        there=lambda choice: choice.simulated,
    ),
    _field(
        "Frames per second",
        "fps",
        "Instants of the motion that the file has each second",
        ends=lambda choice: (1.0, _FASTEST_FILM if choice.takes("size") else _FASTEST),
        there=lambda choice: choice.takes("fps"),
    ),
    _field(
        "Padding before and after [s]",
        "pad",
        "Time for which the robot stands before and after the motion",
        ends=(0.0, _LONGEST_PAD),
        step=0.1,
        there=lambda choice: choice.takes("pad"),
    ),
    _field(
        "Order of bodies",
        "order",
        "Order in which the file names the robot's bodies",
        options=ORDERS,
        there=lambda choice: choice.takes("order"),
    ),
)
ALSO = tuple(
    Field(
        name,
        each.title,
        get=partial(_is_also, name),
        put=partial(_with_also, name),
        disabled=partial(_is_hindered, name),
    )
    for name, each in FORMATS.items()
)


class FileControls:
    """Above: open; further down, where asked for, notes, format and export, and the rest."""

    def __init__(
        self,
        client: viser.ClientHandle,  # whose tab
        put_act: Put,  # called with acts
        open_file: Callable[[str, bytes], None],  # called with a name and content, whatever it is
    ) -> None:
        """The callbacks are called on viser's event loop and must return at once."""
        gui = self._gui = client.gui
        self._put = put_act
        # the button that opens a file
        self.open = gui.add_upload_button(
            "Open",
            mime_type=",".join(_suffixes()),
            icon=Icon.FOLDER_OPEN,
        )
        self.fields = Fields(gui, FileChoice(), FileChoice(), put_act, Act.FILES)  # of `FileChoice`
        self.buttons: Buttons = {}  # so far

        # Asynchronous, so that it runs on the event loop, in order.
        @self.open.on_upload
        async def _(event: viser.GuiEvent[Any]) -> None:
            file = take_upload(event.target)
            if file is not None:
                open_file(file.name, file.content)

    @property
    def hints(self) -> dict[str, tuple[str, str]]:
        """As `Fields.hints`."""
        return {**self.fields.hints, uuid_of(self.open): ("Open", _OPEN)}

    @property
    def format(self) -> Any:
        """The menu of formats."""
        return self.fields.handle(FORMAT)

    def add_export(self) -> None:
        """Add what shows all formats, the format and the button that writes it, in the open
        container.
        """
        self.buttons |= add_buttons(self._gui, "choose export", self._put)
        self.fields.add(FORMAT)
        self.buttons |= add_buttons(self._gui, "export", self._put)

    def add_progress(self) -> None:
        """Add what is being read or written, and a note on what was, in the open container."""
        self._busy = self._gui.add_html("", visible=False)
        self.buttons |= add_buttons(self._gui, "stop", self._put)
        self._note = self._gui.add_html("", visible=False)

    def add_tab(self) -> None:
        """Add the design's file and how motions are written, in the open container."""
        gui = self._gui
        self.fields.add(RATE)
        self.buttons |= add_buttons(gui, "files", self._put)
        self.fields.add(OPTIONS[0])
        self._line = gui.add_html("")
        self.fields.add(*OPTIONS[1:])
        with gui.add_folder("Several in one zip", expand_by_default=False):
            self.fields.add(*ALSO)

    def show(self, text: str, choice: FileChoice, busy: str) -> None:
        """A text on the design, or on a file; the options of an export; and the file that is being
        read or written, "" for none.
        """
        self.fields.show(choice, choice)
        self._note.content = note(text)
        self._note.visible = bool(text)
        self._line.content = f'<div style="{SMALL}">{escape(choice.line(choice.format))}</div>'
        self._busy.content = f'<div role="alert" style="{SMALL}">{escape(busy)}</div>'
        self._busy.visible = bool(busy)


def _suffixes() -> list[str]:
    motions = {each.suffix for each in readable() if each.suffix}
    return sorted({".json", ".zip"} | motions)
