"""Random motions of a whole robot by Pinocchio, and as the models see them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from llsrbm.robots import load_robot

ROBOT = load_robot("anymal")
LEGS = len(ROBOT.legs)
SLIDER = load_robot("slider")

# How far joint angles are drawn about the default posture: rad, of the slide m.
SPREAD = {3: [0.25, 0.4, 0.5], 6: [0.15, 0.3, 0.2, 0.8, 0.0, 0.0]}
SPEEDS = {3: [3.0, 3.0, 3.0], 6: [1.0, 1.0, 1.0, 5.0, 0.0, 0.0]}


@dataclass
class Motion:
    """One posture and velocity; base axes, about the CoM.

    beta, beta_rate: (L, d) feet from the CoM and their velocity seen from the base, of soles with
    the yaw; w: (3,) of the base; offset: (3,) of the base's origin; inertia, momentum, leg_com:
    Pinocchio's.
    """

    beta: np.ndarray
    beta_rate: np.ndarray
    w: np.ndarray
    offset: np.ndarray
    inertia: np.ndarray
    momentum: np.ndarray
    leg_com: np.ndarray


def random_motions(count: int, seed: int = 0, robot=ROBOT) -> list[Motion]:
    """Joint angles about the default posture, kept where the feet are within reach.

    Ankles keep soles level in the base.
    """
    rng = np.random.default_rng(seed)
    model, data = robot.model, robot.model.createData()
    reach, motions = robot.file.reach, []
    legs, joints = len(robot.legs), len(robot.legs[0].joints)
    while len(motions) < count:
        q, v = robot.posture.copy(), np.zeros(model.nv)
        R = Rotation.random(random_state=rng)
        q[:3], q[3:7] = rng.normal(size=3), R.as_quat()
        q[7:] += rng.uniform(-1, 1, size=len(q) - 7) * np.tile(SPREAD[joints], legs)
        v[:3], v[3:6] = rng.normal(size=3), rng.uniform(-2, 2, size=3)
        v[6:] = rng.uniform(-1, 1, size=model.nv - 6) * np.tile(SPEEDS[joints], legs)
        yaws = np.empty((legs, 0))
        if joints > 3:
            yaws = np.array([keep_level(model, leg, q, v) for leg in robot.legs])
        pin.ccrba(model, data, q, v)
        pin.forwardKinematics(model, data, q, v)
        pin.updateFramePlacements(model, data)
        pin.centerOfMass(model, data, q, v)
        com, com_rate, M = data.com[0], data.vcom[0], R.as_matrix()
        w_world = M @ v[3:6]
        frames = [leg.foot_frame_id for leg in robot.legs]
        arms = np.array([data.oMf[f].translation - com for f in frames])
        rates = np.array(
            [pin.getFrameVelocity(model, data, f, pin.LOCAL_WORLD_ALIGNED).linear for f in frames]
        )
        # Of a vector fixed in the base the base sees no velocity.
        seen = rates - com_rate - np.cross(w_world, arms)
        in_hip = robot.mirrors * ((arms + com - q[:3]) @ M - robot.hips)
        distance = np.linalg.norm(in_hip, axis=1)
        inside = (in_hip >= reach.lower) & (in_hip <= reach.upper)
        if not inside.all() or distance.max() > reach.distance[1]:
            continue
        motions.append(
            Motion(
                beta=np.hstack([arms @ M, yaws[:, :1]]),
                beta_rate=np.hstack([seen @ M, yaws[:, 1:]]),
                w=v[3:6],
                offset=M.T @ (q[:3] - com),
                inertia=M.T @ data.Ig.inertia @ M,
                momentum=M.T @ data.hg.angular,
                leg_com=_leg_coms(model, data, q, robot, com) @ M,
            )
        )
    return motions


def keep_level(model, leg, q, v):
    """Set ankle pitch and roll, the last two joints, so that the sole stays level in the base.

    Returns its yaw against the base and that yaw's rate.
    """
    data, still = model.createData(), q.copy()
    still[:7] = pin.neutral(model)[:7]
    still[leg.q_index[-2:]] = 0.0
    pin.framesForwardKinematics(model, data, still)
    up = data.oMf[leg.foot_frame_id].rotation[2]
    q[leg.q_index[-2:]] = still[leg.q_index[-2:]] = np.arctan2(up[0], up[2]), -np.arcsin(up[1])
    jacobian = pin.computeFrameJacobian(
        model, data, still, leg.foot_frame_id, pin.LOCAL_WORLD_ALIGNED
    )[3:, leg.v_index]
    v[leg.v_index[-2:]] = 0.0
    v[leg.v_index[-2:]] = -np.linalg.solve(jacobian[:2, -2:], jacobian[:2] @ v[leg.v_index])
    R = data.oMf[leg.foot_frame_id].rotation
    assert np.allclose(R[2], [0, 0, 1])
    return np.arctan2(R[1, 0], R[0, 0]), jacobian[2] @ v[leg.v_index]


def _leg_coms(model, data, q, robot, com):
    pin.centerOfMass(model, data, q, True)
    first = [leg.joint_ids[0] for leg in robot.legs]
    return np.array([data.oMi[j].act(data.com[j]) for j in first]) - com


def feet_in_reach(robot=ROBOT):
    """Hypothesis: (L, d) m, rad, mirrored hip frame, anywhere in the reach box and at any yaw."""
    reach, yaw, d = robot.file.reach, robot.file.foot.yaw, robot.foot_coordinates
    bounds = [*zip(reach.lower, reach.upper, strict=True), yaw][:d]
    axes = [st.floats(low, high) for low, high in bounds]
    return _of_legs(robot, axes)


def rates(top: float = 3.0, robot=ROBOT):
    """Hypothesis: (L, d) m/s, rad/s."""
    return _of_legs(robot, [st.floats(-top, top)] * robot.foot_coordinates)


def _of_legs(robot, axes):
    return st.lists(st.tuples(*axes), min_size=len(robot.legs), max_size=len(robot.legs)).map(
        np.array
    )


def vectors(top: float = 3.0):
    """Hypothesis: (3,)."""
    return st.tuples(*[st.floats(-top, top)] * 3).map(np.array)


def all_stand(model, count: int = 1) -> np.ndarray:
    """(count, L): every foot is given as seen from the CoM."""
    return np.ones((count, model.legs), dtype=bool)


def standing_feet_in_hip(robot=ROBOT) -> np.ndarray:
    """(L, d) m, rad of the default posture."""
    place = robot.mirrors * (robot.feet - robot.base_position - robot.hips)
    return np.column_stack([place, np.zeros(len(place))])[:, : robot.foot_coordinates]
