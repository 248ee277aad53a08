"""A robot's kinematics and equations of motion as CasADi expressions: Newton-Euler over its URDF.

Vectors are in the axes of the body that they belong to, those of the base in the base's. The base's
place and velocity do not enter the dynamics, so they are left out of them.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import casadi as ca
import numpy as np
import pinocchio as pin

from llsrbm.arrays import Array
from llsrbm.models.drive_losses import DriveLosses
from llsrbm.robots.robot import Robot
from llsrbm.robots.urdf import BASE_JOINT

Mark = Callable[[Any], Any]  # of an intermediate quantity, as `llsrbm.ocp.lifting` does

_ROUNDING = 1e-12  # of rotations in a URDF, which are mostly quarter turns


class Mass(NamedTuple):
    """Mass properties of a link."""

    mass: float  # kg
    com: Array  # (3,) m, from the joint
    inertia: Array  # (3, 3) kg m2 about the CoM


@dataclass(frozen=True, eq=False)
class Link:
    """A link and the joint that it hangs on.

    Attributes:
        parent: Pinocchio's index of the joint before; joint: the place among `joint_names`.
        axis: (3,) of the joint; slides: whether it is a prismatic one.
        rotation, origin: (3, 3) and (3,) m, of the joint at zero in the parent's axes.
    """

    parent: int
    joint: int
    axis: Array
    slides: bool
    rotation: Array
    origin: Array
    own: Mass


class Moving(NamedTuple):
    """A link in motion."""

    rotation: Any  # (3, 3) to base axes
    position: Any  # (3,) m, of its joint, base axes, from the base's origin
    velocity: Any  # (3,) m/s, of its joint, in the world, the link's axes
    omega: Any  # (3,) rad/s, in the world, the link's axes


class Accelerated(NamedTuple):
    """A link under acceleration, of which the base has no first three; its own axes."""

    turn: Any  # (3, 3) to the parent's axes
    arm: Any  # (3,) m, from the parent's joint to its own, parent's axes
    in_base: Any  # (3, 3) to base axes
    omega: Any  # (3,) rad/s
    omega_rate: Any  # (3,) rad/s2
    acceleration: Any  # (3,) m/s2 of its joint, and upward gravity


class Effort(NamedTuple):
    """Torques, and the force and moment that the base lacks; zero where the motion is possible."""

    torque: Any  # (J,) Nm or N, of the drives: they move their rotors and overcome friction as well
    force: Any  # (3,) N, base axes
    moment: Any  # (3,) Nm about the base's origin, base axes


class RigidBodies:
    """A robot's links in a tree."""

    def __init__(self, robot: Robot) -> None:
        model, data = robot.model, robot.model.createData()
        self.robot = robot
        pin.computeJointJacobians(model, data, pin.neutral(model))
        self._base = _mass(model, BASE_JOINT)
        self._links = {
            i: _link(model, data, i) for i in range(BASE_JOINT + 1, model.njoints)
        }  # a parent comes before its children
        self.losses = DriveLosses.of(robot)

    def moving(
        self, chain: Sequence[int], position: Any, velocity: Any, base: Moving
    ) -> Iterator[Moving]:
        """The links of a `chain` in motion, base outwards.

        Args:
            chain: their joints, Pinocchio's indices.
            position, velocity: (J,) of the joints.
            base: what the first one hangs on.
        """
        R, p, v, w = base
        for i in chain:
            link = self._links[i]
            turn, arm = _rotation(link, position), _arm(link, position)
            p, R = p + ca.mtimes(R, arm), ca.mtimes(R, turn)
            v, w = ca.mtimes(turn.T, v + cross(w, arm)), ca.mtimes(turn.T, w)
            moves = ca.DM(link.axis) * velocity[link.joint]
            v, w = (v + moves, w) if link.slides else (v, w + moves)
            yield Moving(R, p, v, w)

    def numbers(self, joints: Sequence[int]) -> list[Any]:
        """Everything of some joints and their links, for keys of caches."""
        plain = []
        for link in (self._links[i] for i in joints):
            frame = link.axis, link.rotation, link.origin
            plain.append([np.asarray(v).round(9).tolist() for v in (*frame, *link.own)])
        return plain

    def link(self, joint: int) -> Link:
        """The link that hangs on a joint, Pinocchio's index."""
        return self._links[joint]

    def mass(self, joint: int) -> Mass:
        """Mass of the link that hangs on a joint, Pinocchio's index."""
        return self._links[joint].own

    def inverse_dynamics(
        self,
        position: Any,
        velocity: Any,
        acceleration: Any,
        omega: Any,
        omega_rate: Any,
        base_acceleration: Any,
        mark: Mark = lambda quantity: quantity,
        joints: Sequence[int] | None = None,
    ) -> Effort:
        """Torques of a motion without contacts.

        Args:
            position, velocity, acceleration: (J,) of the joints.
            omega, omega_rate: (3,) rad/s, rad/s2 of the base, base axes.
            base_acceleration: (3,) m/s2 of the base's origin and upward gravity, base axes.
            mark: called with intermediate quantities.
            joints: whole limbs that are looked at, Pinocchio's indices; None: all.
        """
        chosen = self._links if joints is None else {i: self._links[i] for i in joints}
        base = Accelerated(None, None, None, omega, omega_rate, base_acceleration)
        moved = _accelerated(chosen, base, position, velocity, acceleration, mark)
        force, moment = {}, {}
        for i, own in ((BASE_JOINT, self._base), *((i, x.own) for i, x in chosen.items())):
            force[i], moment[i] = _inertial(own, moved[i])
        torque = [ca.SX(0)] * len(self._links)
        for i, link in reversed(chosen.items()):
            force[i], moment[i] = mark(force[i]), mark(moment[i])
            torque[link.joint] = ca.dot(ca.DM(link.axis), force[i] if link.slides else moment[i])
            turn, arm, *_ = moved[i]
            handed = ca.mtimes(turn, force[i])
            force[link.parent] += handed
            moment[link.parent] += ca.mtimes(turn, moment[i]) + cross(arm, handed)
            own = self.losses.torque(link.joint, velocity[link.joint], acceleration[link.joint])
            torque[link.joint] += own
        return Effort(ca.vertcat(*torque), force[BASE_JOINT], moment[BASE_JOINT])

    def chain(self, carrier: int) -> list[int]:
        """Pinocchio's indices of the joints from the base to a link."""
        chain = []
        while carrier != BASE_JOINT:
            chain.append(carrier)
            carrier = self._links[carrier].parent
        return chain[::-1]


