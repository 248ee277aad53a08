"""What the server and the scripts in the page (app/static) say to each other.

The server calls functions of `window.llsrbm`; the page answers through a text field that nobody
sees. What it says is a visitor's word and checked here.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

import viser

from app.motion import colours
from app.motion.clip import Clip
from app.viser_link.designer_server import run_javascript, uuid_of
from llsrbm.motion.timeline import Timeline

_LONGEST = 1000  # characters of a message; the longest that the page sends has 80


@dataclass(frozen=True)
class PageReady:
    """The scripts run.

    Attributes:
        software: the browser has no graphics processor.
    """

    software: bool


@dataclass(frozen=True)
class PlayerMoved:
    """It was paused, started or moved, or has come to its end.

    Attributes:
        time: s.
        playing: whether it plays now.
    """

    time: float
    playing: bool


@dataclass(frozen=True)
class PaceChosen:
    """Speed and repetition were chosen in the page.

    Attributes:
        speed: seconds of motion a second.
        loop: start again at the end.
    """

    speed: float
    loop: bool


PageEvent = PageReady | PlayerMoved | PaceChosen


class PageLink:
    """One tab's."""

    def __init__(self, client: viser.ClientHandle, hear: Callable[[PageEvent], None]) -> None:
        """Ask the page whether its scripts run; it answers with `PageReady`.

        Args:
            client: the tab.
            hear: called from viser's thread, must return at once.
        """
        self._client = client
        self._field = client.gui.add_text("", "", visible=False)

        @self._field.on_update
        async def _(event: viser.GuiEvent[Any]) -> None:
            told = read_event(event.target.value) if event.client_id is not None else None
            if told is not None:
                hear(told)

        self._call("player.connect", json.dumps(uuid_of(self._field)))

    def load(self, clip: Clip, events: Timeline | None) -> None:
        """Play another clip from now on, and show what happens in it; None: nothing, it stands."""
        header, blob = clip.encoded
        self._call("player.load", header, json.dumps(blob))
        if events is None:
            self._call("transport.hide")
        else:
            self._call("transport.show", json.dumps(_plain(events)))

    def clear(self) -> None:
        """Nothing to play."""
        self._call("player.clear")
        self._call("transport.hide")

    def play(self) -> None:
        """Go on."""
        self._call("player.play")

    def pause(self) -> None:
        """Stop."""
        self._call("player.pause")

    def seek(self, time: float) -> None:
        """Go to an instant, s."""
        self._call("player.seek", repr(float(time)))

    def set_speed(self, speed: float) -> None:
        """Seconds of motion a second."""
        self._call("player.setSpeed", repr(float(speed)))

    def set_loop(self, loop: bool) -> None:
        """Whether to start again at the end."""
        self._call("player.setLoop", json.dumps(loop))

    def _call(self, function: str, *arguments: str) -> None:
        owner = function.split(".")[0]
        run_javascript(
            self._client,
            f"window.llsrbm?.{owner} && window.llsrbm.{function}({','.join(arguments)})",
        )


def read_event(message: object) -> PageEvent | None:
    """What a page says, or None for what it cannot have said."""
    if not isinstance(message, str) or len(message) > _LONGEST:
        return None
    try:
        told = json.loads(message, parse_int=float)
    except (ValueError, RecursionError):
        return None
    match told:
        case {"kind": "ready", "software": bool(software)}:
            return PageReady(software)
        case {"kind": "state", "time": float(time), "playing": bool(playing)}:
            return PlayerMoved(time, playing) if math.isfinite(time) else None
        case {"kind": "pace", "speed": float(speed), "loop": bool(loop)}:
            return PaceChosen(speed, loop) if math.isfinite(speed) else None
    return None


def _plain(events: Timeline) -> dict[str, Any]:
    """For JSON; colours as style sheets have them."""
    plain = asdict(events)
    for row in plain["rows"]:
        for piece in row["pieces"]:
            piece["colour"] = colours.css(piece["colour"])
    for mark in plain["marks"]:
        mark["colour"] = colours.css(mark["colour"])
    return plain
