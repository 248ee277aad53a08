"""The motion over an interval, as expressions: what the accelerations at its nodes lead to."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any

import casadi as ca

from llsrbm.models.rigid_bodies import Mark, cross
from llsrbm.ocp.composition import Derived
from llsrbm.ocp.lifting import Lifting
from llsrbm.planning.problem.rotations import quat_exp, quat_product
from llsrbm.planning.whole_body.chain import split
from llsrbm.planning.whole_body.sizes import NODES, accelerations, line, moving

JOINTS = ("joint_position", "joint_velocity", "joint_acceleration")


@lru_cache(maxsize=32)
def pose_at(joints: int, share: float) -> Derived:
    """The moving part of the state at a share of an interval, as a function of it at the start, of
    the accelerations at one node after the other, and of the step, s.
    """
    state, rates = moving(joints), accelerations(joints)
    controls = {f"{name} {k}": n for k in range(len(NODES)) for name, n in rates.items()}
    sizes = {**state, **controls, "step": 1}
    v = ca.SX.sym("v", sum(sizes.values()))
    x, mark = split(v, sizes), Lifting(v)
    nodes = [{name: x[f"{name} {k}"] for name in rates} for k in range(len(NODES))]
    over = _Interval({name: x[name] for name in state}, nodes, x["step"], mark)
    after = ca.vertcat(*over.moved(share).values())
    return Derived(f"pose_{round(100 * share)}", v, ca.SX(0, 1), after, mark)


class _Interval:
    """From a knot's state (name -> expression) over `step`, s, under the controls of each node."""

    def __init__(
        self, state: Mapping[str, Any], controls: Sequence[Mapping[str, Any]], step: Any, mark: Mark
    ) -> None:
        self._state, self._controls, self._step, self._mark = state, controls, step, mark

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

    def _weighed(self, name: str, weights: Any) -> Any:
        return sum(float(w) * u[name] for w, u in zip(weights, self._controls, strict=True))

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
