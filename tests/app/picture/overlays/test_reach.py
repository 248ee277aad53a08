from dataclasses import replace

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from app.motion.baked import bake_plan
from app.picture.overlays.reach import surface
from llsrbm.planning.problem.constraints.reach import Reach
from llsrbm.planning.problem.layout import Layout
from llsrbm.planning.problem.placement import place_task
from llsrbm.request.jump import Jump
from llsrbm.request.schedule import together
from llsrbm.request.tuning import Tuning
from llsrbm.robots import load_robot
from tests.app.picture.overlays.drawn import DrawnOverlay
from tests.app.picture.pictures import picture, planned
from tests.app.synthetic_plan import synthetic_plan

TUNED = Tuning({}, {"reach_max": 0.45, "reach_standing": 0.8})


LAYOUT = Layout.of(together(("leg",)), contacts=1, intervals=48, foot_coordinates=3)
KNOT = {True: 5, False: 21}  # in take-off, in flight


def permitted(robot, tuning, *, standing):
    """Whether feet (..., 3) m in their hip's mirrored axes keep to the planner's own bounds."""
    task = place_task(planned(robot).plan.jump, load_robot(robot), tuning)
    low, high = Reach().bounds(task, LAYOUT, KNOT[standing])

    def check(x, slack):
        rows = np.concatenate([np.sum(x * x, axis=-1, keepdims=True), x], axis=-1)
        return ((rows >= low - slack) & (rows <= high + slack)).all(axis=-1)

    return check


@pytest.mark.parametrize("robot", ["anymal", "slider"])
@pytest.mark.parametrize("tuning", [Tuning(), TUNED])
@pytest.mark.parametrize("standing", [False, True])
def test_it_is_the_region_that_the_planner_permits(robot, tuning, standing):
    if robot == "slider" and tuning:
        tuning = Tuning({}, {"reach_max": 0.7})
    plan = replace(planned(robot).plan, tuning=tuning)
    shown = replace(picture(robot, {"reach"}), planned=bake_plan(plan, load_robot(robot)))
    drawn = DrawnOverlay(shown, f"/regions/{'standing' if standing else 'flying'}")
    frames, arm = shown.solid, load_robot(robot)
    frame = int(np.flatnonzero(frames.stands.any(axis=1) == standing)[5])
    base = Rotation.from_quat(frames.body_wxyz[frame, 0], scalar_first=True)
    legs = [
        base.inv().apply(drawn.vertices(node, frame) - frames.body_position[frame, 0])
        for node in drawn.nodes
    ]
    check = permitted(robot, tuning, standing=standing)
    for points, hip, mirror in zip(legs, arm.hips, arm.mirrors, strict=True):
        x = (points - hip) * mirror
        assert check(x, 1e-5).all()
        middle = x.mean(axis=0)
        assert check(middle, 0.0)
        # A little farther from the middle than the boundary, nothing is permitted.
        assert not check(middle + 1.02 * (x - middle), 0.0).any()


@pytest.mark.parametrize("robot", ["anymal", "slider"])
def test_its_volume_is_that_of_the_region(robot):
    reach = load_robot(robot).file.reach
    region = (reach.distance, reach.lower, reach.upper)
    vertices, faces = surface(region)
    mesh = trimesh.Trimesh(vertices, faces)
    mesh.merge_vertices()
    assert mesh.is_watertight
    low, high = np.array(reach.lower), np.array(reach.upper)
    points = np.random.default_rng(4).uniform(low, high, (200_000, 3))
    distance = np.linalg.norm(points, axis=1)
    inside = (distance >= reach.distance[0]) & (distance <= reach.distance[1])
    assert mesh.volume == pytest.approx(np.prod(high - low) * inside.mean(), rel=0.01)


@pytest.mark.parametrize("robot", ["anymal", "slider"])
def test_standing_and_flying_feet_have_regions_of_their_own(robot):
    shown = picture(robot, {"reach"})
    _check_regions(shown)


def test_in_a_rear_push_only_the_hind_feet_stand():
    shown = picture("anymal", {"reach"})
    plan = synthetic_plan(Jump(type="rear-last"))
    shown = replace(shown, planned=bake_plan(plan, load_robot("anymal")))
    push = (plan.phase_start[1:3]).mean()
    frame = int(np.abs(shown.solid.time - push).argmin())
    assert shown.solid.stands[frame].tolist() == [False, False, True, True]
    _check_regions(shown)


def _check_regions(shown):
    drawn = DrawnOverlay(shown, "/regions")
    sizes = np.stack([drawn.size(node)[:, 0] for node in drawn.nodes], axis=1)
    flying, standing = np.split(sizes, 2, axis=1)
    assert (flying == ~shown.solid.stands).all()
    assert (standing == shown.solid.stands).all()
