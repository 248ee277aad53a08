"""One thing in the picture: what it is drawn from, and how it moves."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import ClassVar

import viser

from app.motion.clip import Strand, Track
from app.motion.frames import Frames
from app.picture.picture import Picture


class Drawing(ABC):
    """Draws some parts of a picture; its nodes are made when they are drawn first.

    Making a node costs a browser far more than moving it (new buffers, perhaps a new shader), so
    nodes stay, and are only changed, moved and hidden.

    Attributes:
        parts: the fields of `Picture` that it is drawn from; while these stay it is left alone.
        needs_motion: whether there is nothing to draw of a robot that only stands there.
    """

    parts: ClassVar[frozenset[str]] = frozenset({"robot", "planned", "simulated"})
    needs_motion: ClassVar[bool] = True

    def __init__(self, scene: viser.SceneApi) -> None:
        """Nothing is drawn.

        Args:
            scene: a tab's.
        """
        self.scene = scene

    @abstractmethod
    def draw(self, picture: Picture) -> Sequence[Strand]:
        """Take along what does not move; returns how the rest moves.

        Args:
            picture: with a motion, if `needs_motion`.
        """

    @abstractmethod
    def show(self, *, visible: bool) -> None:
        """Show or hide everything; may be called before anything is drawn."""


class Overlay(Drawing):
    """Drawn besides the robot if its box is ticked.

    Attributes:
        name: in `Picture.layers`.
        title: label of its box.
        hint: its meaning in one sentence.
        at_first: whether its box is ticked when a page opens.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    hint: ClassVar[str]
    at_first: ClassVar[bool] = False


class RootedOverlay(Overlay):
    """An overlay whose nodes hang below one node, and move with the robot that is drawn solid.

    Attributes:
        root: name of that node. viser labels nodes by their names, and tests find controls by
            label: it differs from `title`.
    """

    root: ClassVar[str]

    def __init__(self, scene: viser.SceneApi) -> None:
        """See `Drawing`."""
        super().__init__(scene)
        self._root: viser.FrameHandle | None = None

    def draw(self, picture: Picture) -> Sequence[Strand]:
        """See `Drawing.draw`."""
        frames = picture.solid
        assert frames is not None
        if self._root is None:
            self._root = self.scene.add_frame(self.root, show_axes=False)
        return [Strand(frames.time, tuple(self.tracks(picture, frames)))]

    @abstractmethod
    def tracks(self, picture: Picture, frames: Frames) -> Sequence[Track]:
        """How its nodes move, at the instants of `frames`, which are `picture.solid`."""

    def show(self, *, visible: bool) -> None:
        """See `Drawing.show`."""
        if self._root is not None:
            self._root.visible = visible


class Copies:
    """Nodes that all draw one mesh: as many as are needed; the rest is hidden."""

    def __init__(self, scene: viser.SceneApi, name: str, glb: bytes) -> None:
        """None.

        Args:
            scene: a tab's.
            name: of the nodes, a number follows.
            glb: the mesh, as binary glTF.
        """
        self._scene = scene
        self._name = name
        self._glb = glb
        self._nodes: list[viser.GlbHandle] = []

    def names(self, count: int) -> list[str]:
        """Names of so many nodes, which are there and visible now; no others are."""
        while len(self._nodes) < count:
            self._nodes.append(
                self._scene.add_glb(
                    f"{self._name}/{len(self._nodes)}",
                    self._glb,
                    cast_shadow=False,
                    receive_shadow=False,
                )
            )
        for index, node in enumerate(self._nodes):
            node.visible = index < count
        return [node.name for node in self._nodes[:count]]

    def replace(self, glb: bytes) -> None:
        """Draw another mesh from now on, if it is another."""
        if glb == self._glb:
            return
        self._glb = glb
        for node in self._nodes:
            node.glb_data = glb
