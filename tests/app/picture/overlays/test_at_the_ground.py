"""Centre of pressure, polygon of support, cones of friction: what stands on the ground."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial import ConvexHull, Delaunay

from app.motion.baked import bake_plan
from app.picture.overlays.forces import centre_of_pressure
from app.picture.overlays.outlines import edges
from llsrbm.robots import load_robot
from tests.app.picture.overlays.drawn import DrawnOverlay
from tests.app.picture.pictures import picture, planned


@pytest.mark.parametrize("robot", ["anymal", "slider"])
def test_the_ground_has_no_moment_there(robot):
    """Over all contacts, sum (p_i - c) x f_i has no horizontal part: the definition."""
    shown = picture(robot, {"pressure"})
    drawn, plan = DrawnOverlay(shown, "/zmp"), shown.planned.plan
    (node,) = drawn.nodes
    frames, knot = shown.solid, 4
    frame = int(np.abs(frames.time - plan.time[knot]).argmin())
    vertices = drawn.vertices(node, frame)
    centre = (vertices.max(axis=0) + vertices.min(axis=0)) / 2
    arm = plan.contact_point[knot] - centre * [1, 1, 0]
    moment = np.cross(arm, plan.contact_force[knot] * [0, 0, 1]).sum(axis=0)
    assert moment == pytest.approx(np.zeros(3), abs=2e-3 * frames.weight)
    # Pushed harder on one side: it is not just the middle of the feet.
    middle = plan.contact_point[knot].mean(axis=0)
    assert np.linalg.norm((centre - middle)[:2]) > 0.01


@pytest.mark.parametrize("simulation", [False, True])
def test_there_is_none_in_flight(simulation):
    shown = picture("anymal", {"pressure"}, simulation=simulation)
    drawn = DrawnOverlay(shown, "/zmp")
    there = drawn.size(drawn.nodes[0])[:, 0] > 0
    # A simulation's forces are means over a frame, which may begin in flight.
    assert there[~shown.solid.contact.any(axis=1)].sum() <= simulation
    assert there[shown.solid.contact.all(axis=1)].mean() > 0.9


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


@given(PLACES, st.sets(st.integers(0, 7)), st.sampled_from([0.0, 1e-13]))
@example(np.zeros((8, 2)), {0, 1, 2}, 1e-13)
def test_edges_go_around_the_convex_hull(points, standing, noise):
    points = points + noise * np.random.default_rng(0).normal(size=points.shape)
    there = np.isin(np.arange(8), list(standing))
    path = corners_in_order(edges(points[None], there[None])[0])
    assert set(path) <= standing
    counted = np.unique(points[there], axis=0)
    if len(counted) < 3 or np.linalg.matrix_rank(counted[1:] - counted[0], tol=1e-6) < 2:
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
        assert 3 <= len(bars) <= len(standing)  # corners on one line, but for rounding, may count
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


def with_friction(mu, robot):
    """A picture of a plan that was made under another coefficient."""
    plan = replace(planned(robot).plan, limits={"friction": mu})
    return replace(picture(robot, {"friction"}), planned=bake_plan(plan, load_robot(robot)))


@pytest.mark.parametrize("robot", ["anymal", "slider"])
@pytest.mark.parametrize("mu", [None, 0.3, 1.2])
def test_its_edges_lie_in_the_cone_of_friction(robot, mu):
    shown = picture(robot, {"friction"}) if mu is None else with_friction(mu, robot)
    expected = load_robot(robot).file.limits.friction if mu is None else mu
    drawn = DrawnOverlay(shown, "/pyramids")
    frames = shown.planned.frames
    assert len(drawn.nodes) == frames.contact.shape[1]
    for foot, node in enumerate(drawn.nodes):
        from_tip = drawn.vertices(node, 3) - frames.pressed_at[3, foot]
        edges = np.unique(np.round(from_tip[from_tip[:, 2] > 1e-6], 9), axis=0)
        assert len(edges) == 4
        angles = np.arctan2(np.linalg.norm(edges[:, :2], axis=1), edges[:, 2])
        assert angles == pytest.approx([math.atan(expected)] * 4, rel=1e-5)
        # The planner's rows: |f_x|, |f_y| <= mu / sqrt(2) f_z, along the world's axes.
        steepness = np.abs(edges[:, :2]) / edges[:, 2:]
        assert steepness == pytest.approx(np.full((4, 2), expected / math.sqrt(2)), rel=1e-5)


@pytest.mark.parametrize("simulation", [False, True])
def test_pyramids_stand_where_feet_do(simulation):
    shown = picture("anymal", {"friction"}, simulation=simulation)
    drawn = DrawnOverlay(shown, "/pyramids")
    for foot, node in enumerate(drawn.nodes):
        there = drawn.size(node)[:, 2] > 0
        assert (there == shown.solid.contact[:, foot]).all()
        assert 0 < there.sum() < len(there)
