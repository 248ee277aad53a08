"""Everything a control tick needs to know about the robot's dynamics, from Pinocchio."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from llsrbm.robots import Robot
from llsrbm.robots.foot_contact import foot_contacts

Array = NDArray[np.float64]

_UP = np.array([0.0, 0.0, 1.0])
# v @ _SKEW, as a 3 x 3 matrix, times w is v x w.
_SKEW = np.array([pin.skew(axis).ravel() for axis in np.eye(3)])


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
        foot: (L, 3) m: lowest points of the feet, in the middle of each foot's spheres; velocity,
            Jacobian (L, 3, n) and bias (L, 3) m/s2 are those of the middle of their centres.
        R_world_foot: (L, 3, 3); foot_angular_velocity: (L, 3) rad/s; foot_rotation_jacobian:
            (L, 3, n); foot_rotation_bias: (L, 3) rad/s2.
        contact_jacobian: (C, 3, n): of the points that touch the ground, c a foot.
        contact_bias: (C, 3) m/s2: `contact_jacobian @ a + contact_bias` is zero while the spheres
            roll without slipping.
        contact_velocity: (C, 3) m/s of the points that touch.
    """

    def __init__(self, robot: Robot) -> None:
        """Nothing is known before the first `update`."""
        model = robot.model.copy()
        contacts = foot_contacts(robot)
        self._frames, self._corners = [], []
        for leg, contact in zip(robot.legs, contacts, strict=True):
            foot = model.frames[leg.foot_frame_id]
            middle = contact.centres.mean(axis=0)
            self._corners.append(contact.centres - middle)
            frame = pin.Frame(
                f"{leg.foot_frame}/middle",
                foot.parentJoint,
                foot.placement * pin.SE3(np.eye(3), middle),
                pin.FrameType.OP_FRAME,
            )
            self._frames.append(model.addFrame(frame))
        self._model, self._data = model, model.createData()
        n, legs = model.nv, len(contacts)
        points = legs * len(robot.corners)
        self._no_acceleration = np.zeros(n)
        self._lower = np.tril_indices(n, -1)
        self.velocities = n
        self.legs = legs
        self.mass = robot.mass
        self.contacts = points
        self._radius = [contact.radius for contact in contacts]

        self.q = np.zeros(model.nq)
        self.v = np.zeros(n)
        self.M = np.zeros((n, n))
        self.h = np.zeros(n)
        self.com, self.com_velocity, self.angular_momentum = np.zeros((3, 3))
        self.inertia = np.eye(3)
        self.momentum_matrix, self.momentum_bias = np.zeros((6, n)), np.zeros(6)
        self.R_world_base, self.angular_velocity = np.eye(3), np.zeros(3)
        self.foot, self.foot_velocity, self.foot_bias = np.zeros((3, legs, 3))
        self.foot_angular_velocity, self.foot_rotation_bias = np.zeros((2, legs, 3))
        self.foot_jacobian, self.foot_rotation_jacobian = np.zeros((2, legs, 3, n))
        self.R_world_foot = np.zeros((legs, 3, 3))
        self.contact_jacobian = np.zeros((points, 3, n))
        self.contact_bias, self.contact_velocity = np.zeros((2, points, 3))

    def update(self, q: Array, v: Array) -> None:
        """Take a state: q (nq,) and v (n,), Pinocchio's conventions."""
        model, data = self._model, self._data
        self.q, self.v = q, v
        pin.crba(model, data, q)
        M = data.M
        M[self._lower] = M.T[self._lower]
        self.M = M
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

    def _update_feet(self) -> None:
        model, data = self._model, self._data
        axes = pin.LOCAL_WORLD_ALIGNED
        for i, frame in enumerate(self._frames):
            placement = pin.updateFramePlacement(model, data, frame)
            jacobian = pin.getFrameJacobian(model, data, frame, axes)
            velocity = pin.getFrameVelocity(model, data, frame, axes)
            bias = pin.getFrameClassicalAcceleration(model, data, frame, axes)
            radius, R, omega = self._radius[i] * _UP, placement.rotation, velocity.angular
            self.foot[i] = placement.translation - radius
            self.foot_jacobian[i], self.foot_rotation_jacobian[i] = jacobian[:3], jacobian[3:]
            self.foot_velocity[i], self.foot_bias[i] = velocity.linear, bias.linear
            self.R_world_foot[i] = R
            self.foot_angular_velocity[i], self.foot_rotation_bias[i] = omega, bias.angular
            # From the middle to a sphere's centre, which turns with the foot, and from there down
            # to the ground, which does not: spheres that roll.
            arms = self._corners[i] @ R.T
            levers = ((radius - arms) @ _SKEW).reshape(-1, 3, 3)
            points = slice(i * len(arms), (i + 1) * len(arms))
            self.contact_jacobian[points] = jacobian[:3] + levers @ jacobian[3:]
            self.contact_velocity[points] = velocity.linear + levers @ omega
            self.contact_bias[points] = bias.linear + levers @ bias.angular
            inward = (arms @ omega)[:, None] * omega - (omega @ omega) * arms
            self.contact_bias[points] += inward
