"""Forces and torques of a motion: Newton's and Euler's equations of the trunk and of a limb."""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

import casadi as ca

from llsrbm.mechanics import GRAVITY
from llsrbm.models.rigid_bodies import cross
from llsrbm.ocp.composition import Derived
from llsrbm.ocp.lifting import Lifting
from llsrbm.planning.problem.rotations import rotation_matrix
from llsrbm.planning.whole_body.chain import Chain, Numbered, split
from llsrbm.planning.whole_body.limbs import LINK, LimbKind


class _Moving(NamedTuple):
    turn: Any  # (3, 3) to the parent's axes
    arm: Any  # (3,) m from the parent's joint, parent's axes
    omega: Any  # (3,) rad/s, and all that follows, own axes
    omega_rate: Any  # (3,) rad/s2
    acceleration: Any  # (3,) m/s2 of its joint, and upward gravity


def _load(moving: _Moving, mass: Any, moment: Any, inertia: Any) -> tuple[Any, Any]:
    """Force and moment about its joint that a link's motion needs, N and Nm, own axes."""
    _, _, w, dw, a = moving
    force = mass * a + cross(dw, moment) + cross(w, cross(w, moment))
    xx, xy, xz, yy, yz, zz = ca.vertsplit(inertia)
    full = ca.vertcat(ca.horzcat(xx, xy, xz), ca.horzcat(xy, yy, yz), ca.horzcat(xz, yz, zz))
    spin = ca.mtimes(full, dw) + cross(w, ca.mtimes(full, w))
    return force, spin + cross(moment, a)


BODY = {"quat": 4, "omega": 3, "acceleration": 3, "omega_rate": 3}


@lru_cache
def trunk_effort() -> Derived:
    """`BODY` of the base -> force (N) and moment (Nm) about its origin, base axes, that it needs.

    Its origin's acceleration is the world's; omega and its rate have the base's axes.
    """
    v = ca.SX.sym("v", sum(BODY.values()))
    body, n, mark = split(v, BODY), Numbered(LINK), Lifting(v)
    R = mark(rotation_matrix(body["quat"]))
    upward = body["acceleration"] + ca.DM([0, 0, GRAVITY])
    moving = _Moving(None, None, body["omega"], body["omega_rate"], mark(ca.mtimes(R.T, upward)))
    load = _load(moving, n("mass"), n("moment"), n("inertia"))
    return Derived("trunk", v, n.all, ca.vertcat(*load), mark)


def effort_inputs(kind: LimbKind) -> dict[str, int]:
    """Inputs of `limb_effort`: motion of the base and of the joints, forces on contact points."""
    joints = len(kind.joints)
    moves = {"joint_position": joints, "joint_velocity": joints, "joint_acceleration": joints}
    return BODY | moves | {"force": 3 * kind.corners}


@lru_cache(maxsize=32)
def limb_effort(kind: LimbKind, stands: bool) -> Derived:
    """`effort_inputs` -> force and moment about the base's origin, base axes, that the base has to
    give, and torques of the drives, Nm or N; `stands`: forces push its contact points.
    """
    sizes = effort_inputs(kind)
    if not stands:
        del sizes["force"]
    v = ca.SX.sym("v", sum(sizes.values()))
    x, chain, count = split(v, sizes), Chain(kind), len(kind.joints)
    n, mark = chain.n, Lifting(v)
    q, dq, ddq = (x[f"joint_{name}"] for name in ("position", "velocity", "acceleration"))
    R = mark(rotation_matrix(x["quat"]))
    upward = x["acceleration"] + ca.DM([0, 0, GRAVITY])
    links = []
    before = _Moving(None, None, x["omega"], x["omega_rate"], mark(ca.mtimes(R.T, upward)))
    to_base = ca.SX.eye(3)
    for i in range(count):
        axis, turn, arm = chain.axis(i), chain.turn(i, q[i]), chain.arm(i, q)
        speed, more = axis * dq[i], axis * ddq[i]
        inward = cross(before.omega, cross(before.omega, arm))
        carried = before.acceleration + cross(before.omega_rate, arm) + inward
        carried = ca.mtimes(turn.T, carried)
        turning, rate = (ca.mtimes(turn.T, w) for w in (before.omega, before.omega_rate))
        if kind.joints[i].slides:
            w, dw = mark(turning), mark(rate)
            a = mark(carried + more + 2 * cross(w, speed))
        else:
            w = mark(turning + speed)
            dw, a = mark(rate + more + cross(w, speed)), mark(carried)
        before = _Moving(turn, arm, w, dw, a)
        links.append(before)
        to_base = ca.mtimes(to_base, turn)
    force, moment = ca.SX(3, 1), ca.SX(3, 1)
    if stands:
        to_link = mark(ca.mtimes(R, to_base)).T
        below = mark(ca.mtimes(to_link, n("normal"))) * n("lift")
        for k in range(kind.corners):
            push = mark(ca.mtimes(to_link, x["force"][3 * k : 3 * k + 3]))
            force -= push
            moment -= cross(n("contacts")[3 * k : 3 * k + 3] - below, push)
    torque = [ca.SX(0)] * count
    for i in reversed(range(count)):
        own = _load(links[i], n("mass", i), n("moment", i), n("inertia", i))
        force, moment = mark(force + own[0]), mark(moment + own[1])
        along = force if kind.joints[i].slides else moment
        speed, width = dq[i], n("width", i)
        torque[i] = ca.dot(chain.axis(i), along) + n("armature", i) * ddq[i]
        torque[i] += n("friction", i) * speed / ca.sqrt(speed**2 + width**2)
        torque[i] += n("damping", i) * speed
        turn, arm = links[i].turn, links[i].arm
        force = ca.mtimes(turn, force)
        moment = ca.mtimes(turn, moment) + cross(arm, force)
    name = f"effort_{'stands' if stands else 'free'}_{count}"
    return Derived(name, v, n.all, ca.vertcat(force, moment, *torque), mark)
