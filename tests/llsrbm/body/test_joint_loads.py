"""Loads of joints against statics, against differences of postures, and against energy."""

from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial.transform import Rotation

from llsrbm.body.joint_loads import joint_loads
from llsrbm.body.knot_motion import KnotMotion
from llsrbm.body.postures import solve_postures
from llsrbm.request.schedule import together
from llsrbm.robots import load_robot
from tests.llsrbm.formats.jumps import planned as shipped
from tests.llsrbm.planning.solved import solved

ROBOTS = ("anymal", "slider")
WEIGHT = np.array([0.0, 0.0, 9.81])


def standing(robot: Any, time: np.ndarray, com: np.ndarray, quat: np.ndarray) -> KnotMotion:
    """The feet where they are in the default posture; each contact carries the same."""
    knots = len(time)
    headings = robot.foot_yaw if robot.foot_coordinates > 3 else 0 * robot.feet[:, 0]
    yaw = Rotation.from_euler("z", headings[:, None]).as_quat(scalar_first=True)
    turned = Rotation.from_quat(yaw, scalar_first=True).as_matrix()
    points = (robot.feet[:, None] + np.einsum("lij,cj->lci", turned, robot.corners)).reshape(-1, 3)
    force = np.tile(robot.mass * WEIGHT / len(points), (knots, len(points), 1))
    return KnotMotion(
        time=time,
        schedule=together(tuple(leg.name for leg in robot.legs)),
        phase=np.zeros(knots, dtype=np.int64),
        com=com,
        com_velocity=np.gradient(com, time, axis=0),
        base_quat=quat,
        foot_position=np.tile(robot.feet, (knots, 1, 1)),
        foot_quat=np.tile(yaw, (knots, 1, 1)),
        contact_point=np.tile(points, (knots, 1, 1)),
        contact_force=force,
    )


