"""Meshes with fewer faces: what is thin, and what is another colour, stays so."""

import numpy as np
import pytest
import trimesh

from llsrbm.look.meshes import coarser

SIZE = 0.5  # m, of a robot's legs


def painted(mesh, colour):
    mesh.visual = trimesh.visual.ColorVisuals(mesh, vertex_colors=[*colour, 255])
    return mesh


def test_a_thin_tube_stays_a_tube():
    """A handle of 7 mm where a point stands for 2 cm: it would be a torn sheet."""
    tube = painted(trimesh.creation.cylinder(0.0035, 0.2, sections=12).subdivide(), (40, 40, 40))
    tube.apply_translation([0.11, 0.03, 0.2])
    coarse = coarser(tube, SIZE)
    assert len(coarse.faces) < 0.5 * len(tube.faces)
    assert abs(coarse.volume) > 0.5 * tube.volume
    assert coarse.bounds == pytest.approx(tube.bounds, abs=0.004)


def test_bodies_of_other_colours_keep_theirs():
    """A dark tube between white ends, whose corners are in the same places."""
    tube = painted(trimesh.creation.cylinder(0.012, 0.3), (30, 30, 30))
    ends = [painted(trimesh.creation.cylinder(0.012, 0.03), (230, 230, 230)) for _ in range(2)]
    for end, height in zip(ends, (-0.165, 0.165), strict=True):
        end.apply_translation([0.0, 0.0, height])
    coarse = coarser(trimesh.util.concatenate([*ends, tube]), SIZE)
    dark = np.asarray(coarse.visual.vertex_colors)[coarse.faces, 0].max(axis=1) < 100
    assert coarse.area_faces[dark].sum() == pytest.approx(tube.area, rel=0.25)
    assert coarse.area_faces[~dark].sum() == pytest.approx(2 * ends[0].area, rel=0.25)


def plate(colour_of):
    """A plate of 30 x 10 cm and 4 cm thick, its faces coloured by where their middles are."""
    mesh = trimesh.creation.box((0.3, 0.1, 0.04))
    for _ in range(6):
        mesh = mesh.subdivide()
    mesh.unmerge_vertices()
    colours = np.array([colour_of(*middle) for middle in mesh.triangles_center])
    mesh.visual = trimesh.visual.ColorVisuals(mesh, vertex_colors=np.repeat(colours, 3, axis=0))
    return mesh


def test_letters_have_the_colour_of_their_ground():
    grey, white = (120, 120, 130, 255), (250, 250, 250, 255)
    letter = plate(lambda x, y, z: white if z > 0 and abs(x) < 0.008 and abs(y) < 0.012 else grey)
    assert len(np.unique(letter.visual.vertex_colors, axis=0)) == 2
    assert (np.asarray(coarser(letter, SIZE).visual.vertex_colors)[:, 0] == 120).all()


def test_where_colours_meet_nothing_is_open():
    grey, white = (120, 120, 130, 255), (250, 250, 250, 255)
    coarse = coarser(plate(lambda x, *_: white if x > 0.031 else grey), SIZE)
    seen = np.asarray(coarse.visual.vertex_colors)[:, 0]
    assert set(seen) == {120, 250}
    bright, dark = (coarse.vertices[seen == value] for value in (250, 120))
    apart = np.linalg.norm(bright[:, None] - dark, axis=2).min(axis=1)
    assert (apart < 1e-5).sum() >= 8  # the border's corners are both colours'
    assert apart[(apart > 0) & (apart < 0.005)].max() < 1e-5  # within a cell of the mesh
    assert coarse.area == pytest.approx(plate(lambda *_: grey).area, rel=0.1)
