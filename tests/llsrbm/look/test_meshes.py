"""Meshes with fewer faces: what is thin, and what is another colour, stays so."""

from __future__ import annotations

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
