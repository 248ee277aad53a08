"""Stages in which the hind feet push while the front feet swing, against the whole body.

Random postures and velocities by Pinocchio, the hind feet at rest on the ground. An interval of a
microsecond is an instant: what the stage has in its middle is what it is told of its beginning.
"""

from dataclasses import dataclass
from functools import cache

import casadi as ca
import numpy as np
import pinocchio as pin

from llsrbm.mechanics import GRAVITY
from llsrbm.models import make_model
from llsrbm.planning.problem.layout import Layout
from llsrbm.planning.problem.parameters import parameter_symbols
from llsrbm.planning.problem.stage import Stage
from llsrbm.robots import load_robot

ROBOT = load_robot("anymal")
PIN = ROBOT.model
MODEL = make_model("llsrbm-plus", ROBOT)
FRONT, HIND = (0, 1), (2, 3)
LAYOUT = Layout(
    contacts=4,
    stands=((True,) * 4, (False, False, True, True), (False,) * 4, (True,) * 4),
    intervals=(4, 4, 4, 4),
)
PUSHING = LAYOUT.roles[5]
DT = 1e-6  # s
COUNT = 150
AXES = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED


@dataclass
class Instant:
    """What the stage is told, and what Pinocchio says of the same."""

    told: dict[str, np.ndarray]
    standing: np.ndarray
    torque: np.ndarray
    joint_rate: np.ndarray


def foot_motion(data, q, v, a):
    """Places, velocities and accelerations of the feet, (3, L, 3), and their Jacobians."""
    pin.forwardKinematics(PIN, data, q, v, a)
    pin.computeJointJacobians(PIN, data, q)
    pin.updateFramePlacements(PIN, data)
    frames = [leg.foot_frame_id for leg in ROBOT.legs]
    motion = [
        [data.oMf[f].translation.copy() for f in frames],
        [pin.getFrameVelocity(PIN, data, f, AXES).linear for f in frames],
        [pin.getFrameClassicalAcceleration(PIN, data, f, AXES).linear for f in frames],
    ]
    jacobians = [pin.getFrameJacobian(PIN, data, f, AXES)[:3] for f in frames]
    return np.array(motion), np.array(jacobians)


def pushed(data, q, force):
    """Efforts of forces (4, 3) N at the lowest points of the feet's balls."""
    pin.computeJointJacobians(PIN, data, q)
    pin.updateFramePlacements(PIN, data)
    moment = np.cross([0, 0, -ROBOT.foot_lift], force)
    jacobians = [pin.getFrameJacobian(PIN, data, leg.foot_frame_id, AXES) for leg in ROBOT.legs]
    return np.einsum("lij,li->j", jacobians, np.hstack([force, moment]))


