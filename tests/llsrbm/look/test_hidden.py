"""Which faces of a body are left: those from which a ray leaves it."""

import ctypes
import os

import numpy as np
import pytest
import trimesh

from llsrbm.look.hidden import without_hidden


def _box(size, at=(0.0, 0.0, 0.0), colour=200):
    box = trimesh.creation.box((size, size, size))
    box.apply_translation(at)
    return trimesh.Trimesh(
        box.vertices, box.faces, vertex_colors=np.full((8, 4), colour, np.uint8), process=False
    )


def test_what_is_inside_another_part_is_left_out():
    outer, inner = _box(0.2), _box(0.1, colour=90)
    (found,) = without_hidden([outer, inner])
    np.testing.assert_allclose(found.vertices, outer.vertices)
    assert len(found.faces) == len(outer.faces)


def test_what_comes_through_a_wall_stays_without_its_hidden_side():
    outer, inner = _box(0.2), _box(0.05, at=(0.1, 0.0, 0.0), colour=90)
    _, found = without_hidden([outer, inner])
    assert (found.visual.vertex_colors[:, 0] == 90).all()
    ends = found.triangles_center[:, 0]
    assert ends.max() > 0.12
    assert ends.min() > 0.07  # the face at 0.075 m is behind the wall at 0.1 m


def test_an_open_box_is_seen_from_within():
    box = _box(0.2)
    lid = box.triangles_center[:, 2] > 0.099
    box.update_faces(~lid)
    (found,) = without_hidden([box])
    assert len(found.faces) == 10


def test_a_body_that_no_ray_meets_is_kept():
    flat = trimesh.Trimesh(np.zeros((3, 3)), [[0, 1, 2]], process=False)
    (found,) = without_hidden([flat])
    assert len(found.faces) == 1


def test_what_is_seen_does_not_depend_on_where_the_body_is():
    parts = [_box(0.2), _box(0.1), _box(0.05, at=(0.0, 0.1, 0.0))]
    counts = [len(part.faces) for part in without_hidden(parts)]
    turn = trimesh.transformations.rotation_matrix(0.7, (1.0, 2.0, 3.0))
    turn[:3, 3] = 3.0, -2.0, 1.0
    for part in parts:
        part.apply_transform(turn)
    assert [len(part.faces) for part in without_hidden(parts)] == counts


@pytest.mark.skipif(os.name != "posix", reason="only there the C library's seed is set")
def test_it_is_the_same_in_every_process_whatever_was_drawn_before():
    """What is seen through a slit hangs on single rays."""
    box, ball = _box(0.2), trimesh.creation.icosphere(4, 0.08)
    walls = [_box(0.2, at=(at, 0.0, 0.0)) for at in (-0.21, 0.21)]
    box.update_faces(np.abs(box.triangles_center[:, 0]) < 0.099)  # open where the walls are near
    found = []
    for drawn in (0, 1001):
        for _ in range(drawn):
            ctypes.CDLL(None).rand()
        found.append([part.faces for part in without_hidden([box, ball, *walls])])
    for one, other in zip(*found, strict=True):
        np.testing.assert_array_equal(one, other)
    assert 0 < len(found[0][1]) < len(ball.faces)
