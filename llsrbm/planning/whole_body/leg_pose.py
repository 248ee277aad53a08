"""Where a leg's foot, its balls, its shank and its knee are in a pose, and how they move."""

from __future__ import annotations

from functools import lru_cache

import casadi as ca

from llsrbm.models.rigid_bodies import cross
from llsrbm.ocp.composition import Derived
from llsrbm.ocp.lifting import Lifting
from llsrbm.planning.problem.rotations import rotation_matrix
from llsrbm.planning.whole_body.chain import Chain, split
from llsrbm.planning.whole_body.limbs import LimbKind


def pose_inputs(kind: LimbKind) -> dict[str, int]:
    """Inputs of `leg_pose`."""
    joints = len(kind.joints)
    base = {"position": 3, "quat": 4, "velocity": 3, "omega": 3}
    return base | {"joint_position": joints, "joint_velocity": joints}


def pose_outputs(kind: LimbKind) -> dict[str, int]:
    """Outputs of `leg_pose`, world axes: the foot's place; of soles its velocity, axes and rate; of
    a point foot the velocity of the point by which its ball touches; the middles of balls; the
    knee; in base axes from the base's origin, the foot, and the middle of the shank.
    """
    moves = {"velocity": 3, "sole": 9, "omega": 3} if kind.corners > 1 else {"slides": 3}
    shank = 1 if kind.knee is None else 2
    found = {"foot": 3, **moves, "balls": 3 * kind.corners}
    return found | {"knee": 3 * (shank - 1), "shank": 3 * shank}


@lru_cache(maxsize=32)
def leg_pose(kind: LimbKind) -> Derived:
    """`pose_inputs` -> `pose_outputs`."""
    sizes = pose_inputs(kind)
    v = ca.SX.sym("v", sum(sizes.values()))
    x, chain, mark = split(v, sizes), Chain(kind), Lifting(v)
    n, q, dq = chain.n, x["joint_position"], x["joint_velocity"]
    R_world_base = mark(rotation_matrix(x["quat"]))
    R, at, knee = ca.SX.eye(3), ca.SX(3, 1), None
    # Velocities against the base, own axes.
    speed, w = ca.SX(3, 1), ca.SX(3, 1)
    for i, joint in enumerate(kind.joints):
        turn, arm, axis = chain.turn(i, q[i]), chain.arm(i, q), chain.axis(i)
        at, R = mark(at + ca.mtimes(R, arm)), mark(ca.mtimes(R, turn))
        speed, w = ca.mtimes(turn.T, speed + cross(w, arm)), ca.mtimes(turn.T, w)
        moves = axis * dq[i]
        speed, w = (speed + moves, w) if joint.slides else (speed, w + moves)
        speed, w = mark(speed), mark(w)
        knee = at if i == kind.knee else knee
    foot = mark(at + ca.mtimes(R, n("place")))
    omega = mark(x["omega"] + ca.mtimes(R, w))  # base axes
    relative = ca.mtimes(R, speed + cross(w, n("place")))
    turned = mark(relative + cross(x["omega"], foot))  # of the foot, but for the base's velocity
    place = x["position"] + ca.mtimes(R_world_base, foot)
    arms = [
        mark(ca.mtimes(R, n("balls")[3 * k : 3 * k + 3])) for k in range(kind.corners)
    ]  # from the foot's frame
    found = {
        "foot": place,
        "balls": ca.vertcat(*(place + ca.mtimes(R_world_base, arm) for arm in arms)),
        "knee": ca.SX(0, 1),
        "shank": foot,
    }
    if kind.corners > 1:
        axes = ca.reshape(n("axes"), 3, 3)
        found["velocity"] = x["velocity"] + ca.mtimes(R_world_base, turned)
        found["sole"] = ca.vec(ca.mtimes(R_world_base, mark(ca.mtimes(R, axes))))
        found["omega"] = ca.mtimes(R_world_base, omega)
    else:
        touching = arms[0] - n("radius") * mark(ca.mtimes(R_world_base.T, n("normal")))
        slides = turned + cross(omega, touching)
        found["slides"] = x["velocity"] + ca.mtimes(R_world_base, slides)
    if knee is not None:
        found["knee"] = x["position"] + ca.mtimes(R_world_base, knee)
        found["shank"] = ca.vertcat(foot, (foot + knee) / 2)
    outputs = pose_outputs(kind)
    assert {name: found[name].numel() for name in outputs} == outputs
    return Derived("leg_pose", v, n.all, ca.vertcat(*(found[n] for n in outputs)), mark)
