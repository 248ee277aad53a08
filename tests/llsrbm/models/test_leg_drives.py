"""What joints must do, against Pinocchio's Jacobians and differences along a foot's path."""

import json
from functools import cache

import casadi as ca
import numpy as np
import pinocchio as pin
import pytest

from llsrbm.models.drives import Drives, leg_drives, near_stops
from llsrbm.models.fitted_leg import FittedLeg
from llsrbm.models.knee_leg import KneeLeg
from llsrbm.robots import load_robot
from llsrbm.robots.leg_fit import sampled_legs
from tests.llsrbm.robots.test_robot import beside

KNEES = ("anymal", "go2")
PLACES = 12


@cache
def drives_of(name):
    return leg_drives(load_robot(name))


def number(value):
    return np.array(value, dtype=float).ravel()


def places(robot, count=PLACES):
    """Feet x (S, L, d) within reach, joint angles (S, L, n), generator."""
    x, q = sampled_legs(robot, count, seed=7)
    assert len(x) > count / 3
    return x, q, np.random.default_rng(3)


def foot_jacobians(robot, angles):
    """Of each leg, (L, 6, n): of its foot frame seen from the base, base axes, by Pinocchio."""
    q = robot.posture.copy()
    q[:7] = [0, 0, 0, 0, 0, 0, 1]
    q[7:][robot.leg_joint_index] = angles
    data = robot.model.createData()
    pin.computeJointJacobians(robot.model, data, q)
    pin.updateFramePlacements(robot.model, data)
    frames = (leg.foot_frame_id for leg in robot.legs)
    axes = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    full = np.array([pin.getFrameJacobian(robot.model, data, frame, axes) for frame in frames])
    index = 6 + robot.leg_joint_index
    return np.array([J[:, columns] for J, columns in zip(full, index, strict=True)])


@pytest.mark.parametrize("name", KNEES)
def test_legs_with_a_knee_are_recognised(name):
    legs = drives_of(name)
    assert all(isinstance(leg, KneeLeg) and leg.joints == 3 for leg in legs)


@pytest.mark.parametrize("name", KNEES)
def test_angles_of_knees_are_those_of_inverse_kinematics(name):
    x, q, _ = places(load_robot(name), 60)
    for place, angles in zip(x, q, strict=True):
        for i, leg in enumerate(drives_of(name)):
            np.testing.assert_allclose(number(leg.angles(ca.DM(place[i]))), angles[i], atol=2e-5)


@pytest.mark.parametrize(
    ("name", "joints"),
    [
        ("anymal", set()),  # its URDF's stops are turns away
        ("anymal_c", {"HAA"}),
        ("g1", {"hip_pitch_joint", "hip_roll_joint", "ankle_pitch_joint", "ankle_roll_joint"}),
    ],
)
def test_joints_that_may_come_near_a_stop(name, joints):
    robot = load_robot(name)
    may_stop = robot.leg_joint_index[near_stops(robot)]
    assert {robot.joint_names[j].split("_", 1)[1] for j in may_stop} == joints


@pytest.mark.parametrize("name", ["go2", "talos"])
def test_joints_without_rows_keep_off_their_stops_wherever_a_request_lets_feet_come(name):
    """A 1.25 times wider box, legs from 0.8 to 1.08 times as long: what limits may be set to."""
    robot, rng = load_robot(name), np.random.default_rng(5)
    reach = robot.file.reach
    lower, upper = np.array(reach.lower), np.array(reach.upper)
    x = rng.uniform(lower - 0.25 * np.abs(lower), upper + 0.25 * np.abs(upper), (4000, 3))
    distance = np.linalg.norm(x, axis=1)
    x = x[(distance > 0.8 * reach.distance[0]) & (distance < 1.08 * reach.distance[1])].T
    if robot.foot_coordinates > 3:
        x = np.vstack([x, rng.uniform(*robot.file.foot.yaw, x.shape[1])])
    x = x[: robot.foot_coordinates]
    for leg, rows, joints in zip(
        leg_drives(robot), near_stops(robot), robot.leg_joint_index, strict=True
    ):
        angles = np.column_stack([number(leg.angles(ca.DM(place))) for place in x.T[:800]])
        low, high = robot.joint_stops[:, joints]
        room = np.minimum(angles - low[:, None], high[:, None] - angles) / (high - low)[:, None]
        assert np.nanmin(room[~rows], initial=1.0) > 0.08


