from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial import ConvexHull, Delaunay

from app.picture.overlays.centre_of_pressure import centre_of_pressure
from app.picture.overlays.support_polygon import edges
from tests.app.picture.overlays.drawn import DrawnOverlay
from tests.app.picture.pictures import picture

PLACES = arrays(float, (8, 2), elements=st.integers(-50, 50).map(lambda x: x / 100))


def corners_in_order(after):
    """Corners along the edges, beginning with the first."""
    corners = np.flatnonzero(after >= 0)
    if not len(corners):
        return []
    path = [int(corners[0])]
    while (following := int(after[path[-1]])) != path[0]:
        path.append(following)
        assert len(path) <= len(after)
    assert sorted(path) == corners.tolist()
    return path


@given(PLACES, st.sets(st.integers(0, 7)))
def test_edges_go_around_the_convex_hull(points, standing):
    there = np.isin(np.arange(8), list(standing))
    path = corners_in_order(edges(points[None], there[None])[0])
    assert set(path) <= standing
    counted = np.unique(points[there], axis=0)
    if len(counted) < 3 or np.linalg.matrix_rank(counted[1:] - counted[0]) < 2:
        assert len(path) <= 2 or len(counted) < 3
        return
    hull = ConvexHull(counted)
    x, y = points[path].T
    area = 0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))
    assert area == pytest.approx(hull.volume)
    assert len(path) == len(hull.vertices)


@pytest.mark.parametrize("robot", ["anymal", "slider"])
@pytest.mark.parametrize("simulation", [False, True])
def test_its_bars_are_the_hull_of_what_stands(robot, simulation):
    shown = picture(robot, {"support"}, simulation=simulation)
    drawn, frames = DrawnOverlay(shown, "/hull"), shown.solid
    for frame in range(0, len(frames.time), 7):
        bars = [node for node in drawn.nodes if drawn.size(node)[frame, 0] > 0]
        standing = frames.contact_point[frame][frames.contact[frame]].reshape(-1, 3)
        if not len(standing):
            assert bars == []
            continue
        hull = ConvexHull(standing[:, :2])
        assert len(bars) == len(hull.vertices)
        # Each bar is as long as its edge, and at the ends half its width longer.
        length = sum(drawn.size(node)[frame, 0] - drawn.size(node)[frame, 1] for node in bars)
        assert length == pytest.approx(hull.area)
        ends = np.concatenate([drawn.vertices(node, frame) for node in bars])
        low, high = standing.min(axis=0), standing.max(axis=0)
        assert ends[:, :2].min(axis=0) == pytest.approx(low[:2], abs=0.02)
        assert ends[:, :2].max(axis=0) == pytest.approx(high[:2], abs=0.02)
        assert ends[:, 2].min() > low[2]
        assert ends[:, 2].max() < high[2] + 0.01


@pytest.mark.parametrize("robot", ["anymal", "slider"])
@pytest.mark.parametrize("simulation", [False, True])
def test_the_centre_of_pressure_lies_inside(robot, simulation):
    frames = picture(robot, simulation=simulation).solid
    place, there = centre_of_pressure(frames)
    checked = 0
    for frame in np.flatnonzero(there & frames.contact.all(axis=1))[::9]:
        hull = Delaunay(frames.contact_point[frame].reshape(-1, 3)[:, :2])
        assert hull.find_simplex(place[frame, :2], tol=1e-6) >= 0
        checked += 1
    assert checked > 3
