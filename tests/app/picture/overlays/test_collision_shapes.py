import mujoco
import numpy as np
import pytest

from app.picture.overlays.bodies import shapes_of
from llsrbm.motion.rollout import Disturbance
from llsrbm.motion.surroundings import Surroundings
from llsrbm.robots import load_robot
from llsrbm.robots.feet import foot_contacts
from llsrbm.simulation.scene import build_scene, joints_in_model_order
from tests.app.picture.overlays.drawn import DrawnOverlay
from tests.app.picture.pictures import picture


@pytest.mark.parametrize("robot", ["anymal", "slider"])
def test_they_are_what_mujoco_collides_with(robot):
    """Rays meet the drawn shapes where they meet MuJoCo's, in the same posture."""
    shown = picture(robot, {"collision"})
    drawn, frames, motion = DrawnOverlay(shown, "/hulls"), shown.solid, shown.planned.motion
    model = build_scene(load_robot(robot), Surroundings(-9.0, ()), Disturbance(), 1e-3).model
    data = mujoco.MjData(model)
    frame = 50
    order = [motion.robot.joint_names.index(n) for n in joints_in_model_order(motion.robot)]
    data.qpos[:] = np.concatenate([motion.qpos[frame, :7], motion.joint_position[frame, order]])
    mujoco.mj_forward(model, data)
    meshes = []
    for node in drawn.nodes:
        mesh = drawn.mesh(node).copy()
        mesh.vertices = drawn.vertices(node, frame)
        meshes.append(mesh)
    low = np.min([mesh.bounds[0] for mesh in meshes], axis=0)
    high = np.max([mesh.bounds[1] for mesh in meshes], axis=0)
    rng = np.random.default_rng(1)
    met = grazed = 0
    for _ in range(150):
        start = np.append(rng.uniform(low[:2], high[:2]), low[2] - 1.0)
        ray, geom = np.array([0.0, 0.0, 1.0]), np.zeros(1, dtype=np.int32)
        expected = mujoco.mj_ray(model, data, start, ray, None, 1, -1, geom)
        hits = [
            hit[2] - start[2]
            for mesh in meshes
            for hit in mesh.ray.intersects_location([start], [ray])[0]
        ]
        if expected < 0 and not hits:
            continue
        if expected < 0 or not hits:
            # Spheres and cylinders are drawn with flat faces; a ray may graze them.
            grazed += 1
            continue
        met += 1
        assert min(hits) == pytest.approx(expected, abs=0.01)
    assert met > 15
    assert grazed <= 3
    assert len(frames.time) > frame


@pytest.mark.parametrize(("robot", "spheres"), [("anymal", 1), ("slider", 4)])
def test_every_foot_has_its_spheres(robot, spheres):
    loaded = load_robot(robot)
    shapes = dict(shapes_of(loaded))
    for leg, contact in zip(loaded.legs, foot_contacts(loaded), strict=True):
        parts = shapes[leg.joint_ids[-1] - 1].split()
        balls = [p for p in parts if np.allclose(p.extents, 2 * contact.radius, rtol=0.02)]
        assert len(balls) == spheres
