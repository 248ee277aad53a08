"""Arms: limbs that never stand, as functions of their joint angles.

Where a hand is matters to nobody, so an arm's coordinates are its joints, not the hand's place: the
links of the URDF say exactly where its mass is and what its drives must give. Maps fitted over the
hand's place, as legs have them, miss the arm's CoM by centimetres over a shoulder's range, and end
at the stretched elbow (docs/maths.md).

Base axes, seen from the base's origin, unless a name says otherwise. Angles are those of all arms'
joints one after another, (A n, 1), `Robot.arm_joint_index`.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import casadi as ca

from llsrbm.models.rigid_bodies import Moving, RigidBodies, cross
from llsrbm.robots.robot import Robot

Matrix = Any  # casadi.SX or casadi.DM
Lift = Callable[[Matrix], Matrix]


class _Link(NamedTuple):
    mass: float  # kg
    inertia: ca.DM  # (3, 3) kg m2 about its CoM, its own axes
    rotation: Matrix  # (3, 3) to base axes
    com: Matrix  # (3, 1) m
    velocity: Matrix  # (3, 1) m/s of the CoM against the base
    omega: Matrix  # (3, 1) rad/s against the base, the link's axes


@dataclass(frozen=True, eq=False)
class Carried:
    """The arms' links in motion against the base that carries them."""

    links: tuple[_Link, ...]

    @property
    def moment(self) -> Matrix:
        """Sum of m c, (3, 1) kg m."""
        return sum(link.mass * link.com for link in self.links)

    @property
    def moment_rate(self) -> Matrix:
        """Its time derivative in base axes, (3, 1) kg m/s."""
        return sum(link.mass * link.velocity for link in self.links)

    def inertia(self, offset: Matrix) -> Matrix:
        """Sum of m P(c + o) + R I R^T, (3, 3) kg m2."""
        total = ca.SX.zeros(3, 3)
        for link in self.links:
            a = link.com + offset
            total += link.mass * (ca.dot(a, a) * ca.DM.eye(3) - ca.mtimes(a, a.T))
            total += ca.mtimes([link.rotation, link.inertia, link.rotation.T])
        return total

    def momentum(self, omega: Matrix, offset: Matrix, lift: Lift) -> Matrix:
        """Sum of m a x (omega x a + v) + R I (R^T omega + w), a = c + o, (3, 1) kg m2/s."""
        total = ca.SX.zeros(3)
        for link in self.links:
            a = lift(link.com + offset)
            total += link.mass * cross(a, cross(omega, a) + link.velocity)
            turning = ca.mtimes(link.rotation.T, omega) + link.omega
            total += ca.mtimes(link.rotation, ca.mtimes(link.inertia, turning))
        return total


class Arms:
    """The arms of a robot that has some.

    Attributes:
        joints: A n; mass: of all of them, kg.
        at_rest: (A n,) rad, as they hang.
        torque_limit, speed_limit: (A n,) Nm, rad/s.
    """

    def __init__(self, robot: Robot) -> None:
        self._bodies = RigidBodies(robot)
        self._chains = [list(arm.joint_ids) for arm in robot.arms]
        self._index = robot.arm_joint_index
        self.joints = len(self._index)
        self._all_joints = len(robot.joint_names)
        every = [joint for chain in self._chains for joint in chain]
        self.mass = float(sum(self._bodies.mass(joint).mass for joint in every))
        self.at_rest = robot.arm_angles
        self.torque_limit = robot.torque_limit[self._index]
        self.speed_limit = robot.speed_limit[self._index]

    def numbers(self) -> dict[str, Any]:
        """Everything that was computed from the robot, for keys of caches."""
        limits = self.torque_limit.tolist(), self.speed_limit.tolist()
        links = [self._bodies.numbers(chain) for chain in self._chains]
        return {"links": links, "limits": limits, "losses": self._bodies.losses.numbers()}

    def carried(self, angles: Matrix, rates: Matrix, lift: Lift) -> Carried:
        """The links at joint angles and their rates, (A n, 1) rad, rad/s."""
        position, velocity = self._of_all(angles), self._of_all(rates)
        base = Moving(ca.SX.eye(3), ca.SX.zeros(3), ca.SX.zeros(3), ca.SX.zeros(3))
        links = []
        for chain in self._chains:
            moving = self._bodies.moving(chain, position, velocity, base)
            for joint, (R, p, v, w) in zip(chain, moving, strict=True):
                own = self._bodies.mass(joint)
                com = lift(p + ca.mtimes(R, ca.DM(own.com)))
                speed = lift(ca.mtimes(R, v + cross(w, ca.DM(own.com))))
                links.append(_Link(own.mass, ca.DM(own.inertia), R, com, speed, w))
        return Carried(tuple(links))

    def torques(
        self,
        angles: Matrix,
        rates: Matrix,
        accelerations: Matrix,
        omega: Matrix,
        omega_rate: Matrix,
        specific_force: Matrix,
        lift: Lift,
    ) -> Matrix:
        """(A n, 1) Nm by inverse dynamics on a moving base.

        Args:
            angles, rates, accelerations: (A n, 1) rad and so on.
            omega, omega_rate: (3, 1) rad/s, rad/s2 of the base; specific_force: (3, 1) m/s2 on its
                origin; base axes.
            lift: marks intermediate quantities.
        """
        effort = self._bodies.inverse_dynamics(
            self._of_all(angles),
            self._of_all(rates),
            self._of_all(accelerations),
            omega=omega,
            omega_rate=omega_rate,
            base_acceleration=specific_force,
            mark=lift,
            joints=[joint for chain in self._chains for joint in chain],
        )
        return effort.torque[self._index.tolist()]

    def _of_all(self, values: Matrix) -> Matrix:
        """(J, 1): the arms' values, zeros for legs."""
        joints = ca.SX.zeros(self._all_joints)
        joints[self._index.tolist()] = values
        return joints
