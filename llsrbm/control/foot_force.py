"""Contact forces estimated from joint torques and velocities: which feet have found the ground.

In flight a detector sees that something has given the robot an impulse. Feet that meet the ground
pass theirs through the legs; a push on the trunk does not. Over the last `WINDOW`

    J = m (dv + g t)          of the CoM,
    J_feet = sum f dt         measured at the feet,

and it was the ground if enough of J went through the feet: J_feet . J >= SHARE |J|^2. After a push
the detector goes on reporting it for a while, when J is over and both are noise; until the flight
ends, only an impulse that stands out of noise counts.
"""

from collections import deque

import numpy as np
from scipy.linalg.lapack import dposv

from llsrbm.arrays import Array, BoolArray
from llsrbm.control.whole_body import WholeBody
from llsrbm.mechanics import GRAVITY
from llsrbm.robots.drives.torques import friction_torque
from llsrbm.robots.robot import Robot

_BASE = 6
_REGULARISATION = 1e-6 * np.eye(3)  # m2, for legs that are stretched out
_SMOOTHING = 0.5  # share of the newest tick; one tick's difference of noisy velocities is 10 N off
# Of the robot's weight: twice what noise makes of a leg; the trunk's mass is not in its equations.
_TOUCHING = 0.06
_SURE = 2  # ticks in a row
WINDOW = 0.02  # s, the detector's own longest window
SHARE = 0.3  # of ground contacts it is about 1 by the time they are detected, of pushes below 0.1
# m/s of the CoM that feet must have caused after a push: three times what noise makes of the sum.
AFTER_PUSH = 0.03


class FootForces:
    """A leg's joint equations, solved for the force at its foot; known from the second `update` on.

        J^T f = M_leg dv/dt + h_leg + friction - tau_leg

    with the difference of two measured velocities for dv/dt, where those of `body` may be foreseen.
    `tick`: s between updates; `vertical`: (L,) N, smoothed.
    """

    def __init__(self, robot: Robot, body: WholeBody, tick: float) -> None:
        self._robot, self._body, self._tick = robot, body, tick
        self._rows = robot.leg_joint_index + _BASE
        # Each leg's own columns of the feet's Jacobians, (L, 3, n).
        self._columns = (
            np.arange(body.legs)[:, None, None],
            np.arange(3)[None, :, None],
            self._rows[:, None, :],
        )
        # The legs' systems, one block each of one that is solved at a stroke: (3 L, 3 L).
        self._system = np.zeros((3 * body.legs, 3 * body.legs))
        row, column = self._system.strides
        self._blocks = np.lib.stride_tricks.as_strided(
            self._system, (body.legs, 3, 3), (3 * (row + column), row, column)
        )
        self._threshold = _TOUCHING * body.mass * GRAVITY
        self._equations: tuple[Array, Array, Array, Array] | None = None
        self.vertical = np.zeros(body.legs)
        self._impulse = MeasuredImpulse(body.mass, tick)
        self._touching = np.zeros(body.legs, dtype=np.int64)

    def reset(self) -> None:
        """Forget what was measured."""
        self._equations = None
        self.vertical[:] = 0.0
        self._impulse.reset()
        self._touching[:] = 0

    def update(self, torque: Array, v: Array, com_velocity: Array) -> BoolArray:
        """Feet that carry load, (L,). `torque`: (J,) measured, mean of the tick that ended.

        `v`: (n,) measured at its end; `com_velocity`: (3,) m/s likewise.
        """
        body = self._body
        if self._equations is not None:
            M, h, own, before = self._equations
            load = M @ (v - before) / self._tick + h
            load[_BASE:] += friction_torque(self._robot, (before + v)[_BASE:] / 2) - torque
            np.add(own @ own.transpose(0, 2, 1), _REGULARISATION, out=self._blocks)
            right = (own @ load[self._rows][..., None]).ravel()
            _, force, failed = dposv(self._system, right)
            if failed:
                raise np.linalg.LinAlgError("the legs' equations are singular")
            # Not smoothed: the errors of its sum over ticks cancel.
            self._impulse.update(com_velocity, force.reshape(-1, 3).sum(axis=0))
            self.vertical += _SMOOTHING * (force[2::3] - self.vertical)
            above = self.vertical > self._threshold
            self._touching = np.where(above, self._touching + 1, 0)
        self._equations = (body.M, body.h, body.foot_jacobian[self._columns], v.copy())
        return self._touching >= _SURE

    def met_ground(self) -> bool:
        """True if the robot in the air has hit the ground with its feet."""
        return self._impulse.is_ground()


class MeasuredImpulse:
    """Both impulses of one flight of a robot of `mass`, kg; `pushed`: by more than the ground."""

    def __init__(self, mass: float, tick: float) -> None:
        self._mass, self._tick = mass, tick
        self._recent: deque[tuple[Array, Array]] = deque(maxlen=max(2, round(WINDOW / tick) + 1))
        self.pushed = False

    def reset(self) -> None:
        """Begin a flight."""
        self._recent.clear()
        self.pushed = False

    def update(self, com_velocity: Array, feet: Array) -> None:
        """Take a tick's end: (3,) m/s of the CoM, and (3,) N on the feet during the tick."""
        self._recent.append((np.array(com_velocity), feet))

    def is_ground(self) -> bool:
        """True if the reported impulse came from the ground; one that did not is remembered."""
        if len(self._recent) < 2:
            return True
        ticks = len(self._recent) - 1
        shown = self._recent[-1][0] - self._recent[0][0]
        shown[2] += GRAVITY * ticks * self._tick
        shown *= self._mass
        passed = sum((f for _, f in list(self._recent)[1:]), np.zeros(3)) * self._tick
        enough = float(passed @ shown) >= SHARE * float(shown @ shown)
        if self.pushed:
            enough = enough and float(np.linalg.norm(passed)) >= AFTER_PUSH * self._mass
        self.pushed = self.pushed or not enough
        return enough
