"""Flights as a detector sees them: free fall, a contact that begins, and noise; world frame."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from llsrbm.control.detection import CentroidalState
from llsrbm.robots import load_robot

GRAVITY = np.array([0.0, 0.0, -9.81])
MASS, INERTIA = 30.0, np.diag([0.9, 1.6, 1.9])


@dataclass
class Contact:
    """A force that grows to `force` (3,) N within `rise` s from `begin` s on, at `point` (3,) m
    from the CoM."""

    begin: float
    force: np.ndarray
    point: np.ndarray
    rise: float = 1e-3


def flight(
    tick=0.0025,
    duration=0.3,
    velocity=(0.3, -0.2, 1.5),
    momentum=(0.3, -0.4, 3.0),
    contact=None,
    noise=0.0,
    seed=0,
    stretch=0.0,
):
    """Measured states, a tick apart, of a robot that leaves the ground at time 0.

    Args:
        noise: of each component of velocity and angular velocity, m/s and rad/s.
        stretch: by how much of itself the inertia changes in the flight, as when legs fold.
    """
    rng = np.random.default_rng(seed)
    r, v, L = np.zeros(3), np.array(velocity), np.array(momentum)
    substeps = 10
    dt = tick / substeps
    states = []
    for k in range(round(duration / tick)):
        inertia = INERTIA * (1 + stretch * np.sin(np.pi * k * tick / duration))
        states.append(
            CentroidalState(
                MASS,
                v + noise * rng.normal(size=3),
                L + inertia @ (noise * rng.normal(size=3)),
                inertia,
            )
        )
        for i in range(substeps):
            acceleration, torque = GRAVITY, np.zeros(3)
            if contact is not None:
                time = k * tick + i * dt - contact.begin
                force = contact.force * np.clip(time / contact.rise, 0, 1)
                acceleration, torque = GRAVITY + force / MASS, np.cross(contact.point, force)
            v = v + dt * acceleration
            r = r + dt * v
            L = L + dt * torque
    return states


def landing(time, tick, kick):
    """A contact that changes the velocity by `kick` (3,) m/s within one tick, and then stops."""
    states = flight(tick)
    for k in range(round(time / tick), len(states)):
        states[k] = CentroidalState(
            MASS, states[k].com_velocity + kick, states[k].angular_momentum, INERTIA
        )
    return states


def rotated(state, angle):
    """The same motion in a world turned about z by -angle."""
    c, s = np.cos(angle), np.sin(angle)
    R = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    return CentroidalState(
        state.mass, R @ state.com_velocity, R @ state.angular_momentum, R @ state.inertia @ R.T
    )


def first(detector, states):
    """Index of the state at which contact is reported, None if it never is."""
    detector.reset()
    return next((k for k, state in enumerate(states) if detector.update(state)), None)


def trunk_momentum(model, data, q, v):
    """(6,) of the trunk relative to the CoM: by how much a kilogram more would change all."""
    base = pin.SE3(pin.Quaternion(*q[[6, 3, 4, 5]]).matrix(), q[:3])
    relative = v[:6].copy()
    relative[:3] -= base.rotation.T @ data.hg.linear / data.Ig.mass
    about_com = pin.SE3(np.eye(3), data.com[0]).actInv(base)
    return about_com.act(model.inertias[1] * pin.Motion(relative)).vector


def misjudged_flight(trunk_factor, tick=0.0025, duration=0.3, swing_speed=15.0):
    """A flight of ANYmal without contact, seen by a controller that is wrong about the trunk.

    The true robot's momentum is kept exactly by solving for the base's velocity while the legs fold
    and stretch with joint speeds up to `swing_speed`, rad/s.
    """
    robot = load_robot("anymal")
    true = robot.model.copy()
    trunk = true.inertias[1]
    true.inertias[1] = pin.Inertia(
        trunk.mass * trunk_factor, trunk.lever, trunk.inertia * trunk_factor
    )
    data, believed = true.createData(), robot.model.createData()
    q = robot.posture.copy()
    mass = pin.computeTotalMass(true)
    hip, knee = robot.leg_joint_index[:, 1], robot.leg_joint_index[:, 2]
    # Joint angles a (1 - cos(2 pi t / T)) / 2 fold the legs and stretch them again.
    fold = np.zeros(len(robot.joint_names))
    start = q[7:]
    fold[hip], fold[knee] = -np.sign(start[knee]), np.sign(start[knee])
    rate = 2 * np.pi / duration
    fold *= 2 * swing_speed / rate
    states = []
    for k in range(round(duration / tick)):
        time = k * tick
        v = np.zeros(true.nv)
        v[6:] = fold / 2 * rate * np.sin(rate * time)
        A = pin.computeCentroidalMap(true, data, q).copy()
        momentum = np.r_[mass * (np.array([0.3, 0.0, 1.5]) + time * GRAVITY), 0.2, -0.3, 3.0]
        v[:6] = np.linalg.solve(A[:, :6], momentum - A[:, 6:] @ v[6:])
        pin.ccrba(robot.model, believed, q, v)
        states.append(
            CentroidalState(
                robot.mass,
                believed.hg.linear / robot.mass,
                believed.hg.angular.copy(),
                believed.Ig.inertia.copy(),
                trunk_momentum(robot.model, believed, q, v),
            )
        )
        q = pin.integrate(true, q, tick * v)
    return states
