"""`FootKinematics`: where a robot's feet are in its base, and how they move, by its joints."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from llsrbm.robots import Robot
from llsrbm.robots.feet import foot_contacts

Array = NDArray[np.float64]

_AXES = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED


class FootKinematics:
    """L feet in the base's frame, as the base stood still in the origin.

    Attributes:
        position: (L, 3) m: middles of the balls of each foot; of a sole, of its corners.
        velocity: (L, 3) m/s, of them.
        angular_velocity: (L, 3) rad/s of the feet.
        radius: m: of the balls, by which these middles are above the ground.
        half_length: m: from a sole's middle to its corners; 0 for point feet.
    """

    def __init__(self, robot: Robot) -> None:
        model = robot.model.copy()
        contacts = foot_contacts(robot)
        self._frames = []
        for leg, contact in zip(robot.legs, contacts, strict=True):
            foot, middle = model.frames[leg.foot_frame_id], contact.centres.mean(axis=0)
            frame = pin.Frame(
                f"{leg.foot_frame}/middle",
                foot.parentJoint,
                foot.placement * pin.SE3(np.eye(3), middle),
                pin.FrameType.OP_FRAME,
            )
            self._frames.append(model.addFrame(frame))
        self._model, self._data = model, model.createData()
        self._q, self._v = pin.neutral(model), np.zeros(model.nv)
        self.radius = contacts[0].radius
        centres = contacts[0].centres
        self.half_length = float(np.linalg.norm(centres - centres.mean(axis=0), axis=1).max())
        self.position, self.velocity, self.angular_velocity = np.zeros((3, len(contacts), 3))

    def update(self, q: Array, dq: Array) -> None:
        """Take the joints' positions (J,) and speeds (J,)."""
        model, data = self._model, self._data
        self._q[7:], self._v[6:] = q, dq
        pin.forwardKinematics(model, data, self._q, self._v)
        for i, frame in enumerate(self._frames):
            self.position[i] = pin.updateFramePlacement(model, data, frame).translation
            motion = pin.getFrameVelocity(model, data, frame, _AXES).vector
            self.velocity[i], self.angular_velocity[i] = motion[:3], motion[3:]
