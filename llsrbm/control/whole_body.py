"""Everything a control tick needs to know about the robot's dynamics, from Pinocchio."""

import numpy as np
import pinocchio as pin
from scipy.linalg.lapack import dgesv  # a third of the time of NumPy's solve

from llsrbm.arrays import Array
from llsrbm.robots import Robot
from llsrbm.robots.feet import foot_contacts

_UP = np.array([0.0, 0.0, 1.0])
# v @ _SKEW, as a 3 x 3 matrix, times w is v x w.
_SKEW = np.array([pin.skew(axis).ravel() for axis in np.eye(3)])


def solved(A: Array, b: Array) -> Array:
    """The solution x of A x = b. Raises `numpy.linalg.LinAlgError`: A is singular."""
    _, _, x, failed = dgesv(A, b)
    if failed:
        raise np.linalg.LinAlgError("the inertia is singular or not finite")
    return np.asarray(x)


class WholeBody:
    """The robot as the controller believes it is: n = 6 + J velocities, L legs; world frame.

    Velocities and accelerations of the base are Pinocchio's: of its origin, in its own axes.

    Attributes:
        mass: kg.
        M: (n, n) mass matrix; h: (n,) Coriolis, centrifugal and gravity terms.
        com, com_velocity: (3,) m, m/s.
        angular_momentum: (3,) kg m2/s about the CoM; inertia: (3, 3) kg m2, whole body's.
        momentum_matrix: (6, n) linear, angular; momentum_bias: (6,) its rate at zero acceleration.
        R_world_base: (3, 3); angular_velocity: (3,) rad/s of the base.
        foot: (L, 3) m: lowest points of the feet, of soles the place below their frames; velocity,
            Jacobian (L, 3, n) and bias (L, 3) m/s2 are those of `FootContact.middle`, above it.
        R_world_foot: (L, 3, 3); foot_angular_velocity: (L, 3) rad/s; foot_rotation_jacobian:
            (L, 3, n); foot_rotation_bias: (L, 3) rad/s2.
        contact_jacobian: (C, 3, n): of the points that touch the ground, c a foot.
        contact_bias: (C, 3) m/s2: `contact_jacobian @ a + contact_bias` is zero while the spheres
            roll without slipping.
        contact_velocity: (C, 3) m/s of the points that touch.
        normals: (L, 3) unit, of what the feet stand on.
        data: Pinocchio's, with the bodies' placements, velocities, accelerations while no joint nor
            the base accelerates, and the joints' Jacobians.
    """

    def __init__(self, robot: Robot) -> None:
        model = robot.model.copy()
        contacts = foot_contacts(robot)
        self._frames, corners = [], []
        for leg, contact in zip(robot.legs, contacts, strict=True):
            foot = model.frames[leg.foot_frame_id]
            corners.append(contact.centres - contact.middle)
            frame = pin.Frame(
                f"{leg.foot_frame}/middle",
                foot.parentJoint,
                foot.placement * pin.SE3(np.eye(3), contact.middle),
                pin.FrameType.OP_FRAME,
            )
            self._frames.append(model.addFrame(frame))
        self._model, self.data = model, model.createData()
        n, legs = model.nv, len(contacts)
        points = legs * len(robot.corners)
        self._no_acceleration = np.zeros(n)
        self._below_diagonal = np.tril(np.ones((n, n), dtype=bool), -1)
        trunk = model.inertias[1]
        self._trunk_mass, self._trunk_inertia = trunk.mass, np.array(trunk.inertia)
        self._trunk_lever, self._trunk_lever_skew = np.array(trunk.lever), pin.skew(trunk.lever)
        self.velocities = n
        self.legs = legs
        self.mass = robot.mass
        self.contacts = points
        # (L, c, 3): from the middle of a foot's spheres to their centres.
        self._corners = np.array(corners)
        self._has_soles = bool(self._corners.any())
        radii = np.array([contact.radius for contact in contacts])[:, None]
        self._below, self._radii = radii * _UP, radii  # (L, 3), (L, 1) m
        # (L, c, 3, 6): from the motion of a foot's middle to that of its points that touch.
        self._rolling = np.zeros((legs, len(robot.corners), 3, 6))
        self._rolling[..., :3] = np.eye(3)
        self.stand_on(np.tile(_UP, (legs, 1)))

        self.q = np.zeros(model.nq)
        self.v = np.zeros(n)
        self.M = np.zeros((n, n))
        self.h = np.zeros(n)
        self.com, self.com_velocity, self.angular_momentum = np.zeros((3, 3))
        self.inertia = np.eye(3)
        self.momentum_matrix, self.momentum_bias = np.zeros((6, n)), np.zeros(6)
        self.R_world_base, self.angular_velocity = np.eye(3), np.zeros(3)
        # What is known of the feet's middles, linear over angular: Jacobian, velocity, bias.
        self._placement = np.zeros((legs, 4, 4))
        self._middle = np.zeros((legs, 6, n + 2))
        self._middle_rows = self._middle.reshape(6 * legs, n + 2)
        self.foot, self.R_world_foot = np.zeros((legs, 3)), self._placement[:, :3, :3]
        linear, angular = self._middle[:, :3], self._middle[:, 3:]
        self.foot_jacobian, self.foot_rotation_jacobian = linear[..., :n], angular[..., :n]
        self.foot_velocity, self.foot_angular_velocity = linear[..., n], angular[..., n]
        self.foot_bias, self.foot_rotation_bias = linear[..., n + 1], angular[..., n + 1]
        self.contact_jacobian = np.zeros((points, 3, n))
        self.contact_bias, self.contact_velocity = np.zeros((2, points, 3))

    def stand_on(self, normals: Array) -> None:
        """Let feet touch what has these unit normals (L, 3) from the next state on."""
        self.normals = normals
        # (L, 1, 3): from the point by which a sphere touches to its centre.
        self._radius = (self._radii * normals)[:, None]
        if not self._has_soles:
            self._rolling[..., 3:] = (self._radius @ _SKEW).reshape(self.legs, 1, 3, 3)

    def update(self, q: Array, v: Array) -> None:
        """Take a state: q (nq,) and v (n,), Pinocchio's conventions."""
        model, data = self._model, self.data
        self.q, self.v = q, v
        pin.crba(model, data, q)
        self.M = M = data.M.copy()  # above the diagonal
        np.copyto(M, M.T, where=self._below_diagonal)
        self.h = pin.nonLinearEffects(model, data, q, v).copy()
        pin.dccrba(model, data, q, v)
        self.momentum_matrix = data.Ag
        self.momentum_bias = data.dAg @ v
        self.com, self.com_velocity = data.com[0], data.vcom[0]
        self.angular_momentum, self.inertia = data.hg.angular, data.Ig.inertia
        # nonLinearEffects leaves gravity in data.a, which the frames' accelerations would show.
        pin.forwardKinematics(model, data, q, v, self._no_acceleration)
        pin.computeJointJacobians(model, data)
        self.R_world_base = data.oMi[1].rotation
        self.angular_velocity = self.R_world_base @ v[3:6]
        self._update_feet()

    def update_momentum(self, q: Array, v: Array) -> None:
        """Take a state as `update` does, of which only momenta, inertia and the trunk are asked."""
        self.q, self.v, data = q, v, self.data
        pin.ccrba(self._model, data, q, v)
        self.com, self.com_velocity = data.com[0], data.hg.linear / self.mass
        self.angular_momentum, self.inertia = data.hg.angular.copy(), data.Ig.inertia
        self.R_world_base = data.oMi[1].rotation

    def moved(self, q: Array, by: Array) -> Array:
        """(nq,) the configuration q (nq,), moved by (n,): a velocity times a time."""
        return np.asarray(pin.integrate(self._model, q, by))

    @property
    def trunk_momentum(self) -> Array:
        """(6,) kg m/s, kg m2/s: linear, angular about the CoM, of the trunk relative to the CoM."""
        R, omega = self.R_world_base, self.v[3:6]
        velocity = R.dot(self.v[:3] - self._trunk_lever_skew.dot(omega))
        linear = self._trunk_mass * (velocity - self.com_velocity)
        arm = self.data.oMi[1].translation + R.dot(self._trunk_lever) - self.com
        spin = R.dot(self._trunk_inertia.dot(omega))
        return np.concatenate([linear, spin + arm.dot(_SKEW).reshape(3, 3).dot(linear)])

    def _update_feet(self) -> None:
        model, data = self._model, self.data
        axes = pin.LOCAL_WORLD_ALIGNED
        n, middle, placement = self.velocities, self._middle, self._placement
        jacobian, bias = middle[..., :n], middle[..., n + 1]
        for i, frame in enumerate(self._frames):
            placement[i] = pin.updateFramePlacement(model, data, frame).homogeneous
            jacobian[i] = pin.getFrameJacobian(model, data, frame, axes)
            bias[i] = pin.getFrameClassicalAcceleration(model, data, frame, axes).vector
        rows = self._middle_rows
        rows[:, n] = rows[:, :n].dot(self.v)
        self.foot = placement[:, :3, 3] - self._below
        if self._has_soles:
            # From the middle to a sphere's centre, which turns with the foot, and from there down
            # to the ground, which does not: spheres that roll.
            arms = self._corners @ self.R_world_foot.transpose(0, 2, 1)
            self._rolling[..., 3:] = ((self._radius - arms) @ _SKEW).reshape(*arms.shape, 3)
        legs, points = self.legs, self.contacts
        touching = (self._rolling.reshape(legs, -1, 6) @ middle).reshape(points, 3, n + 2)
        self.contact_jacobian, self.contact_velocity = touching[..., :n], touching[..., n]
        self.contact_bias = touching[..., n + 1]
        if self._has_soles:
            turning = (self.foot_angular_velocity @ _SKEW).reshape(legs, 3, 3)
            inward = arms @ (turning @ turning)  # omega x (omega x arm), by a symmetric matrix
            self.contact_bias += inward.reshape(points, 3)
