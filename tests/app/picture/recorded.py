"""A tab's scene that draws nothing and notes down what it would send."""

import contextlib
from types import SimpleNamespace
from typing import Any

import numpy as np


class Node(SimpleNamespace):
    """What was made of a node, and every change of it afterwards."""

    def __init__(self, scene, kind, name, **made):
        super().__init__(kind=kind, name=name, visible=True, **made)
        object.__setattr__(self, "_scene", scene)

    def __setattr__(self, prop: str, value: Any) -> None:
        before = vars(self).get(prop)
        if not np.array_equal(before, value):
            self._scene.changes.append((self.name, prop))
        vars(self)[prop] = value

    def remove(self):
        inside = [name for name in self._scene.nodes if f"{name}/".startswith(f"{self.name}/")]
        for name in inside:
            del self._scene.nodes[name]

    def on_update(self, callback):
        vars(self)["callback"] = callback


class RecordedScene:
    """Attributes: nodes by name; made: how many of each name; changes: (name, property)."""

    def __init__(self):
        self.nodes: dict[str, Node] = {}
        self.made: list[str] = []
        self.sent = 0  # bytes of meshes
        self.changes: list[tuple[str, str]] = []

    def __getattr__(self, method):
        if not method.startswith("add_"):
            raise AttributeError(method)

        def add(name, *values, **options):
            self.made.append(name)
            self.sent += sum(len(value) for value in values if isinstance(value, bytes))
            options = {"values": values, **options}
            visible = options.pop("visible", True)
            node = self.nodes[name] = Node(self, method.removeprefix("add_"), name, **options)
            vars(node)["visible"] = visible
            vars(node).setdefault("glb_data", values[0] if values else None)
            return node

        return add

    def seen(self):
        """Names of the nodes that are visible, and whose parents are."""

        def shown(name):
            while name:
                if name in self.nodes and not self.nodes[name].visible:
                    return False
                name = name.rpartition("/")[0]
            return True

        return {name for name in self.nodes if shown(name)}


class RecordedClient:
    """A tab."""

    def __init__(self):
        self.scene = RecordedScene()

    def atomic(self):
        return contextlib.nullcontext()


def track_of(clip, node):
    """(time, track) of a node in a clip."""
    ((time, track),) = [
        (strand.time, track)
        for strand in clip.channels
        for track in strand.tracks
        if node in track.nodes
    ]
    return time, track


def names_in(clip):
    return {name for strand in clip.channels for track in strand.tracks for name in track.nodes}
