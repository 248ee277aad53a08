"""The motion over an interval, as expressions: what the accelerations at its nodes lead to."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca

from llsrbm.models.rigid_bodies import Mark, cross
from llsrbm.planning.problem.rotations import quat_exp, quat_product, rotation_matrix
from llsrbm.planning.whole_body.sizes import line

JOINTS = ("joint_position", "joint_velocity", "joint_acceleration")


@dataclass(frozen=True, eq=False)
class Pose:
    """The whole body at an instant.

    Attributes:
        position, velocity: (3,) m, m/s of the base's origin in the world.
        quat: (4,) w, x, y, z; R: (3, 3) base axes to the world's.
        omega: (3,) rad/s, base axes; joint_position, joint_velocity: (J,).
    """

    position: Any
    quat: Any
    joint_position: Any
    velocity: Any
    omega: Any
    joint_velocity: Any
    R: Any

    @classmethod
    def of(cls, state: Mapping[str, Any], mark: Mark) -> Pose:
        """The pose of a state, name -> expression."""
        moving = {n: v for n, v in state.items() if n != "durations"}
        return cls(**moving, R=mark(rotation_matrix(state["quat"])))


class Interval:
    """From a knot's state (name -> expression) over `step`, s, under the controls of each node."""

    def __init__(
        self, state: Mapping[str, Any], controls: Sequence[Mapping[str, Any]], step: Any, mark: Mark
    ) -> None:
        self._state, self.controls, self._step, self._mark = state, controls, step, mark
        self._poses: dict[float, Pose] = {}

    def at(self, share: float) -> Pose:
        """The pose at a share of it."""
        if share not in self._poses:
            state = {name: self._mark(values) for name, values in self.moved(share).items()}
            self._poses[share] = Pose.of(state, self._mark)
        return self._poses[share]

    def moved(self, share: float) -> dict[str, Any]:
        """The moving part of the state at a share of it."""
        return {
            "position": self._moved("position", "velocity", "acceleration", share),
            "quat": self._attitude(share),
            "joint_position": self._moved(*JOINTS, share),
            "velocity": self._sped("velocity", "acceleration", share),
            "omega": self._sped("omega", "omega_rate", share),
            "joint_velocity": self._sped(*JOINTS[1:], share),
        }

    def mixed(self, name: str, share: float) -> Any:
        """A control of this name at a share of it."""
        return self._weighed(name, line(share)[0])

    def _weighed(self, name: str, weights: Any) -> Any:
        return sum(float(w) * u[name] for w, u in zip(weights, self.controls, strict=True))

    def _moved(self, position: str, velocity: str, acceleration: str, share: float) -> Any:
        twice = self._weighed(acceleration, line(share)[2])
        straight = self._step * share * self._state[velocity]
        return self._state[position] + straight + self._step**2 * twice

    def _sped(self, velocity: str, acceleration: str, share: float) -> Any:
        return self._state[velocity] + self._step * self._weighed(acceleration, line(share)[1])

    def _attitude(self, share: float) -> Any:
        """The quaternion at a share of the interval."""
        omega, step = self._state["omega"], self._step
        turn = step * share * omega + step**2 * self._weighed("omega_rate", line(share)[2])
        # Turns in different directions do not add up: Magnus' second term, of the mean rate.
        mean = self._weighed("omega_rate", line(share)[1]) / share if share else ca.SX.zeros(3)
        turn += (step * share) ** 3 / 12 * cross(omega, mean)
        return quat_product(self._state["quat"], quat_exp(self._mark(turn)))


def turned(quat: Any, reference: Any) -> Any:
    """(3,) rad, about, from one attitude to another, both (4,)."""
    return 2 * quat_product(ca.vertcat(reference[0], -reference[1:]), quat)[1:]
