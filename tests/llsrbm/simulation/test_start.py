"""The whole robot where the plan starts."""

import dataclasses

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from llsrbm.errors import InputError
from llsrbm.motion.rollout import Disturbance
from llsrbm.motion.surroundings import Surroundings
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot
from llsrbm.robots.feet import foot_contacts
from llsrbm.simulation.scene import build_scene, foot_geoms
from llsrbm.simulation.simulate import standing_state, starting_velocity
from tests.app.synthetic_plan import synthetic_plan
from tests.llsrbm.formats.jumps import planned
from tests.llsrbm.simulation.sliding_biped import sliding_biped


@pytest.fixture(params=["anymal", "sliding"])
def robot(request, tmp_path):
    if request.param == "sliding":
        return sliding_biped(tmp_path)
    return load_robot(request.param)


def plan_of(robot):
    name = robot.name if robot.name == "anymal" else str(robot.path)
    return synthetic_plan(Jump(robot=name))


def test_com_attitude_and_feet_are_the_plans(robot):
    plan = plan_of(robot)
    q = standing_state(robot, plan)
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, q)
    assert pin.centerOfMass(robot.model, data, q) == pytest.approx(plan.com[0], abs=1e-7)
    assert np.roll(q[3:7], 1) == pytest.approx(plan.base_quat[0], abs=1e-8)
    for i, (leg, contact) in enumerate(zip(robot.legs, foot_contacts(robot), strict=True)):
        centre = data.oMf[leg.foot_frame_id].act(contact.centres[0])
        resting = plan.foot_position[0, i] + [0, 0, contact.radius]
        assert centre == pytest.approx(resting, abs=1e-7)
    lower, upper = robot.model.lowerPositionLimit[7:], robot.model.upperPositionLimit[7:]
    assert (q[7:] >= lower).all()
    assert (q[7:] <= upper).all()


@pytest.mark.parametrize(("name", "off"), [("go2", 1e-4), ("anymal", 8e-3), ("slider", 1e-4)])
def test_mujocos_feet_touch_what_a_plan_stands_on(name, off):
    """In every posture of a jump: a ball's lowest point at the planned surface.

    ANYmal's balls are beside their frames, so their heights change a little as the legs bend.
    """
    robot = load_robot(name)
    plan = planned(name)
    assert plan.foot_position[0, :, 2] == pytest.approx(0.0, abs=1e-9)
    assert plan.foot_position[-1, :, 2] == pytest.approx(plan.jump.height, abs=1e-6)
    scene = build_scene(robot, Surroundings(0.0, ()), Disturbance(), 1e-3)
    data = mujoco.MjData(scene.model)
    joints = plan.joint_position[:, [plan.joint_names.index(n) for n in robot.joint_names]]
    postures = np.hstack([plan.base_position, np.roll(plan.base_quat, -1, axis=1), joints])
    gaps = np.zeros(plan.contact.shape)
    for k, q in enumerate(postures):
        data.qpos[scene.q_order] = q
        mujoco.mj_kinematics(scene.model, data)
        for leg, names in enumerate(foot_geoms(robot)):
            ids = [scene.model.geom(geom).id for geom in names]
            lowest = data.geom_xpos[ids, 2] - scene.model.geom_size[ids, 0]
            gaps[k, leg] = np.abs(lowest - plan.foot_position[k, leg, 2]).max()
    assert gaps[[0, -1]].max() < 1e-3
    stands = plan.contact.copy()
    stands[1:] |= plan.contact[:-1]
    assert gaps[stands].max() < off


def test_what_cannot_stand_is_refused():
    robot = load_robot("anymal")
    plan = plan_of(robot)
    high = dataclasses.replace(plan, com=plan.com + np.array([0, 0, 0.4]))
    with pytest.raises(InputError, match=r"plan: ANYmal B cannot stand as its first knot says"):
        standing_state(robot, high)


def test_a_plan_of_another_robot_is_refused(tmp_path):
    plan = plan_of(sliding_biped(tmp_path))
    with pytest.raises(InputError, match=r"plan: it has joints .*_slide.* a plan of ANYmal B: LF_"):
        standing_state(load_robot("anymal"), plan)


@pytest.mark.parametrize("name", ["anymal", "slider"])
def test_a_run_up_moves_com_and_base_over_feet_at_rest(name):
    robot = load_robot(name)
    plan = synthetic_plan(Jump(robot=name, speed=0.5))
    moving = plan.com_velocity.copy()
    moving[0] = [0.5, 0.0, 0.1]
    plan = dataclasses.replace(plan, com_velocity=moving)
    q = standing_state(robot, plan)
    v = starting_velocity(robot, plan, q)
    model, data = robot.model, robot.model.createData()
    pin.centerOfMass(model, data, q, v)
    pin.forwardKinematics(model, data, q, v)
    assert data.vcom[0] == pytest.approx(moving[0], abs=1e-6)
    assert v[3:6] == pytest.approx(0.0, abs=1e-6)
    for leg, contact in zip(robot.legs, foot_contacts(robot), strict=True):
        frame = pin.updateFramePlacement(model, data, leg.foot_frame_id)
        twist = pin.getFrameVelocity(
            model, data, leg.foot_frame_id, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        )
        for centre in contact.centres:
            lowest = frame.rotation @ centre - [0, 0, contact.radius]
            at_the_ground = twist.linear + np.cross(twist.angular, lowest)
            assert at_the_ground == pytest.approx(0.0, abs=1e-6)


def test_a_speed_that_legs_do_not_allow_is_refused(tmp_path):
    """Legs that swing fore and aft alone: no speed sideways with the feet at rest."""
    robot = sliding_biped(tmp_path)
    plan = synthetic_plan(Jump(robot=str(robot.path), speed=0.5))
    sideways = dataclasses.replace(plan, com_velocity=np.tile([0, 0.5, 0], (len(plan.time), 1)))
    with pytest.raises(InputError, match=r"plan: Sliding biped cannot move as its first knot says"):
        starting_velocity(robot, sideways, standing_state(robot, plan))
