"""The link between a tab's session and the scripts in its page (app/static).

The session calls functions of `window.llsrbm`; the page answers through a hidden text field. A
visitor may send anything there, so answers are checked here.
"""

from __future__ import annotations

import json
import math
import re
import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import viser

from app.guard.limits import LONGEST_TEXT
from app.motion.clip import Clip
from app.viser_private import run_javascript, uuid_of
from llsrbm.look.palette import Rgb, css
from llsrbm.look.timeline import Timeline
from llsrbm.request.tuning import Tuning

_MOST_MISSING, _LONGEST_NAME = 20, 100
_LONGEST_TITLE = 1000  # characters of a sweep's name: its title, and its folder
_TOKEN = re.compile(r"[0-9a-f]{32}")
_OVERDUE = 3.0  # s after which a clip that the page has not acknowledged counts as lost


@dataclass(frozen=True)
class PageReady:
    """The scripts run."""

    software: bool  # the browser has no graphics processor
    missing: tuple[str, ...] = ()  # fields of viser's that they need and do not find
    tab: str | None = None  # by which the page is known again when it comes back
    # shared, kept: the design in the address, and the one in the browser's storage, as text
    shared: str | None = None
    kept: str | None = None
    # time, playing: s, of the motion of a page that has lost its server and comes to another one
    time: float = 0.0
    playing: bool = False
    preferences: str | None = None  # that the browser kept, as text
    dark: bool = False  # the system is
    height: float | None = None  # of the window, pixels; None: not known


@dataclass(frozen=True)
class SchemeChanged:
    """The system has turned dark, or light."""

    dark: bool


@dataclass(frozen=True)
class PlayerMoved:
    """The motion was paused, started or moved to `time` (s), or has come to its end."""

    time: float
    playing: bool


@dataclass(frozen=True)
class PlaybackChosen:
    """Speed (seconds of motion a second) and repetition were chosen in the page."""

    speed: float
    loop: bool


@dataclass(frozen=True)
class ClipTaken:
    """The page has the clip of this number, and can be sent the next one."""

    number: int


@dataclass(frozen=True)
class TuningChosen:
    """A weight or limit was changed, if there is one of that name; None: the robot's own again."""

    group: Literal["weights", "limits"]
    name: str
    value: float | None


@dataclass(frozen=True)
class AtlasSeen:
    """The page shows the place of the atlas, and has no map yet."""


@dataclass(frozen=True)
class AtlasClicked:
    """A jump of the atlas was chosen; there may be no such sweep, and no such jump in it."""

    sweep: str
    number: int


@dataclass(frozen=True)
class PinPressed:
    """A pin's chip was pressed, by its number; there may be no such pin."""

    act: Literal["use", "unpin"]
    index: int


@dataclass(frozen=True)
class CertificateAsked:
    """The verdict was pressed."""


@dataclass(frozen=True)
class BesideChosen:
    """Whether pinned robots stand beside the one that is shown."""

    on: bool


@dataclass(frozen=True)
class ChartDropped:
    """A chart was dropped onto another one, by their titles; None: the one that is on offer."""

    chart: str | None
    onto: str


@dataclass(frozen=True)
class PartAsked:
    """A part of the robot is pointed at, if there is one of that name."""

    part: str


@dataclass(frozen=True)
class PartPlotted:
    """A row of a part's figures was chosen for the plots; there may be no such row."""

    part: str
    row: int


@dataclass(frozen=True)
class PushDragged:
    """A push was drawn in the picture, from the trunk to a hand."""

    time: float  # s, the instant that was shown
    x: float  # x, y: m from the trunk's CoM to the hand, world frame
    y: float
    ended: bool  # whether it was let go of


PageEvent = (
    PageReady
    | SchemeChanged
    | PlayerMoved
    | PlaybackChosen
    | ClipTaken
    | TuningChosen
    | AtlasSeen
    | AtlasClicked
    | PinPressed
    | CertificateAsked
    | BesideChosen
    | ChartDropped
    | PartAsked
    | PartPlotted
    | PushDragged
)


