"""The paper's quadratic program: accelerations and contact forces that serve the tasks best.

min 1/2 |A a + dA v - B|^2_W1 + 1/2 |f - f_wanted|^2_W2    over a (n,), f (3 C,)
s.t. M_f a + h_f = J_f^T f                     floating base
     |f_x|, |f_y| <= mu / sqrt(2) f_z          friction pyramid, inside the cone of mu
     tau = M_a a + h_a - J_a^T f + friction within the drives' limits
     a of the joints within bounds and S a >= least of links that are near each other, as far as
     that leaves a solution: see `Qp`

The program has the forces of those points alone that may push, the others' being zero.

A tick whose program is not solved gets torques that need no solution. For a moment those of the
last tick that was solved, cut to what the drives can give: they change little within some ticks,
and what kept a program from being solved is often over in the next. After that they would drive
joints that have gone elsewhere, and joints are damped until a program is solved again,

    tau = -diag(M_a) v / T   within the drives' limits,

which takes energy out whatever the robot's state: legs fold slowly under its weight. That is no
landing but a stop that harms least, and `solved` says so of every such tick.
"""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from llsrbm.arrays import Array, BoolArray
from llsrbm.control.qp import Qp, check_name
from llsrbm.control.reference import Target
from llsrbm.control.tasks import Task
from llsrbm.control.whole_body import WholeBody
from llsrbm.mechanics import INSCRIBED
from llsrbm.request.slopes import surface_axes

_BASE = 6  # unactuated velocities
_REGULARISATION = 1e-6  # (m/s2)^-2; accelerations that no task sees, e.g. the base's in flight
HOLD = 0.010  # s for which torques outlast their program: four ticks at 400 Hz
DAMPING = 0.05  # s in which a joint that is damped, the others held, loses two thirds of its speed


class Command(NamedTuple):
    """The decision of a tick: `torque` (J,), `acceleration` (n,), `force` (C, 3) N.

    If it is not `solved`, torques are held or damp the joints, as above; accelerations and forces
    are held with them, or zero.
    """

    torque: Array
    acceleration: Array
    force: Array
    solved: bool


