import numpy as np
import pytest

from llsrbm.control import tasks
from llsrbm.control.whole_body import WholeBody
from llsrbm.robots import load_robot
from tests.llsrbm.control.bodies import ROBOTS, moved, resting_target

DT = 1e-4
SEED = 5
ALL = {
    "com": tasks.CentreOfMass((0.0, 0.0)),
    "orientation": tasks.BaseOrientation((0.0, 0.0)),
    "swing": tasks.SwingFeet([2], (0.0, 0.0)),
    "seeking": tasks.SeekingFeet([1], 0.5, 0.0),
    "standing": tasks.StandingFeet([3], 1, 0.0),
    "momentum": tasks.AngularMomentum(0.0),
    "posture": tasks.Posture(range(12), 18, (0.0, 0.0)),
}
SECOND_ORDER = ("com", "posture")
WITH_RATES = ("com", "orientation", "posture", "seeking")


def _acceleration():
    return 3.0 * np.random.default_rng(1).standard_normal(18)


@pytest.mark.parametrize("name", SECOND_ORDER)
def test_error_falls_at_the_error_rate(name):
    task, target, still = ALL[name], resting_target(), np.zeros(18)
    before, after = (task.motion(moved(SEED, still, dt), target).error for dt in (-DT, DT))
    rate = task.motion(moved(SEED, still, 0.0), target).error_rate
    np.testing.assert_allclose((after - before) / (2 * DT), rate, atol=1e-5)


@pytest.mark.parametrize("name", WITH_RATES)
def test_jacobian_and_bias_give_the_acceleration(name):
    task, target, a = ALL[name], resting_target(), _acceleration()
    before, after = (task.motion(moved(SEED, a, dt), target).error_rate for dt in (-DT, DT))
    now = task.motion(moved(SEED, a, 0.0), target)
    np.testing.assert_allclose(
        now.jacobian @ a + now.bias, -(after - before) / (2 * DT), rtol=1e-5, atol=1e-4
    )


@pytest.mark.parametrize("name", ROBOTS)
def test_angular_momentum_changes_as_jacobian_and_bias_say(name):
    """By differences of the momentum about the CoM; both are per inertia, which is now's."""
    robot = load_robot(name)
    a = 3.0 * np.random.default_rng(1).standard_normal(robot.model.nv)
    now = moved(SEED, a, 0.0, name)
    target = resting_target(len(robot.legs), len(robot.joint_names))._replace(
        angular_momentum=np.array([1.0, -2.0, 3.0]),
        angular_momentum_rate=np.array([5.0, 4.0, -6.0]),
    )
    motion = tasks.AngularMomentum(0.0).motion(now, target)
    before, after = (moved(SEED, a, dt, name).angular_momentum for dt in (-DT, DT))
    change = now.inertia @ (motion.jacobian @ a + motion.bias)
    np.testing.assert_allclose(change, (after - before) / (2 * DT), rtol=1e-5, atol=1e-4)
    missing = target.angular_momentum - now.angular_momentum
    np.testing.assert_allclose(now.inertia @ motion.error_rate, missing, atol=1e-9)
    np.testing.assert_allclose(now.inertia @ motion.feedforward, [5.0, 4.0, -6.0], atol=1e-9)


def test_foot_orientation_follows_from_its_jacobian():
    task, target, a = tasks.FootOrientation(1, (0.0, 0.0)), resting_target(2), _acceleration()
    before, after = (
        task.motion(moved(SEED, a, dt, "slider"), target).error_rate for dt in (-DT, DT)
    )
    now = task.motion(moved(SEED, a, 0.0, "slider"), target)
    np.testing.assert_allclose(
        now.jacobian @ a + now.bias, -(after - before) / (2 * DT), rtol=1e-5, atol=1e-3
    )


def test_foot_orientation_wants_a_level_sole_with_the_plans_heading():
    heading = 0.4
    target = resting_target(2)._replace(foot_heading=np.array([[heading, 0.5, 2.0]] * 2))
    robot = load_robot("slider")
    body = WholeBody(robot)
    body.update(robot.posture, np.zeros(robot.model.nv))
    motion = tasks.FootOrientation(0, (0.0, 0.0)).motion(body, target)
    np.testing.assert_allclose(motion.error, [0, 0, heading], atol=1e-6)
    np.testing.assert_allclose(motion.error_rate, [0, 0, 0.5], atol=1e-9)
    np.testing.assert_allclose(motion.feedforward, [0, 0, 2.0])


