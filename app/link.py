"""The link between a tab's session and the scripts in its page (app/static).

The session calls functions of `window.llsrbm`; the page answers through a hidden text field, in
JSON with the kind of each event. A visitor may send anything there: what fits no kind is ignored.
"""

import json
import threading
from collections.abc import Callable, Mapping
from typing import Annotated, Any, Literal, TypeVar, dataclass_transform

import viser
from pydantic import AfterValidator, ConfigDict, Field, TypeAdapter
from pydantic.dataclasses import dataclass
from pydantic_core import from_json

from app.guard.limits import LONGEST_TEXT
from app.motion.clip import Clip
from app.viser_private import run_javascript, uuid_of
from llsrbm.look.timeline import Timeline

_OVERDUE = 3.0  # s after which a clip that the page has not acknowledged counts as lost
_FROM_PAGE = ConfigDict(strict=True, allow_inf_nan=False)

Time = Annotated[float, Field(ge=0)]  # s
Number = Annotated[int, Field(ge=0, lt=2**53)]
Name = Annotated[str, Field(max_length=100)]
Title = Annotated[str, Field(max_length=1000)]  # of a chart, or of a sweep with its folder
Text = Annotated[str | None, AfterValidator(lambda text: text or None)]

EVENTS: dict[str, TypeAdapter[Any]] = {}
"""The events below by the kind that their messages have."""

Event = TypeVar("Event")


@dataclass_transform(frozen_default=True)
def _event(kind: str) -> Callable[[type[Event]], type[Event]]:
    """Have the event of a class be read from messages of that kind."""

    def register(described: type[Event]) -> type[Event]:
        event: Any = dataclass(frozen=True, config=_FROM_PAGE)(described)
        EVENTS[kind] = TypeAdapter(event)
        return event

    return register


@_event("ready")
class PageReady:
    """The scripts run."""

    software: bool  # the browser has no graphics processor
    # fields of viser's that they need and do not find
    missing: Annotated[tuple[Name, ...], Field(max_length=20)] = ()
    # by which the page is known again when it comes back
    tab: Annotated[str, Field(pattern=r"^[0-9a-f]{32}$")] | None = None
    # shared, kept: the design in the address, and the one in the browser's storage, as text
    shared: Text = None
    kept: Text = None
    # time, playing: s, of the motion of a page that has lost its server and comes to another one
    time: Time = 0.0
    playing: bool = False
    preferences: Text = None  # that the browser kept
    dark: bool = False  # the system is
    height: float | None = None  # of the window, pixels; None: not known


@_event("scheme")
class SchemeChanged:
    """The system has turned dark, or light."""

    dark: bool


@_event("state")
class PlayerMoved:
    """The motion was paused, started or moved to `time`, or has come to its end."""

    time: Time
    playing: bool


@_event("playback")
class PlaybackChosen:
    """Speed (seconds of motion a second) and repetition were chosen in the page."""

    speed: Annotated[float, Field(gt=0, le=1)]
    loop: bool


@_event("clip")
class ClipTaken:
    """The page has the clip of this number, and can be sent the next one."""

    number: Number


@_event("tuning")
class TuningChosen:
    """A weight or limit was changed, if there is one of that name; None: the robot's own again."""

    group: Literal["weights", "limits"]
    name: Name
    value: float | None


@_event("atlas-seen")
class AtlasSeen:
    """The page shows the place of the atlas, and has no map yet."""


@_event("atlas")
class AtlasClicked:
    """A jump of the atlas was chosen; there may be no such sweep, and no such jump in it."""

    sweep: Title
    jump: Number


@_event("pin")
class PinPressed:
    """A pin's chip was pressed, by its number; there may be no such pin."""

    act: Literal["use", "unpin"]
    index: Number


@_event("cards")
class CardsAsked:
    """The page wants the examples' cards, of which its welcome shows the first."""


@_event("example")
class ExampleChosen:
    """An example was chosen, if there is one of that name."""

    name: Name


@_event("motion")
class MotionChosen:
    """A motion of the library was chosen, if there is one of that name."""

    name: Name


@_event("figures")
class FiguresWanted:
    """Motions of the library have come into view, and their stick figures are to be seen."""

    names: Annotated[tuple[Name, ...], Field(max_length=500)]


@_event("export")
class ExportChosen:
    """A format was chosen to be written, if there is one of that name."""

    format: Name


@_event("comparison-closed")
class ComparisonClosed:
    """The comparison was closed, done or not."""


