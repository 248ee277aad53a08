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


@dataclass
class Motion:
    """One posture and velocity; base axes, about the CoM.

    beta, beta_rate: (L, 3) feet from the CoM and their velocity seen from the base; w: (3,) of the
    base; offset: (3,) of the base's origin; inertia, momentum, leg_com: Pinocchio's.
    """

    beta: np.ndarray
    beta_rate: np.ndarray
    w: np.ndarray
    offset: np.ndarray
    inertia: np.ndarray
    momentum: np.ndarray
    leg_com: np.ndarray


def random_motions(count: int, seed: int = 0, robot=ROBOT) -> list[Motion]:
    """Joint angles about the default posture, kept where the feet are within reach."""
    rng = np.random.default_rng(seed)
    model, data = robot.model, robot.model.createData()
    reach, motions = robot.file.reach, []
    while len(motions) < count:
        q, v = robot.posture.copy(), np.zeros(model.nv)
        R = Rotation.random(random_state=rng)
        q[:3], q[3:7] = rng.normal(size=3), R.as_quat()
        q[7:] += rng.uniform(-1, 1, size=len(q) - 7) * np.tile([0.25, 0.4, 0.5], LEGS)
        v[:3], v[3:6] = rng.normal(size=3), rng.uniform(-2, 2, size=3)
        v[6:] = rng.uniform(-3, 3, size=model.nv - 6)
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
                beta=arms @ M,
                beta_rate=seen @ M,
                w=v[3:6],
                offset=M.T @ (q[:3] - com),
                inertia=M.T @ data.Ig.inertia @ M,
                momentum=M.T @ data.hg.angular,
                leg_com=_leg_coms(model, data, q, robot, com) @ M,
            )
        )
    return motions


def _leg_coms(model, data, q, robot, com):
    pin.centerOfMass(model, data, q, True)
    first = [leg.joint_ids[0] for leg in robot.legs]
    return np.array([data.oMi[j].act(data.com[j]) for j in first]) - com


def feet_in_reach():
    """Hypothesis: (L, 3) m, mirrored hip frame, anywhere in the reach box."""
    reach = ROBOT.file.reach
    axis = [st.floats(low, high) for low, high in zip(reach.lower, reach.upper, strict=True)]
    return st.lists(st.tuples(*axis), min_size=LEGS, max_size=LEGS).map(np.array)


def rates(top: float = 3.0):
    """Hypothesis: (L, 3) m/s."""
    axis = st.floats(-top, top)
    return st.lists(st.tuples(axis, axis, axis), min_size=LEGS, max_size=LEGS).map(np.array)


def vectors(top: float = 3.0):
    """Hypothesis: (3,)."""
    return st.tuples(*[st.floats(-top, top)] * 3).map(np.array)


def standing_feet_in_hip(robot=ROBOT) -> np.ndarray:
    """(L, 3) m of the default posture."""
    return robot.mirrors * (robot.feet - robot.base_position - robot.hips)