def instant(rng) -> Instant | None:
    """One, unless a foot is out of its reach."""
    data, still = PIN.createData(), np.zeros(PIN.nv)
    q, v = ROBOT.posture.copy(), np.zeros(PIN.nv)
    q[3:7] = (pin.Quaternion(pin.exp3(rng.uniform(-0.3, 0.3, size=3)))).coeffs()
    q[7:] += rng.uniform(-1, 1, size=12) * np.tile([0.15, 0.3, 0.3], 4)
    v[:6] = rng.uniform(-1, 1, size=6) * [0.5, 0.5, 0.5, 1.0, 1.0, 1.0]
    v[6:] = rng.uniform(-3, 3, size=12)
    columns = [np.asarray(leg.v_index) for leg in ROBOT.legs]
    (_, _, _), jacobians = foot_motion(data, q, v, still)
    for leg in HIND:  # at rest on the ground
        J, own = jacobians[leg], columns[leg]
        v[own] = -np.linalg.solve(J[:, own], J[:, :6] @ v[:6])
    if np.abs(v[6:]).max() > 8.0:
        return None
    (feet, _, drift), jacobians = foot_motion(data, q, v, still)
    pin.ccrba(PIN, data, q, v)
    momentum = data.hg.angular.copy()
    pin.centerOfMass(PIN, data, q, v, still)
    com, com_velocity, com_drift = data.com[0].copy(), data.vcom[0].copy(), data.acom[0].copy()
    com_jacobian = pin.jacobianCenterOfMass(PIN, data, q)

    # The front feet as the base sees them: another robot, whose base does not move.
    q_base, v_base = q.copy(), v.copy()
    q_base[:7], v_base[:6] = [0, 0, 0, 0, 0, 0, 1], 0.0
    (seen, seen_rate, seen_drift), seen_jacobians = foot_motion(data, q_base, v_base, still)
    x = ROBOT.mirrors * (seen - ROBOT.hips)
    reach = ROBOT.file.reach
    if (x < reach.lower).any() or (x > reach.upper).any():
        return None
    x_rate, x_acceleration = ROBOT.mirrors * seen_rate, rng.uniform(-15, 15, size=(4, 3))

    # Accelerations: hind feet rest, front feet as drawn, the CoM as the forces have it.
    force = np.zeros((4, 3))
    force[list(HIND)] = rng.uniform([-0.3, -0.3, 1.0], [0.3, 0.3, 3.0], size=(2, 3))
    force *= ROBOT.mass * GRAVITY / 4
    rows, rhs = [com_jacobian], [force.sum(axis=0) / ROBOT.mass - [0, 0, GRAVITY] - com_drift]
    for leg in HIND:
        rows, rhs = [*rows, jacobians[leg]], [*rhs, -drift[leg]]
    for leg in FRONT:
        J = np.zeros((3, PIN.nv))
        J[:, columns[leg]] = seen_jacobians[leg][:, columns[leg]]
        rows = [*rows, J]
        rhs = [*rhs, ROBOT.mirrors[leg] * x_acceleration[leg] - seen_drift[leg]]
    no_turn = np.zeros((3, PIN.nv))
    no_turn[:, 3:6] = np.eye(3)
    a = np.linalg.solve(np.vstack([*rows, no_turn]), np.concatenate([*rhs, np.zeros(3)]))
    effort = pin.rnea(PIN, data, q, v, a) - pushed(data, q, force)
    np.testing.assert_allclose(effort[:3], 0.0, atol=1e-6)

    front = list(FRONT)
    step = x_acceleration * DT
    told = {
        "position": com,
        "quat": q[[6, 3, 4, 5]],
        "velocity": com_velocity,
        "momentum": momentum / ROBOT.mass,
        "feet": x[front].ravel(),
        "feet_velocity": (x_rate - step / 2)[front].ravel(),
        "feet_step": step[front].ravel(),
        "force": (force[list(HIND)] / (ROBOT.mass * GRAVITY / 4)).ravel(),
        "force_step": np.zeros(6),
        "duration": np.array([DT * PUSHING.intervals]),
        "rotation_rate": v[3:6],
    }
    return Instant(
        told=told,
        standing=feet - [0, 0, ROBOT.foot_lift],
        torque=(effort[6:] / ROBOT.torque_limit)[ROBOT.leg_joint_index],
        joint_rate=v[6:][ROBOT.leg_joint_index],
    )


@cache
def instants() -> list[Instant]:
    rng, found = np.random.default_rng(0), []
    while len(found) < COUNT:
        one = instant(rng)
        if one is not None:
            found.append(one)
    return found


@cache
def evaluated():
    """Shares of torque and joint rates, (COUNT, 4, 3): errors of the stage, and the body's."""
    symbols = parameter_symbols(LAYOUT)
    stage = Stage(PUSHING, LAYOUT, MODEL, symbols)
    inputs = [stage.variables, stage.local, stage.correction, ca.vertcat(*symbols.values())]
    outputs = [stage.lift.resolve(ca.SX(e)) for e in (stage.joint_torques, stage.joint_rates)]
    function, found = ca.Function("stage", inputs, outputs), []
    rest = np.zeros(sum(symbol.numel() for symbol in symbols.values()))
    for one in instants():
        variables = np.concatenate([one.told[name] for name in stage.symbols])
        local = np.concatenate([one.standing.ravel(), one.standing.ravel(), np.zeros(12)])
        results = function(variables, local, np.zeros(3), rest)
        found.append([np.array(result).T for result in results])
    torque, rates = (np.array(values) for values in zip(*found, strict=True))
    true_torque, true_rates = (
        np.array([getattr(one, name) for one in instants()]) for name in ("torque", "joint_rate")
    )
    return torque - true_torque, true_torque, rates - true_rates, true_rates


def rms(error):
    return np.sqrt(np.mean(error**2))


def test_torques_are_those_of_the_body():
    """Standing legs hold the forces, swinging legs accelerate, in a base that accelerates."""
    error, true, _, _ = evaluated()
    for legs in (FRONT, HIND):
        assert rms(error[:, list(legs)]) < 0.06
    assert rms(true[:, list(HIND)]) > 0.4


def test_joints_turn_as_those_of_the_body():
    _, _, error, true = evaluated()
    assert rms(error) < 0.03 * rms(true)