@pytest.mark.parametrize("name", KNEES)
def test_rates_and_torques_of_knees_are_those_of_the_jacobian(name):
    """Feet on both sides of the abduction axis' planes, all over the reach, moved at random."""
    robot = load_robot(name)
    x, q, rng = places(robot)
    for place, angles in zip(x, q, strict=True):
        jacobians = foot_jacobians(robot, angles)
        for i, leg in enumerate(drives_of(name)):
            J = jacobians[i, :3]
            velocity, force = rng.normal(size=(2, 3))
            expected = np.linalg.solve(J, robot.mirrors[i] * velocity)
            found = number(leg.rates(ca.DM(place[i]), ca.DM(velocity)))
            assert np.linalg.norm(found - expected) < 1e-3 * np.linalg.norm(expected)
            torque = number(leg.holding_torque(ca.DM(place[i]), ca.DM(force), None))
            assert np.linalg.norm(torque + J.T @ force) < 1e-3 * np.linalg.norm(J.T @ force)
            load = np.append(force, 0.1 * rng.normal(size=3))
            torque = number(leg.holding_torque(ca.DM(place[i]), *map(ca.DM, np.split(load, 2))))
            expected = jacobians[i].T @ load
            assert np.linalg.norm(torque + expected) < 1e-3 * np.linalg.norm(expected)


@pytest.mark.parametrize("name", ["anymal", "slider"])
def test_accelerations_are_the_rates_derivatives(name):
    """Along a parabola through each place, by central differences; with a knee in closed form."""
    robot = load_robot(name)
    x, _, rng = places(robot)
    step = 1e-4
    for place in x:
        for i, leg in enumerate(drives_of(name)):
            velocity, acceleration = rng.normal(size=(2, place.shape[1]))

            def rates(t, leg=leg, x0=place[i], v=velocity, a=acceleration):
                return number(leg.rates(ca.DM(x0 + v * t + a * t**2 / 2), ca.DM(v + a * t)))

            expected = (rates(step) - rates(-step)) / (2 * step)
            symbols = [ca.SX.sym(name, place.shape[1]) for name in ("x", "v", "a")]
            evaluate = ca.Function("q", symbols, [leg.accelerations(*symbols)])
            found = number(evaluate(place[i], velocity, acceleration))
            assert np.linalg.norm(found - expected) < 1e-3 * np.linalg.norm(expected)


@pytest.mark.parametrize("name", KNEES)
def test_feet_beyond_reach_leave_everything_finite(name):
    """As a solver may try them: stretched out, at the hip, at the abduction axis."""
    robot = load_robot(name)
    longest = robot.file.reach.distance[1]
    directions = np.array([[0, 0, -1], [1, 0, -1], [0, 1, -1], [0.3, -1, 0], [0, 0, 1], [0, 1, 0]])
    lengths = (1e-3, 0.2, 1.0, 1.15, 1.5, 3.0)
    symbols = [ca.SX.sym(name, 3) for name in ("x", "v", "a", "f")]
    for leg in drives_of(name):
        x, v, a, f = symbols
        values = ca.vertcat(
            leg.rates(x, v), leg.accelerations(x, v, a), leg.holding_torque(x, f, None)
        )
        slopes = ca.jacobian(values, ca.vertcat(*symbols))
        evaluate = ca.Function("all", symbols, [values, slopes])
        for direction in directions:
            for length in lengths:
                at = direction / np.linalg.norm(direction) * length * longest
                for found in evaluate(at, [1, -1, 2], [5, 3, -4], [20, -10, 200]):
                    assert np.isfinite(np.array(found)).all(), (direction, length)