class InverseDynamics:
    """Builds and solves the program of one robot, tick after tick."""

    def __init__(self, body: WholeBody, friction: float, solver: str, tick: float) -> None:
        """Set up the program; `friction`: of the cone around the pyramid; `tick`: s between solves.

        Raises `InputError`: no such solver.
        """
        n, contacts = body.velocities, body.contacts
        joints = n - _BASE
        self._body = body
        self._n = n
        check_name(solver)
        mu = INSCRIBED * friction
        self._faces = np.array([[1, 0, -mu], [-1, 0, -mu], [0, 1, -mu], [0, -1, -mu]])
        self._programs: dict[int, Qp] = {}  # by the number of points that push
        self._pyramids: dict[int, Array] = {}  # (points, 3) the normals that each has
        self._level = body.normals  # before anything slopes
        self._joints = slice(-joints, None)  # of a program's inequalities
        self._zero = Command(np.zeros(joints), np.zeros(n), np.zeros((contacts, 3)), solved=False)
        self._last = self._zero
        self._hold = round(HOLD / tick)  # ticks
        self._unsolved = self._hold  # in a row; before the first solution there is nothing to hold

    def solve(
        self,
        tasks: Iterable[tuple[Task, float]],
        target: Target,
        contact: BoolArray,
        force: Array,
        force_weight: float,
        torque_limits: tuple[Array, Array],
        accelerations: tuple[Array, Array] | None = None,
        apart: tuple[Array, Array] | None = None,
        friction: Array | float = 0.0,
        unmodelled: Array | float = 0.0,
    ) -> Command:
        """Torques for the body's present state, within `torque_limits`: lowest, highest, (J,) each.

        `friction`: (J,) Nm or N that the drives give beside what moves rotors and links;
        `unmodelled`: (n,) accelerations that come beside those of the torques
        (`llsrbm.control.unmodelled`);
        `accelerations`: lowest and highest of the joints, likewise, that stops and speeds allow;
        `apart`: S (k, J), least (k,) of `llsrbm.control.link_bounds.LinkBounds.rows`;
        `contact`: (C,) whether a point may push; `force`: (C, 3) N wanted; `force_weight`: 1/N2.
        """
        body, n = self._body, self._n
        M, h = body.M, body.h
        pushing: BoolArray | slice = slice(None) if contact.all() else contact
        J = body.contact_jacobian[pushing].reshape(-1, n)
        qp = self._program(len(J) // 3)
        self._set_costs(qp, tasks, target, force[pushing].ravel(), force_weight, unmodelled)
        qp.A[:, :n] = M[:_BASE]
        np.negative(J[:, :_BASE].T, out=qp.A[:, n:])
        np.negative(h[:_BASE], out=qp.b)
        self._set_pyramids(qp, contact)
        torques = qp.C[self._joints]
        torques[:, :n] = M[_BASE:]
        np.negative(J[:, _BASE:].T, out=torques[:, n:])
        resisting = h[_BASE:] + friction
        np.subtract(torque_limits[0], resisting, out=qp.lower[self._joints])
        np.subtract(torque_limits[1], resisting, out=qp.upper[self._joints])
        if accelerations is not None:
            qp.soft_lower[_BASE:n], qp.soft_upper[_BASE:n] = accelerations
        if apart is not None:
            qp.soft_rows = np.zeros((len(apart[1]), len(qp.g)))
            qp.soft_rows[:, _BASE:n], qp.soft_least = apart
        x = qp.solve()
        if x is None:
            return self._unsolved_command(torque_limits)
        forces = np.zeros((len(contact), 3))
        forces[pushing] = x[n:].reshape(-1, 3)
        self._last = Command(torques.dot(x) + resisting, x[:n] + unmodelled, forces, solved=True)
        self._unsolved = 0
        return self._last

    def _program(self, points: int) -> Qp:
        """For that many points that push: inequalities are friction's, then one a joint."""
        if points not in self._programs:
            n, pyramid = self._n, 4 * points
            qp = Qp.zeros(n + 3 * points, _BASE, pyramid + n - _BASE)
            qp.C[:pyramid, n:] = np.kron(np.eye(points), self._faces)
            qp.upper[:pyramid] = 0.0
            self._programs[points] = qp
        return self._programs[points]

    def _set_pyramids(self, qp: Qp, contact: BoolArray) -> None:
        """Turn the friction pyramids of points that push to what they push on, where it changed."""
        normals = self._body.normals
        if normals is self._level:  # all alike: as they were set
            return
        points = normals.repeat(len(contact) // len(normals), axis=0)[contact]
        known = self._pyramids.get(len(points))
        if known is not None and np.array_equal(known, points):
            return
        self._pyramids[len(points)] = points
        n = self._n
        for k, R_world_surface in enumerate(surface_axes(points)):
            columns = slice(n + 3 * k, n + 3 * k + 3)
            qp.C[4 * k : 4 * k + 4, columns] = self._faces @ R_world_surface.T

    def _unsolved_command(self, torque_limits: tuple[Array, Array]) -> Command:
        """The last solved torques for `HOLD` s, then damped joints."""
        self._unsolved += 1
        held = self._unsolved <= self._hold
        command = self._last if held else self._zero
        torque = command.torque if held else self._damping()
        return command._replace(torque=np.clip(torque, *torque_limits), solved=False)

    def _damping(self) -> Array:
        body = self._body
        return -np.diag(body.M)[_BASE:] * body.v[_BASE:] / DAMPING

    def _set_costs(
        self,
        qp: Qp,
        tasks: Iterable[tuple[Task, float]],
        target: Target,
        force: Array,
        force_weight: float,
        unmodelled: Array | float,
    ) -> None:
        body, n = self._body, self._n
        active = [(task, weight) for task, weight in tasks if weight > 0]
        rows = sum(task.rows for task, _ in active)
        A, B, W = np.empty((rows, n)), np.empty(rows), np.empty(rows)
        row = 0
        for task, weight in active:
            block = slice(row, row + task.rows)
            task.write(body, target, A[block], B[block])
            if isinstance(unmodelled, np.ndarray) and task.moves:
                B[block] -= A[block].dot(unmodelled)
            W[block] = weight
            row = block.stop
        weighted = A.T * W
        qp.H[:n, :n] = weighted.dot(A)
        np.negative(weighted.dot(B), out=qp.g[:n])
        diagonal = qp.H.reshape(-1)[:: len(qp.g) + 1]
        diagonal[:n] += _REGULARISATION
        diagonal[n:] = force_weight
        np.multiply(force, -force_weight, out=qp.g[n:])
