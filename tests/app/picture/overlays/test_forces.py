import io
from types import SimpleNamespace

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from app.motion import colours
from app.picture import gltf
from app.picture.overlays.forces import Forces
from app.picture.picture import Picture
from llsrbm.look.shown_motion import ARROW_PER_WEIGHT, ShownMotion
from tests.app.picture.recorded import RecordedClient

WEIGHT = 300.0  # N


def pressing(force, pressed):
    """Frames of feet under forces (F, L, 3) N that act at places (F, L, 3) m."""
    frames = SimpleNamespace(foot_force=force, pressed_at=pressed, weight=WEIGHT)
    frames.arrows = ShownMotion.arrows.fget(frames)
    return frames


def arrow(force):
    """Of one foot under forces (F, 3) N: where they begin and end, (F, 3) m each."""
    pressed = np.arange(3.0 * len(force)).reshape(-1, 3)
    frames = pressing(force[:, None], pressed[:, None])
    (track,) = Forces(RecordedClient().scene).tracks(Picture(), frames)
    assert track.nodes == ("/arrows/0",)
    assert track.position == pytest.approx(pressed)
    tip = Rotation.from_quat(track.wxyz, scalar_first=True).apply(track.scale * [0.0, 0.0, 1.0])
    return track.scale, tip


DIRECTIONS = arrays(float, (5, 3), elements=st.floats(-900, 900, width=32))


@given(DIRECTIONS)
def test_an_arrow_points_and_reaches_as_its_force_does(force):
    scale, tip = arrow(force)
    pushing = np.linalg.norm(force, axis=1) > 1.0
    expected = np.where(pushing[:, None], force * ARROW_PER_WEIGHT / WEIGHT, 0.0)
    assert tip == pytest.approx(expected, abs=1e-4)
    assert (scale[~pushing] == 0).all()
    assert (scale[pushing] > 0).all()


@pytest.mark.parametrize("down", [[0, 0, -300.0], [1e-9, 0, -300.0], [0, 1e-4, -300.0]])
def test_an_arrow_may_point_straight_down(down):
    _, tip = arrow(np.array([down]))
    assert tip[0] == pytest.approx([0, 0, -ARROW_PER_WEIGHT], abs=1e-3)


def test_each_foot_has_an_arrow_of_its_own():
    force = np.zeros((1, 2, 3))
    force[0, 1, 2] = WEIGHT
    frames = pressing(force, np.zeros((1, 2, 3)))
    idle, pushing = Forces(RecordedClient().scene).tracks(Picture(), frames)
    assert idle.scale.tolist() == [[0, 0, 0]]
    assert pushing.scale[0, 2] == pytest.approx(ARROW_PER_WEIGHT)


def test_the_arrow_is_one_metre_long_from_the_origin_along_z():
    content = gltf.arrow(colours.FORCE)
    mesh = trimesh.load(io.BytesIO(content), file_type="glb", force="mesh")
    assert mesh.bounds[:, 2] == pytest.approx([0.0, 1.0], abs=1e-6)
    assert np.abs(mesh.bounds[:, :2]).max() < 0.05
