"""Blocks that the simulated robot stands and lands on, while they are there."""

from collections.abc import Sequence

import numpy as np
import viser

from app.motion import colours
from app.motion.clip import AnimationChannel, Track
from app.picture.drawing import Drawing
from app.picture.picture import Picture
from llsrbm.arrays import Array, BoolArray
from llsrbm.motion.block import Block


class Blocks(Drawing):
    """Boxes; of a plan alone they are drawn with the landing marks, as what it aims at."""

    parts = frozenset({"planned", "simulated", "blocks"})

    def __init__(self, scene: viser.SceneApi) -> None:
        super().__init__(scene)
        self._nodes: list[viser.BoxHandle] = []
        self._shown = 0

    def draw(self, picture: Picture) -> Sequence[AnimationChannel]:
        frames = picture.simulated
        blocks = () if frames is None else picture.blocks
        while len(self._nodes) < len(blocks):
            self._nodes.append(self.add(self.scene, f"/blocks/{len(self._nodes)}"))
        for node, block in zip(self._nodes, blocks, strict=False):
            place(node, block)
        self._shown = len(blocks)
        self.show(visible=True)
        if frames is None or not blocks:
            return ()
        pairs = zip(self._nodes, blocks, strict=False)
        return [
            AnimationChannel(
                frames.time,
                tuple(standing_track(node.name, block, frames.time) for node, block in pairs),
            )
        ]

    @staticmethod
    def add(scene: viser.SceneApi, name: str) -> viser.BoxHandle:
        """A node for a block."""
        return scene.add_box(name, colours.BLOCK, opacity=0.55, cast_shadow=False)

    def show(self, *, visible: bool) -> None:
        for index, node in enumerate(self._nodes):
            node.visible = visible and index < self._shown


def tops_under(blocks: Sequence[Block], points: Array, time: Array, ground: float) -> Array:
    """(F,) m: heights below `points` (F, 3) m at `time` (F,) s: the ground's, or a block's top."""
    tops = np.full(len(points), ground)
    for block in blocks:
        R = block.rotation
        surface = block.centre + R[:, 2] * block.size[2] / 2
        top = surface[2] + (points - surface)[:, :2] @ np.array(block.tilt)
        seen = (np.column_stack([points[:, :2], top]) - surface) @ R
        above = (np.abs(seen[:, :2]) <= block.size[:2] / 2).all(axis=1)
        tops = np.where(_stands(block, time) & above, np.maximum(tops, top), tops)
    return tops


def place(node: viser.BoxHandle, block: Block) -> None:
    """Put a node where a block is, as large."""
    node.dimensions = (float(block.size[0]), float(block.size[1]), float(block.size[2]))
    node.position = block.centre
    node.wxyz = block.quat


def standing_track(name: str, block: Block, time: Array) -> Track:
    """At its place at those of the instants (F,) s at which it stands there."""
    return Track(
        (name,),
        np.broadcast_to(block.centre, (len(time), 3)),
        scale=np.repeat(_stands(block, time)[:, None], 3, axis=1).astype(float),
    )


def _stands(block: Block, time: Array) -> BoolArray:
    return (block.from_s <= time) & (time < block.until_s)
