"""Random motions of a whole robot by Pinocchio, and as the models see them."""

from dataclasses import dataclass
from functools import cache

import casadi as ca
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


@cache
def _functions(model, standing: tuple[int, ...]) -> dict[str, ca.Function]:
    """The model's expressions as functions, of feet of which `standing` are seen from the CoM."""
    y, x, xdot = (ca.SX.sym(n, model.coordinates, model.legs) for n in ("y", "x", "xdot"))
    w, legs = ca.SX.sym("w", 3), range(model.legs)
    of = model.offset_map(standing)
    o, o_rate = (f(dict(enumerate(ca.horzsplit(y)))) for f in (of, of.rate))
    feet, rate = (
        ca.horzcat(*(f(i, y[:, i], at) if i in standing else y[:, i] for i in legs))
        for f, at in ((model.foot_in_hip, o), (model.foot_rate_in_hip, o_rate))
    )
    offset = model.base_offset(x)
    coms = [model.foot_from_com(i, model.leg_com(i, x[:, i]), offset) for i in legs]
    momentum = model.angular_momentum(x, xdot, w, offset)
    results = {
        "feet": ([y], feet),
        "rate": ([y], rate),
        "offset": ([x], offset),
        "inertia": ([x], model.inertia(x, offset)),
        "leg_com": ([x], ca.horzcat(*coms)),
        "momentum": ([x, xdot, w], momentum),
    }
    return {
        name: ca.Function(name, i, [ca.densify(ca.SX(out))]) for name, (i, out) in results.items()
    }


def _evaluated(model, name, *arguments, standing=()):
    function = _functions(model, tuple(int(i) for i in standing))[name]
    values = (function(*(a.T for a in one)) for one in zip(*arguments, strict=True))
    return np.array([np.array(value).T.squeeze() for value in values])


def feet_of(model, feet, standing=None):
    """x (K, L, d) of feet (K, L, d), those with `standing` (L,) seen from the CoM; None: all."""
    standing = range(model.legs) if standing is None else np.flatnonzero(standing)
    return _evaluated(model, "feet", feet, standing=standing)


def feet_rate_of(model, rates, standing=None):
    """xdot likewise."""
    standing = range(model.legs) if standing is None else np.flatnonzero(standing)
    return _evaluated(model, "rate", rates, standing=standing)


def evaluate(model, x):
    """Offsets (K, 3), inertias (K, 3, 3), leg CoMs seen from the CoM (K, L, 3)."""
    return tuple(_evaluated(model, name, x) for name in ("offset", "inertia", "leg_com"))


def evaluate_momentum(model, x, xdot, w):
    """I omega + h, (K, 3)."""
    return _evaluated(model, "momentum", x, xdot, w)


def standing_feet_in_hip(robot=ROBOT) -> np.ndarray:
    """(L, d) m, rad of the default posture."""
    place = robot.mirrors * (robot.feet - robot.base_position - robot.hips)
    return np.column_stack([place, np.zeros(len(place))])[:, : robot.foot_coordinates]
