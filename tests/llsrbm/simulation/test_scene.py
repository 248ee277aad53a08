"""The MuJoCo model against Pinocchio's: masses, mass matrix, accelerations, what collides."""

import itertools

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from llsrbm.errors import RobotFileError
from llsrbm.motion.block import Block
from llsrbm.motion.rollout import Disturbance
from llsrbm.motion.surroundings import Surroundings
from llsrbm.robots import load_robot
from llsrbm.robots.link_shapes import LinkShapes
from llsrbm.simulation.scene import build_scene
from tests.llsrbm.simulation.sliding_biped import URDF, sliding_biped

GROUND = Surroundings(ground=0.0, blocks=())


@pytest.fixture(params=["anymal", "slider", "g1"])
def robot(request):
    return load_robot(request.param)


def scene_of(robot, **disturbance):
    return build_scene(robot, GROUND, Disturbance(**disturbance), 5e-4)


def random_states(robot, count=20):
    """Postures anywhere in the air, and velocities, in Pinocchio's conventions."""
    rng = np.random.default_rng(4)
    for _ in range(count):
        q = pin.integrate(robot.model, robot.posture, rng.normal(scale=0.7, size=robot.model.nv))
        q[2] += 20.0
        yield q, rng.normal(scale=2.0, size=robot.model.nv), rng


def in_mujoco(scene, q, v):
    """Data at a state, `turn` with v_mujoco = turn v_pinocchio, and R_world_base."""
    data = mujoco.MjData(scene.model)
    R = pin.Quaternion(q[3:7]).toRotationMatrix()
    turn = np.zeros((len(v), len(v)))
    turn[:3, :3] = R
    for index in range(3, len(v)):
        turn[scene.v_order[index], index] = 1
    data.qpos[scene.q_order] = q
    data.qvel[:] = turn @ v
    return data, turn, R


def test_joints_are_in_the_places_that_their_names_say(robot):
    scene = scene_of(robot)
    assert scene.q_order[:7].tolist() == [0, 1, 2, 4, 5, 6, 3]
    assert scene.v_order[:6].tolist() == list(range(6))
    for index, name in enumerate(robot.joint_names):
        assert scene.model.joint(name).qposadr[0] == scene.q_order[7 + index]
        assert scene.model.joint(name).dofadr[0] == scene.v_order[6 + index]
        assert scene.model.actuator_trnid[index, 0] == scene.model.joint(name).id
    assert scene.model.nu == len(robot.joint_names)


def test_accelerations(robot):
    """Forward dynamics with torques, rotors, damping and gravity, without constraints."""
    scene, data = scene_of(robot), robot.model.createData()
    scene.model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
    joints = len(robot.joint_names)
    for q, v, rng in random_states(robot):
        torque = rng.normal(scale=20, size=joints)
        simulated, turn, R = in_mujoco(scene, q, v)
        simulated.ctrl[:] = torque
        mujoco.mj_forward(scene.model, simulated)
        torque -= robot.damping * v[6:]  # Coulomb friction is a constraint
        expected = pin.aba(robot.model, data, q, v, np.concatenate([np.zeros(6), torque]))
        in_world = turn @ expected
        # Pinocchio's is the spatial acceleration, MuJoCo's that of the base's origin.
        in_world[:3] += R @ np.cross(v[3:6], v[:3])
        assert simulated.qacc == pytest.approx(in_world, abs=1e-9 * np.abs(expected).max())


def test_mass_matrix(robot):
    factor = 1.08
    scene = scene_of(robot, trunk_mass_factor=factor)
    model = robot.model.copy()
    trunk = model.inertias[1]
    model.inertias[1] = pin.Inertia(factor * trunk.mass, trunk.lever, factor * trunk.inertia)
    data = model.createData()
    for q, v, _ in random_states(robot, 5):
        simulated, turn, _ = in_mujoco(scene, q, v)
        mujoco.mj_forward(scene.model, simulated)
        M = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(scene.model, simulated, M)
        believed = pin.crba(model, data, q)
        believed = np.triu(believed) + np.triu(believed, 1).T
        assert turn.T @ M @ turn == pytest.approx(believed, abs=1e-9)


