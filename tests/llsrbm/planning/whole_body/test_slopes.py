"""Plans from and onto slopes, by forward kinematics, on both sides of turned worlds, followed."""

import math
from functools import cache

import numpy as np
import pinocchio as pin
import pytest

import llsrbm
from llsrbm.mechanics import rotation_matrices
from llsrbm.motion.grounds import foot_normals
from llsrbm.motion.surroundings import surroundings
from llsrbm.request.scenario import Scenario
from llsrbm.robots import load_robot
from llsrbm.robots.feet import foot_contacts

SLOPE = math.radians(12)
JUMPS = {
    "onto": {"robot": "go2", "forward": 0.25, "slope": SLOPE, "cross_slope": -0.1},
    "from": {"robot": "go2", "forward": 0.2, "takeoff_slope": -SLOPE},
    "soles": {"robot": "slider", "forward": 0.25, "slope": -SLOPE, "cross_slope": 0.1},
    # The frames of its feet are not in the middles of their balls.
    "frames": {"robot": "anymal", "forward": 0.2, "slope": 0.1},
}
NIGHTLY = [pytest.param(name, marks=pytest.mark.nightly) for name in ("from", "soles", "frames")]
ON_IT = 1e-3  # m


@cache
def plan(name):
    return llsrbm.plan(llsrbm.Jump(**JUMPS[name]))


def balls(found, robot, knot):
    """(L, c, 3) m: middles of the feet's balls, by Pinocchio."""
    order = [found.joint_names.index(name) for name in robot.joint_names]
    q = np.concatenate(
        [
            found.base_position[knot],
            np.roll(found.base_quat[knot], -1),
            found.joint_position[knot][order],
        ]
    )
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, q)
    return np.array(
        [
            [data.oMf[leg.foot_frame_id].act(centre) for centre in contact.centres]
            for leg, contact in zip(robot.legs, foot_contacts(robot), strict=True)
        ]
    )


@pytest.mark.parametrize("name", ["onto", *NIGHTLY])
def test_balls_touch_the_surface_and_stay_above_it(name):
    found = plan(name)
    assert found.certified
    robot = load_robot(found.jump.robot)
    normals = foot_normals(found, found.time)
    radius = foot_contacts(robot)[0].radius
    # Through where the feet stand at the start and at the end.
    surface = {knot: found.contact_point[knot].mean(axis=0) for knot in (0, -1)}
    for knot in range(len(found.time)):
        end = 0 if found.time[knot] < (found.lift_off + found.touchdown) / 2 else -1
        off = (balls(found, robot, knot) - surface[end]) @ normals[knot, 0] - radius
        if 0 < found.phase[knot] < len(found.schedule) - 1:
            continue
        assert np.abs(off).max() < ON_IT, knot


@pytest.mark.parametrize("name", ["onto", *NIGHTLY])
def test_forces_act_where_standing_feet_touch(name):
    found = plan(name)
    robot = load_robot(found.jump.robot)
    normals, radius = foot_normals(found, found.time), foot_contacts(robot)[0].radius
    for knot in (0, len(found.time) // 4, -2, -1):
        touching = balls(found, robot, knot) - radius * normals[knot][:, None]
        stated = found.contact_point[knot].reshape(touching.shape)
        np.testing.assert_allclose(stated, touching, atol=ON_IT)


@pytest.mark.parametrize("name", ["onto", *NIGHTLY])
def test_forces_are_in_the_cone_of_the_surface(name):
    found = plan(name)
    legs = found.foot_position.shape[1]
    force = found.contact_force.reshape(len(found.time), legs, -1, 3)
    normal = foot_normals(found, found.time + 1e-6)[:, :, None]
    up = (force * normal).sum(axis=-1)
    across = np.linalg.norm(force - up[..., None] * normal, axis=-1)
    assert (across <= found.friction * up + 1e-3).all()
    assert found.certificate["friction"]["holds"]


@pytest.mark.parametrize("name", ["onto", *NIGHTLY])
def test_the_robot_stands_level_to_it_and_on_soles_upright(name):
    found = plan(name)
    normal = foot_normals(found, found.time[-1:])[0, 0]
    up = rotation_matrices(found.base_quat[-1])[:, 2]
    upright = np.array([0.0, 0.0, 1.0])
    np.testing.assert_allclose(up, upright if name == "soles" else normal, atol=1e-3)


@pytest.mark.parametrize("name", ["onto", *NIGHTLY])
def test_it_is_followed(name):
    rollout = llsrbm.simulate(plan(name), seed=5)
    assert rollout.outcome.strict


def test_a_block_slopes_under_the_feet():
    found = plan("onto")
    robot = load_robot("go2")
    blocks = {block.name: block for block in surroundings(robot, found, Scenario()).blocks}
    box = blocks["box"]
    normal = foot_normals(found, found.time[-1:])[0, 0]
    np.testing.assert_allclose(box.rotation[:, 2], normal, atol=1e-9)
    seen = (found.contact_point[-1] - box.centre) @ box.rotation
    np.testing.assert_allclose(seen[:, 2], box.size[2] / 2, atol=ON_IT)
    assert (np.abs(seen[:, :2]) < box.size[:2] / 2).all()


def test_the_mirrored_slope_is_the_mirrored_plan():
    one, other = (
        llsrbm.plan(
            llsrbm.Jump(robot="slider", forward=0.2, cross_slope=cross, lateral=side),
            draft=True,
        )
        for cross, side in ((0.15, 0.1), (-0.15, -0.1))
    )
    np.testing.assert_allclose(one.com * [1, -1, 1], other.com, atol=2e-3)


def test_its_file_has_it(tmp_path):
    plan("onto").save(tmp_path / "plan.npz")
    assert llsrbm.load(tmp_path / "plan.npz").jump == plan("onto").jump