@_event("repair")
class RepairAsked:
    """The motion of a file that is open shall be repaired; there may be none."""


@_event("certificate")
class CertificateAsked:
    """The verdict was pressed."""


@_event("beside")
class BesideChosen:
    """Whether pinned robots stand beside the one that is shown."""

    on: bool


@_event("chart")
class ChartDropped:
    """A chart was dropped onto another one, by their titles; None: the one that is on offer."""

    chart: Title | None
    onto: Title


@_event("part")
class PartAsked:
    """A part of the robot is pointed at, if there is one of that name."""

    part: Name


@_event("plot")
class PartPlotted:
    """A row of a part's figures was chosen for the plots; there may be no such row."""

    part: Name
    row: Number


@_event("push")
class PushDragged:
    """A push was drawn in the picture, from the trunk to a hand."""

    time: Time  # the instant that was shown
    x: float  # x, y: m from the trunk's CoM to the hand, world frame
    y: float
    ended: bool  # whether it was let go of


@_event("phases")
class PhasesDragged:
    """An edge of the timeline was put elsewhere."""

    # s, of the first phases, up to the one that begins there; none: they are free again
    durations: Annotated[tuple[Time, ...], Field(max_length=20)]
    begins: bool  # whether with it another edge, or the same one anew, is moved


@_event("apex")
class ApexDragged:
    """The apex in the timeline was put higher or lower."""

    height: float | None  # m, of the CoM above the ground at the start; None: it is free again
    begins: bool  # whether with it something else than before is moved


def read_event(message: object) -> Any:
    """The event in a message of a page, or None if no page can have sent it."""
    if not isinstance(message, str) or len(message) > LONGEST_TEXT:
        return None
    try:
        return EVENTS[from_json(message)["kind"]].validate_json(message)
    except (ValueError, TypeError, LookupError):
        return None


class PageLink:
    """Calls a tab's scripts, in the session's thread; a slow page gets the newest clip only."""

    def __init__(self, client: viser.ClientHandle, callback: Callable[[Any], None]) -> None:
        """Greet the page, which answers with `PageReady`; `callback` is called in other threads."""
        self._client, self._callback = client, callback
        self._field = client.gui.add_text("", "", visible=False)
        self._number = 0  # of the clip that was sent last
        self._taken = 0  # of the clip that the page took last
        self._waiting: tuple[Clip, Timeline | None] | None = None
        self._commands: list[tuple[Any, ...]] = []  # that are about the waiting clip

        @self._field.on_update
        async def _(event: viser.GuiEvent[Any]) -> None:
            found = read_event(event.target.value) if event.client_id is not None else None
            if found is not None:
                callback(found)

        self.call("page.connect", uuid_of(self._field))

    def call(self, function: str, *arguments: Any) -> None:
        """Call a function of the scripts, "player.seek", with values that JSON can hold.

        The player's are called when it has the clip that was loaded last.
        """
        owner = function.split(".")[0]
        if owner == "player" and self._waiting is not None:
            self._commands.append((function, *arguments))
            return
        values = ",".join(json.dumps(value, default=_plain) for value in arguments)
        run_javascript(
            self._client, f"window.llsrbm?.{owner} && window.llsrbm.{function}({values})"
        )

    def load(self, clip: Clip, events: Timeline | None) -> None:
        """Play another clip from now on, with its timeline (None: it stands); time goes on."""
        if self._number > self._taken:
            if self._waiting is None:
                lost = ClipTaken(self._number)  # unless the page says so itself
                overdue = threading.Timer(_OVERDUE, self._callback, [lost])
                overdue.daemon = True
                overdue.start()
            self._waiting = clip, events
        else:
            self._send(clip, events)

    def take(self, event: ClipTaken) -> None:
        """The page has a clip: send the newest one, if there has been another since."""
        self._taken = max(self._taken, min(event.number, self._number))
        if self._waiting is not None and self._taken == self._number:
            waiting, self._waiting = self._waiting, None
            self._send(*waiting)
            commands, self._commands = self._commands, []
            for command in commands:
                self.call(*command)

    def _send(self, clip: Clip, events: Timeline | None) -> None:
        self._number += 1
        header, blob = clip.encoded
        if events is None:
            self.call("transport.clear")
        else:
            self.call("transport.show", events.plain())
        self.call("player.load", header, blob, self._number)


def _plain(value: Any) -> Any:
    return dict(value) if isinstance(value, Mapping) else vars(value)