class PageLink:
    """Calls a tab's scripts, in the session's thread; a slow page gets the newest clip only."""

    def __init__(self, client: viser.ClientHandle, callback: Callable[[PageEvent], None]) -> None:
        """Greet the page, which answers with `PageReady`; `callback` is called in other threads."""
        self._client, self._callback = client, callback
        self._field = client.gui.add_text("", "", visible=False)
        self._number = 0  # of the clip that was sent last
        self._taken = 0  # of the clip that the page took last
        self._waiting: tuple[Clip, Timeline | None] | None = None
        self._commands: list[tuple[str, ...]] = []  # that are about the waiting clip

        @self._field.on_update
        async def _(event: viser.GuiEvent[Any]) -> None:
            found = read_event(event.target.value) if event.client_id is not None else None
            if found is not None:
                callback(found)

        self._call("page.connect", json.dumps(uuid_of(self._field)))

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
                self._call(*command)

    def play(self) -> None:
        """Go on, from the start if at the end."""
        self._command("player.play")

    def pause(self) -> None:
        """Pause."""
        self._command("player.pause")

    def settle(self) -> None:
        """Draw nodes that have just come as the player has them."""
        self._command("player.settle")

    def seek(self, time: float) -> None:
        """Go to an instant, s."""
        self._command("player.seek", repr(float(time)))

    def set_playback(self, speed: float, loop: bool) -> None:
        """Play so many seconds of motion a second, and start again at the end or not."""
        self._command("player.setSpeed", repr(float(speed)))
        self._command("player.setLoop", json.dumps(loop))

    def keep(self, design: str) -> None:
        """Store a design, as text, in the browser."""
        self._call("page.keep", json.dumps(design))

    def prefer(self, preferences: str) -> None:
        """Store preferences, as text, in the browser."""
        self._call("page.prefer", json.dumps(preferences))

    def show_tuning(self, tuning: Tuning) -> None:
        """Show a design's numbers in the table of weights and limits."""
        changed = {"weights": dict(tuning.weights), "limits": dict(tuning.limits)}
        self._call("tuning.show", json.dumps(changed))

    def show_pins(self, chips: Sequence[tuple[str, Rgb]], beside: bool) -> None:
        """Show names and colours of what is compared; the first is the design that is shown."""
        named = [{"title": title, "colour": css(colour)} for title, colour in chips]
        self._call("pins.show", json.dumps(named), json.dumps(beside))

    def show_atlas(self, sent: Mapping[str, Any] | None) -> None:
        """Draw a map of the atlas made by `app.panel.atlas_controls`; None: remove it."""
        self._call("atlas.show", json.dumps(sent))

    def move_in_atlas(self, x: float, y: float) -> None:
        """Mark the present design in the map, in the units of its axes."""
        self._call("atlas.mark", repr(float(x)), repr(float(y)))

    def tint(self, tracks: Mapping[str, Any]) -> None:
        """Tint the tracks of sliders, by their uuids, as `app.tab.planning.feasible` says."""
        self._call("tint.show", json.dumps(tracks))

    def show_part(self, reading: Mapping[str, Any]) -> None:
        """Show what a part of the robot does beside it."""
        self._call("parts.show", json.dumps(reading))

    def paint_handle(self, node: str, colour: Rgb) -> None:
        """Give a handle of viser's, by its node, a colour."""
        self._call("handles.paint", json.dumps(node), json.dumps(colour))

    def arrange(self, controls: dict[str, str | list[str]]) -> None:
        """Arrange controls, by their uuids, as the panel's rows of buttons (static/panel.js)."""
        self._call("panel.arrange", json.dumps(controls))

    def show_swatches(self, colours: dict[str, list[str]]) -> None:
        """Show colours (CSS) beside boxes, by their uuids; a box without one is grey."""
        self._call("panel.swatches", json.dumps(colours))

    def set_shortcuts(self, on: bool) -> None:
        """Take the page's keys, beside those of its controls, or leave them alone."""
        self._call("panel.setShortcuts", json.dumps(on))

    def remark(self, text: str) -> None:
        """Say something about the motion that is shown, over the picture; "": nothing."""
        self._call("remark.show", json.dumps(text))

    def share(self, design: str) -> None:
        """Show a link that opens a design, given as text; it is made in the page."""
        self._call("page.share", json.dumps(design))

    def _send(self, clip: Clip, events: Timeline | None) -> None:
        self._number += 1
        header, blob = clip.encoded
        if events is None:
            self._call("transport.clear")
        else:
            self._call("transport.show", json.dumps(events.plain()))
        self._call("player.load", header, json.dumps(blob), str(self._number))

    def _command(self, function: str, *arguments: str) -> None:
        """Call a function of the player, when it has the clip that was loaded last."""
        if self._waiting is None:
            self._call(function, *arguments)
        else:
            self._commands.append((function, *arguments))

    def _call(self, function: str, *arguments: str) -> None:
        owner = function.split(".")[0]
        run_javascript(
            self._client,
            f"window.llsrbm?.{owner} && window.llsrbm.{function}({','.join(arguments)})",
        )