@pytest.mark.parametrize("feet", [[0, 1, 2, 3], [1, 2], [0, 3]])
@pytest.mark.parametrize(
    "task",
    [
        lambda feet: tasks.SwingFeet(feet, (500.0, 40.0)),
        lambda feet: tasks.SeekingFeet(feet, 0.5, 40.0),
        lambda feet: tasks.StandingFeet(feet, 1, 20.0),
    ],
)
def test_several_feet_are_those_feet_one_after_the_other(task, feet):
    body, target = moved(SEED, np.zeros(18), 0.0), resting_target()

    def written(feet):
        jacobian, command = np.empty((3 * len(feet), 18)), np.empty(3 * len(feet))
        task(feet).write(body, target, jacobian, command)
        return np.column_stack([jacobian, command])

    np.testing.assert_allclose(written(feet), np.vstack([written([i]) for i in feet]))


@pytest.mark.parametrize("seed", range(3))
def test_swing_foot_is_measured_from_the_com(seed):
    """Its Jacobian is the foot's own; the task adds the CoM's acceleration, the target's."""
    falling = np.array([0.5, 0.0, -9.81])
    target = resting_target()._replace(com_acceleration=falling)
    body = moved(seed, np.zeros(18), 0.0)
    motion = ALL["swing"].motion(body, target)
    np.testing.assert_allclose(motion.error, body.com - body.foot[2], atol=1e-12)
    np.testing.assert_allclose(motion.error_rate, body.com_velocity - body.foot_velocity[2])
    np.testing.assert_allclose(motion.feedforward, falling)


def test_orientation_error_is_the_turn_that_is_missing():
    target = resting_target()
    body = moved(SEED, np.zeros(18), 0.0)
    error = ALL["orientation"].motion(body, target).error
    angle = np.linalg.norm(error)
    axis = error / angle
    # Rodrigues: turning the base by the error brings it to the target, the identity.
    K = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    turn = np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K
    np.testing.assert_allclose(turn @ body.R_world_base, np.eye(3), atol=1e-9)


def test_standing_foot_rolls():
    """The wanted motion of a standing foot is that of a sphere on a floor, not of a fixed point."""
    body = moved(SEED, np.zeros(18), 0.0)
    motion = ALL["standing"].motion(body, resting_target())
    a = np.linalg.lstsq(motion.jacobian, -motion.bias, rcond=None)[0]
    dt = 1e-4
    # v_touching = v_centre + omega x (-r z) stays constant.
    np.testing.assert_allclose(
        moved(SEED, a, dt).contact_velocity[3], moved(SEED, a, -dt).contact_velocity[3], atol=2e-6
    )


def test_command_adds_feedback():
    task, target, body = (
        tasks.CentreOfMass((60.0, 12.0)),
        resting_target(),
        moved(2, np.zeros(18), 0),
    )
    jacobian, command = np.empty((3, 18)), np.empty(3)
    task.write(body, target, jacobian, command)
    wanted = -60.0 * body.com - 12.0 * body.com_velocity - body.momentum_bias[:3] / body.mass
    np.testing.assert_allclose(command, wanted)


def test_arms_swing_as_planned_and_other_joints_only_come_back():
    joints = range(3, 6)
    wanted = resting_target()._replace(joint_acceleration=np.arange(12.0))
    now = moved(SEED, np.zeros(18), 0.0)
    arms, others = (kind(joints, 18, (9.0, 6.0)) for kind in (tasks.Arms, tasks.Posture))
    np.testing.assert_allclose(arms.motion(now, wanted).feedforward, [3.0, 4.0, 5.0])
    np.testing.assert_allclose(others.motion(now, wanted).feedforward, 0.0)
    np.testing.assert_allclose(arms.motion(now, wanted).jacobian, np.eye(18)[9:12])
