"""Accelerations with which joints stay short of their stops and below their drives' speeds.

A joint that is a distance d away from its stop, less a margin, comes to rest in time if its speed w
towards it keeps to

    w^2 <= 2 A d,    A = `BRAKING` of the drive's torque / M_jj,

with the inertia that the drive moves while the other joints are held. The bound is on the
acceleration that leads there within `REACTION`: at w' = w - a T and d' = d - T (w + w') / 2. Beyond
the margin the joint returns within `RETURN`.
"""

import numpy as np

from llsrbm.arrays import Array
from llsrbm.control.whole_body import WholeBody
from llsrbm.robots import Robot

# Share of the drive's torque at rest. With half of it, joints with rotors that end a push near a
# stop slow down before the feet leave, and robots twist off tilted.
BRAKING = 0.9
SPEED = 1.1  # of the drive's; plans may reach it at lift-off, and held to it robots jump too low
REACTION = 0.005  # s; torques come up to a tick late, and measured speeds are noisy
RETURN = 0.02  # s
_BOTH = np.array([[1.0], [-1.0]])  # towards the lower stop and the upper one


class JointBounds:
    """Bounds on the joints' accelerations of a robot as the controller believes it is."""

    def __init__(self, robot: Robot) -> None:
        lower, upper = robot.kept_stops
        self._stops = np.stack([lower, -upper])
        self._torque = BRAKING * robot.torque_limit
        self._speed = SPEED * robot.speed_limit

    def accelerations(self, body: WholeBody) -> tuple[Array, Array]:
        """Lowest and highest, (J,) each, rad/s2 or m/s2, for the body's present state.

        Bounds that exclude each other change places: anything between them is allowed.
        """
        q, v = body.q[7:], body.v[6:]
        braking = self._torque / body.M.diagonal()[6:]
        left, rate = _BOTH * q - self._stops, _BOTH * v
        least = least_acceleration(left, rate, braking, self._speed)
        return np.minimum(least[0], -least[1]), np.maximum(-least[1], least[0])


def least_acceleration(
    left: Array, rate: Array, braking: Array, fastest: Array | float = np.inf
) -> Array:
    """Least second derivative of distances of which `left` is left, `rate` their derivative.

    `braking`: what the drives can give it; `fastest`: towards nothing.
    """
    T = REACTION
    room, reach = 2 * left + T * rate, braking * T
    free = (np.sqrt(reach**2 + 4 * braking * np.maximum(room, 0.0)) - reach) / 2
    towards = np.where(room > 0, free, np.maximum(room / (2 * RETURN), -reach))
    return (-np.minimum(towards, fastest) - rate) / T