def test_links_meet_the_world_and_each_other_by_stated_pairs_alone(robot):
    scene, links = scene_of(robot), LinkShapes.of(robot)
    model = scene.model
    names = [model.geom(g).name for g in range(model.ngeom)]
    assert {name.split("/")[0] for name in names} == {"world", "foot", "link"}
    of_feet = {f"link/{s.link}/{k}" for k, s in enumerate(links.shapes) if s.foot}
    for a, first in enumerate(names):
        for b, second in enumerate(names):
            meet = bool(
                model.geom_contype[a] & model.geom_conaffinity[b]
                or model.geom_contype[b] & model.geom_conaffinity[a]
            )
            one_of_the_world = first.startswith("world/") != second.startswith("world/")
            assert meet == (one_of_the_world and not of_feet & {first, second})
    stated = {
        frozenset((names[a].split("/")[1], names[b].split("/")[1]))
        for a, b in zip(model.pair_geom1, model.pair_geom2, strict=True)
    }
    assert stated == {frozenset(pair) for pair in links.pairs}


def test_shapes_are_where_the_links_are(robot):
    """The distances of MuJoCo's geoms of pairs are those by coal."""
    scene, links = scene_of(robot), LinkShapes.of(robot)
    names = [f"link/{shape.link}/{k}" for k, shape in enumerate(links.shapes)]
    for q, v, _ in itertools.islice(random_states(robot), 4):
        data, _, _ = in_mujoco(scene, q, v)
        mujoco.mj_forward(scene.model, data)
        found = np.full(len(links.pairs), np.inf)
        for (one, other), pair in zip(links.shape_pairs, links.pair_of, strict=True):
            a, b = (scene.model.geom(names[k]).id for k in (one, other))
            apart = mujoco.mj_geomDistance(scene.model, data, a, b, 1.0, np.zeros(6))
            found[pair] = min(found[pair], apart)
        expected = links.distances(q)
        near = (expected > 1e-3) & (expected < 0.5)
        assert found[near] == pytest.approx(expected[near], abs=1e-4)


def test_friction_and_stiffness_are_the_disturbances(robot):
    model = scene_of(robot, friction=0.55, contact_time=0.017).model
    assert model.geom_friction[:, 0] == pytest.approx(0.55)
    assert model.geom_solref[:, 0] == pytest.approx(0.017)


def test_joints_have_the_drives_of_the_robots_file_as_disturbed(robot):
    model = scene_of(robot, armature_factor=1.1, joint_friction_factor=2.0).model
    dofs = [model.joint(name).dofadr[0] for name in robot.joint_names]
    assert (robot.armature > 0).all()
    assert model.dof_armature[dofs] == pytest.approx(1.1 * robot.armature)
    assert model.dof_frictionloss[dofs] == pytest.approx(2 * robot.friction)
    assert model.dof_damping[dofs] == pytest.approx(2 * robot.damping)
    of_base = np.delete(model.dof_armature, dofs)
    assert of_base == pytest.approx(0)


def test_blocks_come_and_go():
    blocks = (
        Block("board", np.array([1.0, 2, 0.01]), np.array([2.0, 1, 0.02]), 0.3, from_s=0.5),
        Block("block", np.array([0.0, 0, -0.1]), np.array([1.0, 1, 0.2]), 0.0, until_s=0.5),
    )
    scene = build_scene(
        load_robot("anymal"), Surroundings(ground=-0.2, blocks=blocks), Disturbance(), 5e-4
    )
    data = mujoco.MjData(scene.model)
    for time, board, block in ((0.0, False, True), (0.4999, False, True), (0.5, True, False)):
        scene.move_blocks(data, time)
        mujoco.mj_forward(scene.model, data)
        for stands, body in ((board, blocks[0]), (block, blocks[1])):
            geom = data.geom(f"world/{body.name}")
            if stands:
                assert geom.xpos == pytest.approx(body.centre)
                c, s = np.cos(body.yaw), np.sin(body.yaw)
                R = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
                assert geom.xmat.reshape(3, 3) == pytest.approx(R)
                assert 2 * scene.model.geom(geom.id).size == pytest.approx(body.size)
            else:
                assert geom.xpos[2] < -10
    assert data.geom("world/ground").xpos[2] == -0.2


def test_a_base_without_primitives_is_refused(tmp_path):
    box = '<geometry><box size="0.2 0.3 0.2"/></geometry>'
    shape = f'<collision><origin xyz="0 0 0.1"/>{box}</collision>'
    assert shape in URDF
    robot = sliding_biped(tmp_path, URDF.replace(shape, ""))
    with pytest.raises(RobotFileError, match=r"sliding\.toml: urdf: the base of .* has no collis"):
        scene_of(robot)
