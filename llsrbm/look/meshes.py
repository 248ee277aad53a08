"""Meshes made for rendering offline, readable and with as many faces as a browser likes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from llsrbm.arrays import Array, IntArray

if TYPE_CHECKING:
    import trimesh

_SIMPLE = 200  # faces of a part that are kept in any case
_CREASE = np.radians(40.0)  # edges sharper than this stay sharp under smooth shading
_COARSE_CREASE = np.radians(60.0)  # the same of a coarse mesh, which has few vertices to split
_COARSE_CELL = 0.034  # of the legs' length: what is smaller is one point in a coarse mesh
_OF_SHEET, _DETAIL = 0.08, 0.35  # a sheet's points are at most that share of it, or of the legs'
_LETTERS = 0.085  # of the legs' length: patches of a colour that are smaller are left out, coarsely
_FROM, _TELLING = "from", 1e-6  # m, by which vertices of two colours in one place differ
_SAMPLES = 20_000  # points on a surface, of which most around a patch count
_THIN = 0.6  # share of a bar's thickness that is one point: less than all, or it is flat
_THINNEST = 0.007  # of the legs' length: thinner bars, sheets and open shells are as all else


def face_shares(parts: list[trimesh.Trimesh], total: int) -> list[int]:
    """Faces for each part: large and detailed ones get more, none more than it has."""
    have = np.array([len(part.faces) for part in parts], dtype=float)
    weight = np.sqrt(have * np.array([part.area for part in parts]))
    shares, open_parts, left = np.zeros_like(have), np.ones(len(parts), dtype=bool), float(total)
    while open_parts.any():
        offer = left * weight / weight[open_parts].sum()
        full = open_parts & (offer >= have)
        if not full.any():
            shares[open_parts] = offer[open_parts]
            break
        shares[full] = have[full]
        left, open_parts = max(left - have[full].sum(), 0.0), open_parts & ~full
    # What is simple already is left alone: a tube of 80 faces does not survive with 20.
    return [int(max(share, min(part, _SIMPLE))) for share, part in zip(shares, have, strict=True)]


def simplified(part: trimesh.Trimesh, faces: int, size: float) -> trimesh.Trimesh:
    """A part with about that many faces, creased where it is sharp, coloured as it was.

    What is tiny against the robot's `size`, m (screws, threads, fillets) goes first.
    """
    import fast_simplification
    import trimesh

    mesh = part
    if len(mesh.faces) > faces:
        mesh = _without_specks(_clustered(mesh, 0.004 * size), 0.03 * size)
    for haste in (5.0, 7.0, 10.0):
        if len(mesh.faces) <= faces:
            break
        vertices, triangles = fast_simplification.simplify(
            np.asarray(mesh.vertices), np.asarray(mesh.faces), target_count=faces, agg=haste
        )[:2]
        mesh = trimesh.Trimesh(vertices, triangles, process=False)
    mesh = _clustered(mesh, 1e-5 * size)
    mesh.update_faces(mesh.nondegenerate_faces(height=1e-6 * size))
    return _creased(mesh, _CREASE, part.vertices, np.asarray(part.visual.vertex_colors)[:, :3])


def coarser(part: trimesh.Trimesh, size: float) -> trimesh.Trimesh:
    """The surface with about a third of the faces, coloured as it was nearby; `size`: m."""
    # Not collapsed edge by edge, which would tear thin tubes of few and long triangles.
    colours = _without_letters(part, _LETTERS * size)
    piece = _pieces(part, 1e-5 * size)
    cell = np.minimum(_THIN * _thickness(part, piece), _COARSE_CELL * size)
    sheet = cell < _THINNEST * size
    detail = np.maximum(_extent(part, piece), _DETAIL * size)
    cell[sheet] = np.minimum(_COARSE_CELL * size, _OF_SHEET * detail)[sheet]
    # What is another colour stays so, and is where its neighbours are.
    mesh = _clustered(part, cell[piece, None], piece[:, None], colours >> 6)
    mesh.update_faces(mesh.nondegenerate_faces(height=1e-6 * size))
    colours = colours[mesh.vertex_attributes[_FROM]]
    return _creased(mesh, _COARSE_CREASE, np.asarray(mesh.vertices), colours)


def _without_letters(part: trimesh.Trimesh, largest: float) -> NDArray[np.uint8]:
    """(V, 3) colours, but of patches smaller than `largest`, m, what most around them has: of
    letters and marks coarse meshes would leave shards.
    """
    import trimesh
    from scipy.spatial import cKDTree

    own = np.asarray(part.visual.vertex_colors)[:, :3]
    kinds, kind = np.unique(own, axis=0, return_inverse=True)
    kind, patch = kind.reshape(-1), _pieces(part, 1e-5, kind.reshape(-1).astype(np.int64))
    points, faces = trimesh.sample.sample_surface(part, _SAMPLES, seed=0)
    corner = np.asarray(part.faces)[faces, 0]
    tree, found = cKDTree(points), own.copy()
    for number in range(patch.max() + 1):
        of_patch = patch == number
        places = np.asarray(part.vertices)[of_patch]
        if np.linalg.norm(np.ptp(places, axis=0)) > largest:
            continue
        near = np.unique(np.concatenate(tree.query_ball_point(places, largest / 2))).astype(int)
        near = near[patch[corner[near]] != number]
        if len(near):
            found[of_patch] = kinds[np.bincount(kind[corner[near]]).argmax()]
    return found


def _creased(
    mesh: trimesh.Trimesh, angle: float, places: Array, colours: NDArray[np.uint8]
) -> trimesh.Trimesh:
    """The mesh with edges sharper than `angle`, rad, kept sharp, coloured as the nearest of places
    (P, 3) m is.
    """
    import trimesh
    from scipy.spatial import cKDTree

    smooth = trimesh.graph.smooth_shade(mesh, angle=angle, facet_minarea=None)
    nearest = cKDTree(places).query(np.asarray(smooth.vertices))[1]
    return trimesh.Trimesh(
        smooth.vertices,
        smooth.faces,
        vertex_normals=smooth.vertex_normals,
        vertex_colors=colours[nearest],
        process=False,
    )


def _pieces(mesh: trimesh.Trimesh, cell: float, kind: IntArray | None = None) -> IntArray:
    """(V,) number of the connected piece that each vertex is of; vertices in one place, and of one
    kind (V,), are one.
    """
    cells = np.round(np.asarray(mesh.vertices) / cell).astype(np.int64)
    if kind is not None:
        cells = np.column_stack([cells, kind])
    place = np.unique(cells, axis=0, return_inverse=True)[1].reshape(-1)
    edges = place[mesh.faces[:, [0, 1, 1, 2]]].reshape(-1, 2)
    return _connected(edges, place.max() + 1)[place]


def _connected(edges: IntArray, count: int) -> IntArray:
    """(count,) number of the connected piece of each vertex that edges (E, 2) join."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    graph = coo_array((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), shape=(count, count))
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)


