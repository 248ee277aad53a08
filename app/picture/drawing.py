"""One thing in the picture, as a class: what it is drawn from, and how it moves."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from enum import StrEnum
from typing import ClassVar

import viser

from app.motion.clip import AnimationChannel, Track
from app.motion.colours import Rgb
from app.picture.picture import Picture
from llsrbm.look.shown_motion import ShownMotion

Meaning = tuple[Rgb, str]
"""A colour, and what is drawn in it."""


class Drawing(ABC):
    """Draws some parts of a picture; its nodes are made when they are drawn first.

    Making a node costs a browser far more than moving it (new buffers, perhaps a new shader), so
    nodes stay, and are only changed, moved and hidden.
    """

    # the fields of `Picture` that it is drawn from; while these stay it is left alone
    parts: ClassVar[frozenset[str]] = frozenset({"robot", "planned", "simulated"})
    # whether there is nothing to draw of a robot that only stands there
    needs_motion: ClassVar[bool] = True

    def __init__(self, scene: viser.SceneApi) -> None:
        self.scene = scene

    @abstractmethod
    def draw(self, picture: Picture) -> Sequence[AnimationChannel]:
        """Take along what does not move; how the rest moves. See `needs_motion`."""

    @abstractmethod
    def show(self, *, visible: bool) -> None:
        """Show or hide everything; may be called before anything is drawn."""


class Group(StrEnum):
    """Headings under which boxes stand, in their order."""

    INERTIA = "Inertia and motion"
    FORCES = "Forces"
    FOOTHOLDS = "Footholds"
    DEBUG = "Debug"


class Overlay(Drawing):
    """Drawn besides the robot if its box is ticked; its nodes hang below one node."""

    name: ClassVar[str]  # in `Picture.layers`
    title: ClassVar[str]  # label of its box
    hint: ClassVar[str]  # its meaning in one sentence
    group: ClassVar[Group]  # heading above its box
    place: ClassVar[int]  # of its box among the others, a number
    tints: ClassVar[tuple[Rgb, ...]] = ()  # colours in which it is drawn, whatever the motion
    at_first: ClassVar[bool] = False  # whether its box is ticked when a page opens
    common: ClassVar[bool] = False  # whether its box stands before the folded ones
    # name of its node. viser labels nodes by their names, and tests find controls by label: it
    # differs from `title`
    root: ClassVar[str] = ""

    def __init__(self, scene: viser.SceneApi) -> None:
        super().__init__(scene)
        self._root: viser.FrameHandle | None = None
        self._copies: dict[str, Copies] = {}

    @classmethod
    def swatch(cls, picture: Picture) -> Sequence[Rgb]:
        """The colours in which it is drawn; none: it shows nothing of this picture."""
        return cls.tints

    @classmethod
    def legend(cls, picture: Picture) -> Sequence[Meaning]:
        """Its colours and what they mean in this picture, for the picture's legend."""
        return [(colour, cls.title.lower()) for colour in cls.swatch(picture)[:1]]

    def draw(self, picture: Picture) -> Sequence[AnimationChannel]:
        _, _, frames = picture.motion
        return self.channels(frames, self.tracks(picture, frames))

    def tracks(self, picture: Picture, frames: ShownMotion) -> Sequence[Track]:
        """How its nodes move, at the instants of `frames`, the robot that is drawn solid."""
        return ()

    def channels(self, frames: ShownMotion, tracks: Sequence[Track]) -> Sequence[AnimationChannel]:
        """Tracks at the instants of frames."""
        return [AnimationChannel(frames.time, tuple(tracks))]

    def show(self, *, visible: bool) -> None:
        if self._root is not None:
            self._root.visible = visible

    def nothing(self) -> Sequence[AnimationChannel]:
        """Hide all nodes: there is nothing to draw of this picture."""
        for copies in self._copies.values():
            copies.names(0)
        return ()

    def nodes(self, glb: bytes, count: int, name: str = "") -> list[str]:
        """Names of so many nodes below the root that draw one mesh (glTF); others are hidden."""
        if self._root is None:
            self._root = self.scene.add_frame(self.root, show_axes=False)
        path = f"{self.root}/{name}" if name else self.root
        copies = self._copies.setdefault(name, Copies(self.scene, path, glb))
        copies.replace(glb)
        return copies.names(count)

    def each(self, name: str, meshes: Sequence[bytes]) -> list[str]:
        """Names of one node for each mesh; those that another robot had more of are hidden."""
        kind = f"{name}/" if name else ""
        found = [self.nodes(mesh, 1, f"{kind}{index}")[0] for index, mesh in enumerate(meshes)]
        while (gone := f"{kind}{len(found)}") in self._copies:
            found.append("")
            self._copies[gone].names(0)
        return found[: len(meshes)]


class Copies:
    """Nodes that all draw one mesh: as many as are needed; the rest is hidden."""

    def __init__(self, scene: viser.SceneApi, name: str, glb: bytes) -> None:
        self._scene, self._name, self._glb = scene, name, glb
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