def test_slides_are_fitted_within_their_stated_residuals():
    """At other places than those of the fit: angles' rates and torques against Pinocchio."""
    robot = load_robot("slider")
    legs = drives_of("slider")
    assert all(isinstance(leg, FittedLeg) for leg in legs)
    for leg in legs:
        assert leg.joints == 6
        assert leg.residuals["angle"] < 0.02
        assert leg.residuals["torque"] < 0.04
    x, q, rng = places(robot, 60)
    # Columns of J, shares of their mean, as the residual counts them.
    errors = {i: [] for i in range(len(legs))}
    sizes = {i: [] for i in range(len(legs))}
    rate_errors, rates = [], []
    for place, angles in zip(x, q, strict=True):
        jacobians = foot_jacobians(robot, angles)
        for i, leg in enumerate(legs):
            at = ca.DM(place[i])
            columns = [
                -number(leg.holding_torque(at, ca.DM(unit[:3]), ca.DM(unit[3:])))
                for unit in np.eye(6)
            ]
            errors[i].append(np.array(columns) - jacobians[i])
            sizes[i].append(np.abs(jacobians[i]).mean())
            velocity = rng.normal(size=4)
            twist = np.zeros(6)
            twist[:3] = robot.mirrors[i] * velocity[:3]
            twist[5] = robot.mirrors[i].prod() * velocity[3]
            expected = np.linalg.solve(jacobians[i], twist)
            rate_errors.append(number(leg.rates(at, ca.DM(velocity))) - expected)
            rates.append(expected)
    for i, leg in enumerate(legs):
        rms = np.sqrt(np.mean(np.square(errors[i]))) / np.mean(sizes[i])
        assert rms < 1.5 * leg.residuals["torque"]
    # Slopes of a quadratic, all over the reach: off by 12 %.
    assert np.sqrt(np.mean(np.square(rate_errors))) < 0.15 * np.sqrt(np.mean(np.square(rates)))


@pytest.mark.parametrize("name", ["anymal", "slider"])
def test_moving_masses_are_those_of_the_default_posture(name):
    """Each leg's block of Pinocchio's mass matrix; its weight by generalised gravity."""
    robot = load_robot(name)
    drives = Drives.of(robot)
    M = pin.crba(robot.model, robot.model.createData(), robot.posture)
    M = np.triu(M) + np.triu(M, 1).T
    gravity = pin.computeGeneralizedGravity(robot.model, robot.model.createData(), robot.posture)
    for i, index in enumerate(6 + robot.leg_joint_index):
        np.testing.assert_allclose(drives.mass_matrix[i], M[np.ix_(index, index)], atol=1e-12)
        # The default posture stands level, so the base's axes are the world's.
        np.testing.assert_allclose(drives.weight[i] @ [0, 0, 9.81], gravity[index], atol=1e-9)
    np.testing.assert_array_equal(
        drives.torque_limit.ravel(), robot.torque_limit[robot.leg_joint_index].ravel()
    )
    np.testing.assert_array_equal(
        drives.speed_limit.ravel(), robot.speed_limit[robot.leg_joint_index].ravel()
    )


def test_the_numbers_follow_the_urdfs_geometry(tmp_path):
    """Keys of caches: of one leg the thigh is longer, or the knee further out."""
    urdf = load_robot("anymal").urdf_path.read_text()

    def numbers(text, name):
        (tmp_path / name).mkdir()
        return Drives.of(load_robot(str(beside(tmp_path / name, text)))).numbers()

    own = numbers(urdf, "own")
    assert own == Drives.of(load_robot("anymal")).numbers()
    assert json.loads(json.dumps(own)) == own
    knee = 'xyz="0.0 0.109 -0.25"'
    assert knee in urdf
    for name, moved in (("longer", "0.0 0.109 -0.26"), ("wider", "0.0 0.119 -0.25")):
        other = numbers(urdf.replace(knee, f'xyz="{moved}"'), name)
        assert other["legs"][0] != own["legs"][0], name
        assert other.keys() == own.keys()


def knees_of(robot, angles):
    """Of each leg, (L, 3) m: its third joint seen from its hip, base axes, by Pinocchio."""
    q = robot.posture.copy()
    q[:7] = [0, 0, 0, 0, 0, 0, 1]
    q[7:][robot.leg_joint_index] = angles
    data = robot.model.createData()
    pin.forwardKinematics(robot.model, data, q)
    return np.array([data.oMi[leg.joint_ids[2]].translation - leg.hip for leg in robot.legs])


@pytest.mark.parametrize("name", KNEES)
def test_knees_are_where_pinocchio_has_them(name):
    robot = load_robot(name)
    x, q, _ = places(robot)
    for place, angles in zip(x, q, strict=True):
        found = [number(leg.knee(ca.DM(p))) for leg, p in zip(drives_of(name), place, strict=True)]
        np.testing.assert_allclose(found, knees_of(robot, angles), atol=2e-4)
