"""The picture of one tab: makes nodes and says how they move, as a clip; a player moves them."""

from collections.abc import Iterable, Sequence

import viser

from app.motion.clip import AnimationChannel, Clip, Track
from app.picture.blocks import Blocks
from app.picture.drawing import Drawing, Overlay
from app.picture.lighting import Lighting
from app.picture.overlays import OVERLAYS
from app.picture.picture import Picture, changed_parts
from app.picture.robot_nodes import ContactShadow, SolidRobot
from app.picture.route_path import RoutePath
from app.picture.row import Row
from llsrbm.arrays import Array


class Scene:
    """Draws pictures, one after the other, in one thread; it owns nodes, and no facts."""

    # Browser tests find controls by label. viser's scene tree has labels, too, made from the names
    # of nodes, so these avoid the words of the panel (a node "robot" would be found as "Robot").

    def __init__(self, client: viser.ClientHandle | viser.ViserServer) -> None:
        self._client = client
        self._drawn = Picture()
        scene = client.scene
        self._robot = SolidRobot(scene)
        self._row = Row(scene)  # of those that are compared
        self._always: tuple[Drawing, ...] = (
            Lighting(scene),
            self._robot,
            ContactShadow(scene),
            Blocks(scene),
            RoutePath(scene),
            self._row,
        )
        self._overlays: dict[str, Overlay] = {}
        self._channels: dict[Drawing, Sequence[AnimationChannel]] = {}
        self._outdated: set[Drawing] = set()
        self.appeared = False  # nodes were made by the last drawing that its clip did not move

    def draw(self, picture: Picture) -> Clip | None:
        """Draw what differs from the picture before; how everything moves, if that has changed."""
        changed = changed_parts(self._drawn, picture)
        self.appeared = False
        if not changed:
            return None
        self._drawn = picture
        before = dict(self._channels)
        with self._client.atomic():
            for name in sorted(picture.layers & OVERLAYS.keys() - self._overlays.keys()):
                overlay = self._overlays[name] = OVERLAYS[name](self._client.scene)
                self._outdated.add(overlay)
            for drawing in self._always:
                self._update(drawing, picture, changed, wanted=True)
            for name, overlay in self._overlays.items():
                self._update(overlay, picture, changed, wanted=name in picture.layers)
            self.appeared = self._robot.stand(still=picture.still)
        same = all(
            before.get(drawing, ()) is channels for drawing, channels in self._channels.items()
        )
        return None if same and before.keys() == self._channels.keys() else self._clip()

    def _update(
        self, drawing: Drawing, picture: Picture, changed: frozenset[str], *, wanted: bool
    ) -> None:
        if drawing.parts & changed:
            self._outdated.add(drawing)
        visible = wanted and (picture.planned is not None or not drawing.needs_motion)
        if not visible:
            # What is hidden need not move; drawn anew when it is shown again.
            if self._channels.pop(drawing, None):
                self._outdated.add(drawing)
            drawing.show(visible=False)
        elif drawing in self._outdated:
            self._outdated.discard(drawing)
            channels = tuple(drawing.draw(picture))
            # None before and none now: nothing has changed in how it moves.
            if channels or drawing in self._channels:
                self._channels[drawing] = channels
            drawing.show(visible=True)
        else:
            drawing.show(visible=True)

    def _clip(self) -> Clip:
        channels = _joined(channel for part in self._channels.values() for channel in part)
        end = max((float(channel.time[-1]) for channel in channels), default=0.0)
        parts = tuple(part.plain for part in self._robot.robot_parts)
        return Clip(
            channels, end, camera_target=self._row.seen_by(self._robot.camera_target), parts=parts
        )


def _joined(channels: Iterable[AnimationChannel]) -> tuple[AnimationChannel, ...]:
    times: dict[int, Array] = {}
    tracks: dict[int, list[Track]] = {}
    for channel in channels:
        times[id(channel.time)] = channel.time
        tracks.setdefault(id(channel.time), []).extend(channel.tracks)
    return tuple(AnimationChannel(times[key], tuple(tracks[key])) for key in times if tracks[key])