def _extent(mesh: trimesh.Trimesh, piece: IntArray) -> Array:
    """(P,) m, the diagonal of the box about each piece."""
    low, high = np.full((piece.max() + 1, 3), np.inf), np.full((piece.max() + 1, 3), -np.inf)
    np.minimum.at(low, piece, mesh.vertices)
    np.maximum.at(high, piece, mesh.vertices)
    return np.asarray(np.linalg.norm(high - low, axis=1))


def _thickness(mesh: trimesh.Trimesh, piece: IntArray) -> Array:
    """(P,) m of each piece: the diameter of a bar with as much volume to its surface."""
    of_face = piece[mesh.faces[:, 0]]
    middle = np.array([np.bincount(piece, axis) for axis in mesh.vertices.T])
    corners = mesh.triangles - (middle / np.bincount(piece)).T[of_face, None]
    volume = np.einsum("fi,fi->f", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    count = int(piece.max()) + 1
    volumes, areas = (np.bincount(of_face, each, count) for each in (volume, mesh.area_faces))
    return np.asarray(4 * np.abs(volumes) / np.maximum(areas, 1e-12))


def _clustered(
    mesh: trimesh.Trimesh,
    cell: float | Array,
    apart: NDArray[Any] | None = None,
    unlike: NDArray[Any] | None = None,
) -> trimesh.Trimesh:
    """Vertices in the same cell of a grid made one, without the faces that vanish by it.

    cell: m, of all or (V, 1); apart, unlike: (V, K) numbers in which those that are made one are
    equal; those that differ in `unlike` alone lie in one place, but for what tells them apart.
    The attribute `_FROM` of a vertex is one of those that it is made of.
    """
    import trimesh

    cells = np.round(np.asarray(mesh.vertices) / cell).astype(np.int64)
    if apart is not None:
        cells = np.column_stack([cells, apart])
    _, first, place = np.unique(cells, axis=0, return_index=True, return_inverse=True)
    where = first[place.reshape(-1)]  # of each vertex, the one in whose place it is
    kinds = where[:, None] if unlike is None else np.column_stack([where, unlike])
    _, first, merged = np.unique(kinds, axis=0, return_index=True, return_inverse=True)
    faces = merged.reshape(-1)[mesh.faces]
    a, b, c = faces.T
    faces = faces[(a != b) & (b != c) & (c != a)]
    vertices = mesh.vertices[where[first]]
    if unlike is not None:
        vertices = vertices + _TELLING * kinds[first, 1:] / np.max(unlike, initial=1)
    joined = trimesh.Trimesh(vertices, faces, process=False, vertex_attributes={_FROM: first})
    joined.update_faces(joined.unique_faces())
    joined.remove_unreferenced_vertices()
    return joined


def _without_specks(mesh: trimesh.Trimesh, size: float) -> trimesh.Trimesh:
    """The mesh without its connected pieces smaller than `size`, m, unless that is all there is."""
    label = _connected(mesh.edges_unique, len(mesh.vertices))
    pieces = label.max() + 1
    low, high = np.full((pieces, 3), np.inf), np.full((pieces, 3), -np.inf)
    np.minimum.at(low, label, mesh.vertices)
    np.maximum.at(high, label, mesh.vertices)
    keep = ((high - low).max(axis=1) >= size)[label[mesh.faces[:, 0]]]
    if keep.any():
        mesh.update_faces(keep)
        mesh.remove_unreferenced_vertices()
    return mesh
