from __future__ import annotations

import io
from types import SimpleNamespace
from unittest.mock import MagicMock

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from app.scene.overlays import ARROW_PER_WEIGHT, Blocks, Forces, tops_under
from llsrbm.simulation.surroundings import Block

WEIGHT = 300.0  # N
BOX = Block(
    "box",
    centre=np.array([1.0, 0.0, 0.1]),
    size=np.array([1.0, 0.2, 0.2]),
    yaw=np.radians(90),
    from_s=0.5,
)


@pytest.fixture
def client():
    return SimpleNamespace(scene=MagicMock())


def test_the_blot_lies_on_what_is_below():
    points = np.array([[1.0, 0.4, 0.9], [1.0, 0.4, 0.9], [1.4, 0.0, 0.9], [1.0, -0.6, 0.9]])
    tops = tops_under([BOX], points, np.array([0.6, 0.4, 0.6, 0.6]), -0.1)
    # There; not there yet; turned, so short along x; beside it.
    assert tops == pytest.approx([0.2, -0.1, -0.1, -0.1])


def test_the_blot_lies_on_the_highest():
    low = Block("low", centre=np.array([1.0, 0.0, 0.02]), size=np.array([3.0, 3.0, 0.04]), yaw=0.0)
    points = np.array([[1.0, 0.0, 0.9], [2.0, 1.0, 0.9]])
    for blocks in ([BOX, low], [low, BOX]):
        assert tops_under(blocks, points, np.ones(2), 0.0) == pytest.approx([0.2, 0.04])


def arrows(client, force):
    """Of one foot under forces (F, 3) N: where they begin and end, (F, 3) m each."""
    pressed = np.arange(3.0 * len(force)).reshape(-1, 3)
    frames = SimpleNamespace(foot_force=force[:, None], pressed_at=pressed[:, None], weight=WEIGHT)
    (track,) = Forces(client, 1).tracks(frames)
    assert track.nodes == ("/arrows/0",)
    assert track.position == pytest.approx(pressed)
    tip = Rotation.from_quat(track.wxyz, scalar_first=True).apply(track.scale * [0.0, 0.0, 1.0])
    return track.scale, tip


DIRECTIONS = arrays(float, (5, 3), elements=st.floats(-900, 900, width=32))


@given(DIRECTIONS)
def test_an_arrow_points_and_reaches_as_its_force_does(force):
    scale, tip = arrows(SimpleNamespace(scene=MagicMock()), force)
    pushing = np.linalg.norm(force, axis=1) > 1.0
    expected = np.where(pushing[:, None], force * ARROW_PER_WEIGHT / WEIGHT, 0.0)
    assert tip == pytest.approx(expected, abs=1e-4)
    assert (scale[~pushing] == 0).all()
    assert (scale[pushing] > 0).all()


@pytest.mark.parametrize("down", [[0, 0, -300.0], [1e-9, 0, -300.0], [0, 1e-4, -300.0]])
def test_an_arrow_may_point_straight_down(client, down):
    _, tip = arrows(client, np.array([down]))
    assert tip[0] == pytest.approx([0, 0, -ARROW_PER_WEIGHT], abs=1e-3)


def test_each_foot_has_an_arrow_of_its_own(client):
    force = np.zeros((1, 2, 3))
    force[0, 1, 2] = WEIGHT
    frames = SimpleNamespace(foot_force=force, pressed_at=np.zeros((1, 2, 3)), weight=WEIGHT)
    idle, pushing = Forces(client, 2).tracks(frames)
    assert idle.scale.tolist() == [[0, 0, 0]]
    assert pushing.scale[0, 2] == pytest.approx(ARROW_PER_WEIGHT)


def test_the_arrow_is_one_metre_long_from_the_origin_along_z(client):
    Forces(client, 1)
    _, content = client.scene.add_glb.call_args.args
    mesh = trimesh.load(io.BytesIO(content), file_type="glb", force="mesh")
    assert mesh.bounds[:, 2] == pytest.approx([0.0, 1.0], abs=1e-6)
    assert np.abs(mesh.bounds[:, :2]).max() < 0.05


def test_a_block_is_there_from_its_first_to_its_last_instant(client):
    blocks = Blocks(client)
    blocks.draw([BOX, Block("gone", np.zeros(3), np.ones(3), yaw=0.0, until_s=0.5)])
    appears, goes = blocks.tracks(np.array([0.0, 0.49, 0.5, 1.0]))
    assert appears.position == pytest.approx(np.tile(BOX.centre, (4, 1)))
    assert appears.scale.tolist() == [[0] * 3, [0] * 3, [1] * 3, [1] * 3]
    assert goes.scale.tolist() == [[1] * 3, [1] * 3, [0] * 3, [0] * 3]
    assert client.scene.add_box.call_args_list[0].kwargs["dimensions"] == (1.0, 0.2, 0.2)


def test_other_blocks_take_the_place_of_the_old_ones(client):
    blocks = Blocks(client)
    blocks.draw([BOX, BOX])
    old = list(blocks.nodes.values())
    blocks.draw([])
    assert all(node.remove.called for node in old)
    assert blocks.tracks(np.zeros(2)) == []
