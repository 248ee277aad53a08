"""A motion of the whole-body problem at any instant, in numbers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from llsrbm.mechanics import apply, cross, rotation_matrices
from llsrbm.planning.whole_body.grid import SAME_INSTANT, Grid
from llsrbm.planning.whole_body.sizes import NODES, Sizes, line, parts

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Instants:
    """The whole body at K instants, in Pinocchio's convention."""

    q: Array  # (K, nq)
    v: Array  # (K, nv)
    a: Array  # (K, nv)
    force: Array  # (K, C, 3) N at the contact points, world axes


@dataclass(frozen=True, eq=False)
class Motion:
    """N intervals between N + 1 knots; straight lines through the nodes' values over each.

    Attributes:
        time: (N + 1,) s.
        state: name -> (N + 1, n) at the knots; rates: name -> (N, nodes, n) at the nodes.
        force: (N, nodes, C, 3) N.
    """

    time: Array
    state: dict[str, Array]
    rates: dict[str, Array]
    force: Array

    @classmethod
    def of(cls, variables: Array, grid: Grid, sizes: Sizes) -> Motion:
        """The motion of a solution's variables."""
        states, rates = [], []
        force = np.zeros((grid.intervals, len(NODES), sizes.legs, 3 * sizes.corners))
        end = 0
        for k, knot in enumerate(grid.knots):
            start, end = end, end + sizes.states + sizes.controls(knot)
            own, controls = np.split(variables[start:end] * sizes.unit(knot), [sizes.states])
            states.append(own)
            if knot.last:
                break
            of_node = sizes.node(len(knot.standing))
            for node, values in enumerate(np.split(controls, len(NODES))):
                at = parts(values, of_node)
                rates.append(np.concatenate([at[name] for name in sizes.motion]))
                force[k, node, list(knot.standing)] = at["force"].reshape(-1, 3 * sizes.corners)
        shape = grid.intervals, len(NODES)
        state = parts(np.array(states), sizes.state)
        edges = np.concatenate([[0.0], np.cumsum(state["durations"][0])])
        return cls(
            time=grid.times(edges)[::2],
            state=state,
            rates=parts(np.array(rates).reshape(*shape, -1), sizes.motion),
            force=force.reshape(*shape, -1, 3),
        )

    @property
    def durations(self) -> Array:
        """(P,) s of the phases."""
        return self.state["durations"][0]

    def at(self, time: Array) -> Instants:
        """At instants (K,) s; where two intervals meet, the later one counts."""
        return self.within(*self._intervals(time))

    def between(self, at_nodes: Array, time: Array) -> Array:
        """Values (K, n) at instants (K,) s of lines through those at the nodes, (N nodes, n)."""
        k, share = self._intervals(time)
        values = at_nodes.reshape(len(self.force), len(NODES), -1)[k]
        found: Array = np.einsum("nk,kni->ki", line(share)[0], values)
        return found

    def _intervals(self, time: Array) -> tuple[NDArray[np.int64], Array]:
        """Intervals of instants (K,) s, and the shares of them."""
        k = np.clip(
            np.searchsorted(self.time, time + SAME_INSTANT, side="right") - 1,
            0,
            len(self.force) - 1,
        )
        step = np.diff(self.time)[k]
        return k, np.clip((time - self.time[k]) / step, 0.0, 1.0)

    def within(self, k: NDArray[np.int64], share: Array) -> Instants:
        """At shares (K,) of intervals (K,)."""
        step, lines, state = np.diff(self.time)[k], line(share), self.state

        def mixed(values: Array, order: int) -> Array:
            result: Array = np.einsum("nk,kn...->k...", lines[order], values[k])
            return result

        def moved(position: str, velocity: str, acceleration: str) -> Array:
            twice = mixed(self.rates[acceleration], 2)
            straight = (share * step)[:, None] * state[velocity][k]
            result: Array = state[position][k] + straight + (step**2)[:, None] * twice
            return result

        def sped(velocity: str, acceleration: str) -> Array:
            result: Array = state[velocity][k] + step[:, None] * mixed(self.rates[acceleration], 1)
            return result

        omega, omega_rate = sped("omega", "omega_rate"), mixed(self.rates["omega_rate"], 0)
        quat = self._attitude(k, share, step[:, None], lines)
        R_base_world = np.swapaxes(rotation_matrices(quat), -1, -2)
        velocity = apply(R_base_world, sped("velocity", "acceleration"))
        # Pinocchio's is a spatial acceleration.
        linear = apply(R_base_world, mixed(self.rates["acceleration"], 0)) - cross(omega, velocity)
        joints = "joint_position", "joint_velocity", "joint_acceleration"
        return Instants(
            q=np.hstack(
                [
                    moved("position", "velocity", "acceleration"),
                    quat[:, [1, 2, 3, 0]],
                    moved(*joints),
                ]
            ),
            v=np.hstack([velocity, omega, sped(*joints[1:])]),
            a=np.hstack([linear, omega_rate, mixed(self.rates[joints[2]], 0)]),
            force=mixed(self.force, 0),
        )

    def _attitude(self, k: NDArray[np.int64], share: Array, step: Array, lines: Array) -> Array:
        """(K, 4), as the stage has it."""
        omega, rates, share = self.state["omega"][k], self.rates["omega_rate"][k], share[:, None]
        turn = step * share * omega + step**2 * np.einsum("nk,kni->ki", lines[2], rates)
        gained = np.einsum("nk,kni->ki", lines[1], rates)
        turn += step**3 * share**2 / 12 * cross(omega, gained)
        start = Rotation.from_quat(self.state["quat"][k], scalar_first=True)
        turned = start * Rotation.from_rotvec(turn)
        quat: Array = turned.as_quat(scalar_first=True)
        return quat
