"""A safe motion of a hung robot that shows what its drives are: sums of sines, joint by joint.

It is about a posture near the default one in which links have room. Amplitudes end where a stop, a
speed, a torque or another link would come near.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import pinocchio as pin

from llsrbm.arrays import Array
from llsrbm.control.motor_command import MotorCommand
from llsrbm.control.readings import Readings
from llsrbm.errors import InputError
from llsrbm.identification.log import EXCITATION
from llsrbm.player.posture import FirstPosture, Planned
from llsrbm.player.tier import Tier
from llsrbm.robots import Robot
from llsrbm.robots.drives.torques import friction_torque
from llsrbm.robots.link_shapes import LinkShapes

# Hz: slow and fast ones, for friction, damping and rotors; each joint has its own within a band.
_BANDS = ((0.4, 0.7), (1.0, 1.5), (2.0, 3.0))
_FASTER = 2.5  # times these, of joints with little room
_SPEEDS = (1.0, 1.0, 1.0)  # shares of the speed that the tones of a joint have
_WIDEST = 0.5  # rad (m: of what is between its stops) either way of the default posture
_OF_STOPS = 0.6  # share of the way to the nearer stop
_OF_SPEED, _OF_TORQUE = 0.35, 0.35  # shares of the drive's
_ASIDE, _POSTURES, _FAR = 0.35, 400, 0.15  # rad from the default posture, how many, and m
_APART = 0.03  # m between links
_OF_APART = 0.5  # share of the distance in the default posture, where that is less
_LESS, _TRIES = 0.8, 12  # of the amplitudes of joints that bring links near each other
_FADE = 1.0  # s, at both ends
# rad/s at which a joint swings on its loop, critically damped: more where friction that is twice
# the file's would keep the joint from more than a share of its amplitude.
_STIFF, _STIFFEST = 40.0, 80.0
_STUCK = 0.25
_MOST_TORQUE = 0.6  # of the drive's, whatever the readings are
_SEEN = 800  # instants that are checked
SHORTEST, LONGEST = 5.0, 600.0  # s


@dataclass(frozen=True, eq=False)
class Sines:
    """Sums of sines of J joints about a posture, that fade in and out.

    Attributes:
        posture: (J,) rad about which they are; duration: s.
        amplitude, frequency, phase: (J, n) rad, Hz, rad.
    """

    robot: Robot
    posture: Array
    duration: float
    amplitude: Array
    frequency: Array
    phase: Array

    def at(self, time: Array) -> tuple[Array, Array, Array]:
        """(K, J) rad, rad/s and rad/s2 at times (K,) s."""
        rate = 2 * np.pi * self.frequency
        angle = rate * time[:, None, None] + self.phase
        sine, cosine = self.amplitude * np.sin(angle), self.amplitude * np.cos(angle)
        x, v, a = sine.sum(-1), (rate * cosine).sum(-1), -(rate**2 * sine).sum(-1)
        s = np.clip(np.minimum(time, self.duration - time) / _FADE, 0.0, 1.0)[:, None]
        side = np.where(time < self.duration / 2, 1.0, -1.0)[:, None] / _FADE
        inside = s < 1.0
        fade = s**3 * (10 - 15 * s + 6 * s**2)
        slope = inside * side * 30 * (s * (1 - s)) ** 2
        bend = inside * side**2 * 60 * s * (1 - s) * (1 - 2 * s)
        return (
            self.posture + fade * x,
            fade * v + slope * x,
            fade * a + 2 * slope * v + bend * x,
        )

    def scaled(self, share: float | Array) -> Sines:
        """The same with a share of its amplitudes, of all joints or (J,)."""
        amplitude = np.reshape(share, (-1, 1)) * self.amplitude
        return replace(self, amplitude=amplitude)

    @cached_property
    def checked(self) -> tuple[Array, Array, Array]:
        """Positions, speeds and accelerations at the instants that are checked."""
        return self.at(np.linspace(0.0, self.duration, _SEEN))

    @cached_property
    def weight(self) -> Array:
        """(J,) Nm in the posture at rest."""
        still = np.zeros_like(self.posture)
        return _torque(self.robot, self.posture, still, still)

    def torques(self) -> Array:
        """(K, J) Nm at the instants that are checked, the base at rest and level."""
        return np.array([_torque(self.robot, *state) for state in zip(*self.checked, strict=True)])


def sines(robot: Robot, duration: float) -> Sines:
    """An excitation within stops, speeds and torques, links apart.

    Raises `InputError`: a duration out of range, or links that are too near even in small motions.
    """
    if not SHORTEST <= duration <= LONGEST:
        raise InputError(
            f"duration: expected {SHORTEST:g} to {LONGEST:g} s of excitation, got {duration:g}"
        )
    joints = len(robot.joint_names)
    rng = np.random.default_rng(0)  # the same each time
    place = np.array([rng.permutation(joints) for _ in _BANDS]).T / joints
    low, high = np.transpose(_BANDS)
    frequency = low + (high - low) * place
    phase = rng.uniform(0.0, 2 * np.pi, frequency.shape)
    posture = _with_room(robot, rng)
    drawn = Sines(robot, posture, duration, np.array(_SPEEDS) / frequency, frequency, phase)
    found = _apart(_limited(drawn))
    # Joints with little room move faster in it.
    widest = np.abs(found.checked[0] - posture).max(axis=0)
    faster = np.clip(_WIDEST / np.maximum(widest, 1e-9), 1.0, _FASTER)
    return _apart(_limited(replace(found, frequency=faster[:, None] * frequency)))


def _limited(found: Sines) -> Sines:
    """With amplitudes that stops, speeds and torques allow."""
    robot, posture, (lower, upper) = found.robot, found.posture, found.robot.joint_stops
    q, v, _ = found.checked
    room = np.minimum(_WIDEST, _OF_STOPS * np.minimum(posture - lower, upper - posture))
    shares = (
        np.maximum(room, 0.0) / np.abs(q - posture).max(axis=0),
        _OF_SPEED * robot.speed_limit / np.abs(v).max(axis=0),
    )
    found = found.scaled(np.minimum(1.0, np.minimum(*shares)))
    torque = np.abs(found.torques() - found.weight).max(axis=0)
    left = np.maximum(_OF_TORQUE * robot.torque_limit - np.abs(found.weight), 0.0)
    return found.scaled(np.minimum(1.0, left / np.maximum(torque, 1e-9)))


def _with_room(robot: Robot, rng: np.random.Generator) -> Array:
    """(J,) rad: of postures near the default one, the one whose links are farthest apart."""
    shapes, (lower, upper) = LinkShapes.of(robot), robot.joint_stops
    default = robot.posture[7:]
    off = _ASIDE * rng.uniform(-1.0, 1.0, (_POSTURES, len(default)))
    off[0] = 0.0
    tried = np.clip(
        default + off,
        np.minimum(lower + 0.2 * (upper - lower), default),
        np.maximum(upper - 0.2 * (upper - lower), default),
    )
    distances = np.minimum(shapes.near_distances(_level(robot, tried), _FAR), _FAR)
    return tried[int(np.argmax(np.sqrt(np.maximum(distances, 0.0)).sum(axis=1)))]


def _level(robot: Robot, joints: Array) -> Array:
    """(K, nq): the base level, with joints (K, J)."""
    base = np.tile([*robot.posture[:3], 0.0, 0.0, 0.0, 1.0], (len(joints), 1))
    return np.hstack([base, joints])


def _apart(found: Sines) -> Sines:
    """With less of what brings links near each other."""
    robot, shapes = found.robot, LinkShapes.of(found.robot)
    joint_of = {shape.link: shape.joint for shape in shapes.shapes}
    needed = np.minimum(_APART, _OF_APART * shapes.distances(_level(robot, found.posture[None])[0]))
    for _ in range(_TRIES):
        q = _level(robot, found.checked[0])
        near = shapes.near_distances(q, _APART).min(axis=0) < needed
        if not near.any():
            return found
        share = np.ones(len(robot.joint_names))
        for pair in np.flatnonzero(near):
            for link in shapes.pairs[pair]:
                moved = [
                    robot.model.joints[j].idx_v - 6 for j in robot.model.supports[joint_of[link]]
                ]
                share[[k for k in moved if k >= 0]] = _LESS
        found = found.scaled(share)
    raise InputError(
        f"{robot.name}: its links come near each other even in small motions about its default "
        "posture; expected a posture with room"
    )


class Excitation(Tier):
    """Plays an excitation on a robot that hangs, by torques alone.

    Loops of the motors' own would close after a time that nobody knows: with 60 Nm/rad a quarter of
    a millisecond is as much as a drive's damping. So the loops are closed here, softly, as commands
    come late.
    """

    name = EXCITATION

    def __init__(self, robot: Robot, duration: float) -> None:
        """Raises `InputError`, as `sines`."""
        self.sines = sines(robot, duration)
        first = _level(robot, self.sines.posture[None])[0]
        super().__init__(robot, FirstPosture(first, self.sines.weight))
        # Of all joints together: on loops of their own two in a row swing faster than either.
        M = np.triu(pin.crba(robot.model, robot.model.createData(), first))[6:, 6:]
        M = M + np.triu(M, 1).T
        widest = np.abs(self.sines.checked[0] - self.sines.posture).max(axis=0)
        moves = np.sqrt(robot.friction / (_STUCK * np.maximum(widest, 1e-9) * np.diag(M)))
        D = np.diag(np.clip(moves, _STIFF, _STIFFEST))
        self._kp, self._kd = D @ M @ D, D @ M + M @ D
        self._planned = self.first.planned

    @property
    def end(self) -> float:
        return self.sines.duration

    def command(self, time: float, readings: Readings) -> MotorCommand:
        q, v, a = (each[0] for each in self.sines.at(np.array([time])))
        self._planned = Planned(q, self.first.planned.up)
        torque = _torque(self.robot, q, v, a)
        torque += self._kp @ (q - readings.q) + self._kd @ (v - readings.dq)
        most = _MOST_TORQUE * self.robot.torque_limit
        return MotorCommand.of_torque(np.clip(torque, -most, most))

    def planned(self, time: float) -> Planned:
        del time
        return self._planned


def _torque(robot: Robot, q: Array, v: Array, a: Array) -> Array:
    """(J,) Nm by inverse dynamics and friction, the base at rest and level."""
    still, data = np.zeros(6), robot.model.createData()
    torque = pin.rnea(
        robot.model, data, _level(robot, q[None])[0], np.array([*still, *v]), np.array([*still, *a])
    )
    return np.array(torque[6:]) + friction_torque(robot, v)