def cross(a: Any, b: Any) -> Any:
    """Cross product, (3,)."""
    return ca.vertcat(
        a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
    )


def _mass(model: pin.Model, joint: int) -> Mass:
    own = model.inertias[joint]
    return Mass(float(own.mass), np.array(own.lever), np.array(own.inertia))


def _link(model: pin.Model, data: pin.Data, joint: int) -> Link:
    """Link of a joint whose Jacobian at zero is in the data."""
    moves = pin.getJointJacobian(model, data, joint, pin.LOCAL)[:, model.idx_vs[joint]]
    slides = bool(np.abs(moves[:3]).max() > 0.5)
    axis = moves[:3] if slides else moves[3:]
    placement = model.jointPlacements[joint]
    return Link(
        parent=int(model.parents[joint]),
        joint=int(model.idx_vs[joint]) - 6,
        axis=np.where(np.abs(axis) < _ROUNDING, 0.0, axis),
        slides=slides,
        rotation=np.array(placement.rotation),
        origin=np.array(placement.translation),
        own=_mass(model, joint),
    )


def _constant(values: Array) -> Any:
    """A constant whose zeros are structural."""
    return ca.sparsify(ca.SX(ca.DM(np.where(np.abs(values) < _ROUNDING, 0.0, values))))


def _rotation(link: Link, position: Any) -> Any:
    """(3, 3), from the link's axes to its parent's."""
    if link.slides:
        return _constant(link.rotation)
    x, y, z = link.axis
    along = _constant(np.outer(link.axis, link.axis))
    across = _constant(np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]))
    s, c = ca.sin(position[link.joint]), ca.cos(position[link.joint])
    turn = along + c * ca.sparsify(ca.SX.eye(3) - along) + s * across
    return ca.mtimes(_constant(link.rotation), ca.sparsify(turn))


def _arm(link: Link, position: Any) -> Any:
    """(3,) m, from the parent's joint to the link's, parent's axes."""
    if not link.slides:
        return ca.DM(link.origin)
    return ca.DM(link.origin) + ca.DM(link.rotation @ link.axis) * position[link.joint]


def _accelerated(
    links: Mapping[int, Link],
    base: Accelerated,
    position: Any,
    velocity: Any,
    acceleration: Any,
    mark: Mark,
) -> dict[int, Accelerated]:
    """Base and links by Pinocchio's index, base outwards, from the joints' (J,) motion."""
    moved = {BASE_JOINT: base}
    for i, link in links.items():
        turn, arm, parent = _rotation(link, position), _arm(link, position), moved[link.parent]
        in_base = turn if link.parent == BASE_JOINT else ca.mtimes(parent.in_base, turn)
        axis = _constant(link.axis)
        speed = axis * velocity[link.joint]
        more = axis * acceleration[link.joint]
        inward = cross(parent.omega, cross(parent.omega, arm))
        carried = parent.acceleration + cross(parent.omega_rate, arm) + inward
        carried = ca.mtimes(turn.T, carried)
        turning, rate = (ca.mtimes(turn.T, v) for v in (parent.omega, parent.omega_rate))
        if link.slides:
            w, dw = mark(turning), mark(rate)
            a = mark(carried + more + 2 * cross(w, speed))
        else:
            w = mark(turning + speed)
            dw = mark(rate + more + cross(w, speed))
            a = mark(carried)
        moved[i] = Accelerated(turn, arm, in_base, w, dw, a)
    return moved


def _inertial(own: Mass, moved: Accelerated) -> tuple[Any, Any]:
    """The force and the moment about the joint that a link's motion needs."""
    *_, w, dw, a = moved
    com, inertia = ca.DM(own.com), ca.DM(own.inertia)
    force = own.mass * (a + cross(dw, com) + cross(w, cross(w, com)))
    spin = ca.mtimes(inertia, dw) + cross(w, ca.mtimes(inertia, w))
    return force, spin + cross(com, force)
