"""`FootKinematics`: where a robot's feet are in its base, and how they move, by its joints."""

import numpy as np
import pinocchio as pin

from llsrbm.arrays import Array
from llsrbm.mechanics import cross
from llsrbm.robots import Robot
from llsrbm.robots.feet import foot_contacts

_AXES = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED


class FootKinematics:
    """L feet of c balls each in the base's frame, as if the base stood still in the origin.

    Attributes:
        position: (L c, 3) m: middles of the balls, one of a point foot, those at a sole's corners.
        velocity: (L c, 3) m/s, of them.
        angular_velocity: (L c, 3) rad/s of the feet that they belong to.
        radius: m, of the balls.
        points: c.
    """

    def __init__(self, robot: Robot) -> None:
        contacts = foot_contacts(robot)
        self._frames = [leg.foot_frame_id for leg in robot.legs]
        self._centres = np.array([contact.centres for contact in contacts])
        self._model, self._data = robot.model, robot.model.createData()
        self._q, self._v = pin.neutral(robot.model), np.zeros(robot.model.nv)
        self.radius, self.points = contacts[0].radius, self._centres.shape[1]
        self.position, self.velocity, self.angular_velocity = np.zeros(
            (3, len(contacts) * self.points, 3)
        )

    def update(self, q: Array, dq: Array) -> None:
        """Take the joints' positions (J,) and speeds (J,)."""
        model, data = self._model, self._data
        self._q[7:], self._v[6:] = q, dq
        pin.forwardKinematics(model, data, self._q, self._v)
        for i, frame in enumerate(self._frames):
            foot = pin.updateFramePlacement(model, data, frame)
            motion = pin.getFrameVelocity(model, data, frame, _AXES).vector
            points = slice(i * self.points, (i + 1) * self.points)
            arms = self._centres[i] @ foot.rotation.T
            self.position[points] = foot.translation + arms
            self.velocity[points] = motion[:3] + cross(motion[None, 3:], arms)
            self.angular_velocity[points] = motion[3:]
