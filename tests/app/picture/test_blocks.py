from types import SimpleNamespace

import numpy as np
import pytest

from app.picture.blocks import Blocks, tops_under
from app.picture.picture import Picture
from llsrbm.motion.block import Block
from tests.app.picture.recorded import RecordedClient

BOX = Block(
    "box",
    centre=np.array([1.0, 0.0, 0.1]),
    size=np.array([1.0, 0.2, 0.2]),
    yaw=np.radians(90),
    from_s=0.5,
)
GONE = Block("gone", np.zeros(3), np.ones(3), yaw=0.0, until_s=0.5)
FRAMES = SimpleNamespace(time=np.array([0.0, 0.49, 0.5, 1.0]))


def test_below_a_point_is_what_stands_there():
    points = np.array([[1.0, 0.4, 0.9], [1.0, 0.4, 0.9], [1.4, 0.0, 0.9], [1.0, -0.6, 0.9]])
    tops = tops_under([BOX], points, np.array([0.6, 0.4, 0.6, 0.6]), -0.1)
    # There; not there yet; turned, so short along x; beside it.
    assert tops == pytest.approx([0.2, -0.1, -0.1, -0.1])


def test_below_a_point_the_highest_counts():
    low = Block("low", centre=np.array([1.0, 0.0, 0.02]), size=np.array([3.0, 3.0, 0.04]), yaw=0.0)
    points = np.array([[1.0, 0.0, 0.9], [2.0, 1.0, 0.9]])
    for blocks in ([BOX, low], [low, BOX]):
        assert tops_under(blocks, points, np.ones(2), 0.0) == pytest.approx([0.2, 0.04])


def test_a_block_is_there_from_its_first_to_its_last_instant():
    client = RecordedClient()
    (strand,) = Blocks(client.scene).draw(Picture(simulated=FRAMES, blocks=(BOX, GONE)))
    appears, goes = strand.tracks
    assert appears.position == pytest.approx(np.tile(BOX.centre, (4, 1)))
    assert appears.scale.tolist() == [[0] * 3, [0] * 3, [1] * 3, [1] * 3]
    assert goes.scale.tolist() == [[1] * 3, [1] * 3, [0] * 3, [0] * 3]
    assert client.scene.nodes["/blocks/0"].dimensions == (1.0, 0.2, 0.2)


def test_other_blocks_take_the_nodes_of_the_old_ones():
    client = RecordedClient()
    blocks = Blocks(client.scene)
    blocks.draw(Picture(simulated=FRAMES, blocks=(BOX, GONE)))
    blocks.draw(Picture(simulated=FRAMES, blocks=(GONE,)))
    assert client.scene.nodes["/blocks/0"].dimensions == (1.0, 1.0, 1.0)
    assert client.scene.seen() == {"/blocks/0"}
    assert blocks.draw(Picture(simulated=FRAMES)) == ()
    assert client.scene.seen() == set()
    assert len(client.scene.made) == 2