def generalised_force(robot: Any, q: np.ndarray, points: np.ndarray, force: np.ndarray) -> Any:
    """J^T f (nv,) of forces (C, 3) at world points (C, 3) on the feet, by Pinocchio's Jacobians."""
    data = robot.model.createData()
    pin.computeJointJacobians(robot.model, data, q)
    pin.updateFramePlacements(robot.model, data)
    total = np.zeros(robot.model.nv)
    per_leg = len(points) // len(robot.legs)
    for i, (point, f) in enumerate(zip(points, force, strict=True)):
        frame = robot.legs[i // per_leg].foot_frame_id
        J = pin.getFrameJacobian(robot.model, data, frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
        arm = point - data.oMf[frame].translation
        total += J[:3].T @ f + J[3:].T @ np.cross(arm, f)
    return total


def friction(robot: Any, speed: np.ndarray) -> Any:
    """Nm or N that the drives lose at joint speeds."""
    coulomb = robot.friction * np.tanh(100 * speed / robot.speed_limit)
    return coulomb + robot.damping * speed


@pytest.fixture(scope="module", params=ROBOTS)
def robot(request):
    return load_robot(request.param)


def test_at_rest_the_joints_carry_the_weight(robot):
    time = np.linspace(0.0, 0.3, 5)
    motion = standing(robot, time, np.tile(robot.com, (5, 1)), np.tile([1.0, 0, 0, 0], (5, 1)))
    loads = joint_loads(robot, motion)
    np.testing.assert_allclose(loads.joint_velocity, 0.0, atol=1e-9)
    np.testing.assert_allclose(loads.joint_position, loads.joint_position[[0] * 4], atol=1e-9)
    q = robot.posture
    contacts = generalised_force(robot, q, motion.contact_point[0], motion.contact_force[0])
    expected = pin.computeGeneralizedGravity(robot.model, robot.model.createData(), q) - contacts
    np.testing.assert_allclose(loads.joint_torque[2], expected[6:], atol=1e-5)
    # The moment is about the base's origin, in whose axes the robot stands level.
    np.testing.assert_allclose(loads.base_residual[2], expected[:6], atol=1e-5)


def test_a_smooth_motion_against_differences_of_postures(robot):
    """Inverse dynamics of the floating base in the world, its motion by differences alone."""
    scale = 0.1 * robot.feet[:, 2].min() + 0.05
    period = 0.5

    def com(t):
        s = (1 - np.cos(2 * np.pi * t / period))[:, None] / 2
        return robot.com + scale * s * [0.5, 0.4, -1.0]

    def attitude(t):
        s = (1 - np.cos(2 * np.pi * t / period))[:, None] / 2
        return Rotation.from_rotvec(s * [0.08, -0.1, 0.2])

    time = np.linspace(0.0, period, 65)
    motion = standing(robot, time, com(time), attitude(time).as_quat(scalar_first=True))
    rate = np.pi / period * np.sin(2 * np.pi * time / period)[:, None]
    motion = replace(motion, com_velocity=scale * rate * [0.5, 0.4, -1.0])
    rng = np.random.default_rng(3)
    force = motion.contact_force + rng.normal(scale=10.0, size=motion.contact_force.shape)
    loads = joint_loads(robot, replace(motion, contact_force=force))

    model, data, h = robot.model, robot.model.createData(), 1e-3

    def posture(t):
        one, turn = np.array([t]), attitude(np.array([t]))
        at = solve_postures(
            robot,
            com(one),
            turn.as_quat(scalar_first=True),
            motion.foot_position[:1],
            motion.foot_quat[:1],
        )
        return np.concatenate([at.base_position[0], turn.as_quat()[0], at.joint_position[0]])

    for k in (5, 20, 40, 58):
        before, now, after = (posture(loads.time[k] + step) for step in (-h, 0.0, h))
        v_before, v_after = pin.difference(model, before, now), pin.difference(model, now, after)
        v, a = (v_before + v_after) / (2 * h), (v_after - v_before) / h**2
        contacts = generalised_force(robot, now, motion.contact_point[k], force[k])
        expected = pin.rnea(model, data, now, v, a) - contacts
        expected[6:] += friction(robot, v[6:])
        size = np.abs(expected[6:]).max()
        np.testing.assert_allclose(loads.joint_velocity[k], v[6:], rtol=2e-3, atol=3e-3)
        np.testing.assert_allclose(loads.joint_torque[k], expected[6:], atol=0.01 * size)
        np.testing.assert_allclose(loads.base_residual[k], expected[:6], atol=0.01 * size)


@pytest.fixture(scope="module", params=["anymal", "slider", "hops"])
def planned(request):
    hops = request.param == "hops"
    plan = solved("llsrbm-plus", "hops").plan if hops else shipped(request.param)
    robot = load_robot(plan.jump.robot)
    return plan, robot, joint_loads(robot, KnotMotion.of_plan(plan))


def test_a_plans_dynamics_are_nearly_those_of_the_whole_body(planned):
    """Most is missing where the legs begin and end to swing."""
    _, robot, loads = planned
    force, moment = np.sqrt((loads.base_residual.reshape(-1, 2, 3) ** 2).sum(axis=2).mean(axis=0))
    assert force < 1e-3
    assert moment < 0.05 * robot.mass * 9.81 * robot.com[2]
    assert loads.foot_residual.max() < 1e-6


def test_what_the_drives_give_is_the_gain_in_energy_and_what_friction_takes(planned):
    """At rest at both ends: only the height counts. Contacts at rest do no work."""
    plan, robot, loads = planned
    power = (loads.joint_torque * loads.joint_velocity).sum(axis=1)
    dt = np.diff(plan.time)
    gain = robot.mass * 9.81 * (plan.com[-1, 2] - plan.com[0, 2])
    speed = loads.joint_velocity
    lost = (friction(robot, speed) * speed).sum(axis=1) @ dt
    assert lost > 0.01 * np.abs(power) @ dt
    assert power @ dt == pytest.approx(gain + lost, abs=0.02 * np.abs(power) @ dt)


def test_speeds_at_the_knots_are_those_of_the_postures(planned):
    """Differences of the plan's own postures, within the phases."""
    plan, robot, loads = planned
    np.testing.assert_allclose(loads.knot_velocity[[0, -1]], 0.0, atol=1e-5)  # as it is solved
    inside = np.flatnonzero(plan.phase[2:] == plan.phase[:-2]) + 1
    step = (plan.time[inside + 1] - plan.time[inside - 1])[:, None]
    speed = (plan.joint_position[inside + 1] - plan.joint_position[inside - 1]) / step
    error = np.abs(loads.knot_velocity[inside] - speed) / robot.speed_limit
    assert error.max() < 0.06
    # In the middle of an interval the speed is that between its knots.
    speed = np.diff(plan.joint_position, axis=0) / np.diff(plan.time)[:, None]
    assert (np.abs(loads.joint_velocity - speed) / robot.speed_limit).max() < 0.06


def test_a_plan_holds_its_loads(planned):
    """Torques and limits over the interval that begins at the knot; the last stands."""
    plan, robot, loads = planned
    np.testing.assert_allclose(plan.joint_torque[:-1], loads.joint_torque, atol=1e-9)
    np.testing.assert_allclose(plan.joint_torque_limit[:-1], loads.torque_available, atol=1e-9)
    np.testing.assert_allclose(plan.joint_velocity, loads.knot_velocity, atol=1e-9)
    np.testing.assert_allclose(plan.joint_torque[-1], loads.standing_torque, atol=1e-9)
    np.testing.assert_array_equal(plan.joint_torque_limit[-1], robot.torque_limit)


def test_nonsense_does_not_raise(planned):
    """A solver that failed leaves anything."""
    plan, robot, _ = planned
    time = plan.time.copy()
    time[3] = time[2]
    loads = joint_loads(robot, replace(KnotMotion.of_plan(plan), time=time))
    assert loads.joint_torque.shape == (len(time) - 1, len(robot.joint_names))