def read_event(message: object) -> PageEvent | None:
    """The event in a message of a page, or None if no page can have sent it."""
    if not isinstance(message, str) or len(message) > LONGEST_TEXT:
        return None
    try:
        found = json.loads(message, parse_int=float)
    except (ValueError, RecursionError):
        return None
    match found:
        case {"kind": "ready", "software": bool(software)}:
            return _ready(software, found)
        case {"kind": "scheme", "dark": bool(dark)}:
            return SchemeChanged(dark)
        case {"kind": "state", "time": float(time), "playing": bool(playing)}:
            return PlayerMoved(time, playing) if _is_time(time) else None
        case {"kind": "playback", "speed": float(speed), "loop": bool(loop)}:
            return PlaybackChosen(speed, loop) if 0 < speed <= 1 else None
        case {"kind": "clip", "number": float(number)}:
            return ClipTaken(int(number)) if 0 <= number < 2**53 else None
        case {
            "kind": "tuning",
            "group": "weights" | "limits" as group,
            "name": str(name),
            "value": float() | None as value,
        }:
            usable = len(name) <= _LONGEST_NAME and (value is None or math.isfinite(value))
            return TuningChosen(group, name, value) if usable else None
        case {"kind": "pin", "act": "use" | "unpin" as act, "index": float(index)}:
            return PinPressed(act, int(index)) if 0 <= index < 2**53 else None
        case {"kind": "certificate"}:
            return CertificateAsked()
        case {"kind": "beside", "on": bool(on)}:
            return BesideChosen(on)
        case {"kind": "chart", "chart": str() | None as chart, "onto": str(onto)}:
            usable = max(len(chart or ""), len(onto)) <= _LONGEST_TITLE
            return ChartDropped(chart, onto) if usable else None
        case {"kind": "atlas-seen"}:
            return AtlasSeen()
        case {"kind": "atlas", "sweep": str(name), "jump": float(number)}:
            usable = len(name) <= _LONGEST_TITLE and 0 <= number < 2**53
            return AtlasClicked(name, int(number)) if usable else None
        case {"kind": "part", "part": str(name)} if len(name) <= _LONGEST_NAME:
            return PartAsked(name)
        case {"kind": "plot", "part": str(name), "row": float(row)}:
            usable = len(name) <= _LONGEST_NAME and 0 <= row < 2**53
            return PartPlotted(name, int(row)) if usable else None
        case {
            "kind": "push",
            "time": float(time),
            "x": float(x),
            "y": float(y),
            "ended": bool(ended),
        }:
            usable = _is_time(time) and math.isfinite(x) and math.isfinite(y)
            return PushDragged(time, x, y, ended) if usable else None
    return None


def _ready(software: bool, found: dict[str, Any]) -> PageReady:
    missing = found.get("missing")
    names = missing if isinstance(missing, list) else []
    tab, time, height = found.get("tab"), found.get("time"), found.get("height")
    return PageReady(
        software,
        tuple(str(name)[:_LONGEST_NAME] for name in names[:_MOST_MISSING]),
        tab if isinstance(tab, str) and _TOKEN.fullmatch(tab) else None,
        _text(found.get("shared")),
        _text(found.get("kept")),
        time if isinstance(time, float) and _is_time(time) else 0.0,
        found.get("playing") is True,
        _text(found.get("preferences")),
        found.get("dark") is True,
        height if isinstance(height, float) and math.isfinite(height) else None,
    )


def _is_time(time: float) -> bool:
    return math.isfinite(time) and time >= 0


def _text(value: object) -> str | None:
    return value if isinstance(value, str) and value else None
