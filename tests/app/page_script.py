"""The part of the page's scripts (app/static) in a tab without a browser: take, decode, answer."""

import base64
import itertools
import json
import re

import numpy as np

_CALL = re.compile(r"window\.llsrbm\?\.(\w+) && window\.llsrbm\.([\w.]+)\((.*)\)", re.DOTALL)


def call(source):
    """(function, arguments) of a script that the server sent; no function in other scripts."""
    found = _CALL.fullmatch(source)
    if found is None:
        return None, []
    owner, function, arguments = found.groups()
    assert function.startswith(f"{owner}.")
    return function, json.loads(f"[{arguments}]")


def decoded(header, blob):
    """(channels, end) of an encoded clip; a channel is (time, {node: (position, wxyz, scale)})."""
    numbers = np.frombuffer(base64.b64decode(blob), "<f4")
    at = 0

    def take(frames, size):
        nonlocal at
        at += frames * size
        return numbers[at - frames * size : at].reshape(frames, size)

    channels = []
    for channel in header["channels"]:
        frames = channel["frames"]
        time, nodes = take(frames, 1)[:, 0], {}
        for track in channel["tracks"]:
            position = take(frames, 3)
            wxyz = take(frames, 4) if track["turns"] else None
            scale = take(frames, 3) if track["scales"] else None
            nodes |= dict.fromkeys(track["nodes"], (position, wxyz, scale))
        channels.append((time, nodes))
    assert at == len(numbers)
    return channels, header["end"]


class PageScript:
    """Answers for the scripts of a `RawTab`.

    Attributes: known: what it answers when it is greeted, besides what it keeps; None: nothing.
    """

    def __init__(self, tab, known):
        self._tab = tab
        self._count = itertools.count()
        self.known = known
        self.kept = None  # the design that the browser keeps

    def take(self, source):
        """Do what a page does by itself when it is sent a script."""
        function, arguments = call(source)
        if self.known is None:
            return
        if function == "page.connect":
            self.greet(arguments[0])
        elif function == "player.load":
            self.say(kind="clip", number=arguments[2])
        elif function == "page.keep":
            (self.kept,) = arguments

    def greet(self, field=None):
        event = {"kind": "ready", "software": True, "kept": self.kept, **(self.known or {})}
        self.say(field, **event)

    def calls(self, function):
        """Arguments of every call of a function so far."""
        told = [call(source) for source in list(self._tab.scripts)]
        return [arguments for name, arguments in told if name == function]

    def say(self, field=None, **event):
        if field is None:
            ((field,),) = self.calls("page.connect")
        value = json.dumps({**event, "count": next(self._count)})
        self._tab.send({"type": "GuiUpdateMessage", "uuid": field, "updates": {"value": value}})

    @property
    def end(self):
        """Of the clip that is loaded, s."""
        return self._clip()[1]

    @property
    def camera_target(self):
        """What the camera is to look at, of the clip that is loaded."""
        return self.calls("player.load")[-1][0]["camera_target"]

    @property
    def events(self):
        """The timeline that is shown."""
        return self.calls("transport.show")[-1][0]

    def at(self, node, time):
        """(position, wxyz, scale) of a node in the clip that is loaded, nearest to a time, s."""
        ((instants, tracks),) = [(t, nodes) for t, nodes in self._clip()[0] if node in nodes]
        frame = int(np.abs(instants - time).argmin())
        return tuple(None if v is None else v[frame] for v in tracks[node])

    def nodes(self):
        """Names of what moves."""
        return {name for _, tracks in self._clip()[0] for name in tracks}

    def _clip(self):
        header, blob, _ = self.calls("player.load")[-1]
        return decoded(header, blob)
