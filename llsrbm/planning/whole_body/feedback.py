"""Feedback along a plan: gains of a linear-quadratic regulator about the whole body's motion.

For those who play plans on a robot of their own: torque = planned torque - gain @ (state - planned
state). Over each interval the equations of motion are linear about the interval's middle, with the
feet that stand held where they are; where feet land what they moved at is taken out of the
velocities. After the plan's end the robot stands in its last posture.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from scipy.linalg import expm

from llsrbm.motion.plan import Plan
from llsrbm.motion.whole_body import motion_at, pinocchio_states
from llsrbm.request.messages import check_kind
from llsrbm.robots.drives.torques import friction_torque
from llsrbm.robots.robot import Robot

Array = NDArray[np.float64]

# By what a state may be off for a cost of 1, m, rad and per s: base, joints; and their rates.
WIDTHS = {
    "position": 0.1,
    "attitude": 0.2,
    "joint_position": 0.05,
    "velocity": 1.0,
    "omega": 2.0,
    "joint_velocity": 1.0,
}
TORQUE_WIDTH = 0.3  # share of a drive's torque, likewise
# 1/s, about: how fast a foot that stands elsewhere is taken to come back. Without, what no torque
# changes grows, and gains that act on it throw the robot over as soon as it lands.
HELD = 30.0
SHORT = 5e-3  # s of a step of the regulator, about
SMALL = 1e-6  # rad, m, and per s, of differences
STANDS = 1.0  # s of standing after the end, by which its gains have settled


def with_feedback(plan: Plan) -> Plan:
    """A plan with the gains of its feedback, which its native file then carries.

    `Plan.feedback_gain` is (N + 1, J, 12 + 2 J): of the interval that begins at a knot, and at the
    last of standing; rows in the order of `joint_names`. The state's error, of which it is a
    multiple, is, in axes of the planned base: where the base is (3, m) and by which rotation vector
    it is turned (3, rad), the joints (J) in the order of `joint_names`; the base's linear and
    angular velocity (m/s, rad/s), each in the base's own axes, and the joints' velocities. A plan
    that has them, or did not converge, comes back as it is.

    Raises:
        InputError: it is no plan, or its robot has other joints by now.
        RobotFileError: the robot is not there.
    """
    check_kind("plan", plan, Plan, "a Plan")
    if plan.feedback_gain is not None or not plan.solved or plan.joint_torque is None:
        return plan
    middles = (plan.time[1:] + plan.time[:-1]) / 2
    motion = motion_at(plan, np.append(middles, plan.time[-1]))
    assert motion.joint_torque is not None  # as the plan has them
    robot = motion.robot
    about = _About(robot, *pinocchio_states(motion.qpos, motion.qvel), motion.joint_torque)
    stands = plan.schedule.stands[plan.phase]
    gain = _regulator(about, stands, np.append(np.diff(plan.time), STANDS))
    return replace(plan, feedback_gain=in_order(gain, robot.joint_names, plan.joint_names))


def in_order(gain: Array, names: tuple[str, ...], wanted: tuple[str, ...]) -> Array:
    """Gains (K, J, 12 + 2 J) of joints in the order of `names`, with them in the `wanted` order."""
    joints = np.array([names.index(name) for name in wanted])
    half = np.concatenate([np.arange(6), 6 + joints])
    return gain[:, joints][:, :, np.concatenate([half, len(half) + half])]


class _About:
    """The robot's dynamics about states (K, nq), (K, nv) under joint torques (K, J)."""

    def __init__(self, robot: Robot, q: Array, v: Array, torque: Array) -> None:
        self.robot, self._model, self._data = robot, robot.model, robot.model.createData()
        # Friction takes its share as planned: states that are a little off hardly change it.
        self._q, self._v, self._torque = q, v, torque - friction_torque(robot, v[:, 6:])
        nv = robot.model.nv
        self.width = np.repeat(list(WIDTHS.values()), [3, 3, nv - 6, 3, 3, nv - 6])

    def over(self, k: int, standing: NDArray[np.bool_], step: float) -> tuple[Array, Array]:
        """State (2 nv, 2 nv) and torque (2 nv, J) matrices over a step, s, about the state k."""
        model, nv = self._model, self._model.nv
        q, v, torque = self._q[k], self._v[k], self._torque[k]
        self._places = self._stand_at(q)
        about, by_effort = self._acceleration(q, v, torque, standing)
        rates = np.zeros((2 * nv + nv - 6, 2 * nv + nv - 6))
        # Seen from a base that moves, the error of its pose turns and shifts.
        rates[:6, :6] = -pin.Motion(v[:6]).action
        rates[:nv, nv : 2 * nv] = np.eye(nv)
        rates[nv : 2 * nv, 2 * nv :] = by_effort[:, 6:]
        for i, off in enumerate(SMALL * np.eye(nv)):
            turned = pin.integrate(model, q, off)
            for column, state in ((i, (turned, v)), (nv + i, (q, v + off))):
                found, _ = self._acceleration(*state, torque, standing)
                rates[nv : 2 * nv, column] = (found - about) / SMALL
        moved = expm(step * rates)
        return moved[: 2 * nv, : 2 * nv], moved[: 2 * nv, 2 * nv :]

    def landed(self, k: int, landing: NDArray[np.bool_]) -> Array:
        """(2 nv, 2 nv) of errors: after feet have landed at the state k from before it."""
        nv = self._model.nv
        self._places = self._stand_at(self._q[k])
        M, J, _, _ = self._terms(self._q[k], self._v[k], landing)
        spread = np.linalg.solve(M, J.T)
        kept = np.eye(2 * nv)
        kept[nv:, nv:] -= spread @ np.linalg.solve(J @ spread, J)
        return kept

    def _stand_at(self, q: Array) -> list[pin.SE3]:
        pin.framesForwardKinematics(self._model, self._data, q)
        return [pin.SE3(self._data.oMf[leg.foot_frame_id]) for leg in self.robot.legs]

    def _acceleration(
        self, q: Array, v: Array, torque: Array, standing: NDArray[np.bool_]
    ) -> tuple[Array, Array]:
        """(nv,) with feet that stand held, and (nv, nv) what it changes by with an effort."""
        M, J, drift, held_by = self._terms(q, v, standing)
        rows, nv = len(J), len(M)
        held = np.zeros((nv + rows, nv + rows))
        held[:nv, :nv], held[:nv, nv:], held[nv:, :nv] = M, J.T, J
        inverse = np.linalg.inv(held).astype(np.float64)
        effort = np.concatenate([np.zeros(6), torque]) - held_by
        found = inverse[:nv] @ np.concatenate([effort, -drift])
        return found, inverse[:nv, :nv]

    def _terms(
        self, q: Array, v: Array, standing: NDArray[np.bool_]
    ) -> tuple[Array, Array, Array, Array]:
        """Mass matrix, Jacobian of the standing feet, their acceleration at rest, v x* h + g."""
        model, data = self._model, self._data
        pin.computeAllTerms(model, data, q, v)
        M = np.triu(data.M) + np.triu(data.M, 1).T
        held_by = data.nle.copy()
        pin.forwardKinematics(model, data, q, v, np.zeros(model.nv))
        pin.updateFramePlacements(model, data)
        rows = 3 if len(self.robot.corners) == 1 else 6
        J, drift = [np.zeros((0, model.nv))], [np.zeros(0)]
        for leg in np.flatnonzero(standing):
            frame = self.robot.legs[leg].foot_frame_id
            jacobian = pin.getFrameJacobian(model, data, frame, pin.LOCAL)[:rows]
            rest = pin.getFrameClassicalAcceleration(model, data, frame, pin.LOCAL).vector[:rows]
            off = pin.log6(self._places[leg].actInv(data.oMf[frame])).vector[:rows]
            J.append(jacobian)
            drift.append(rest + 2 * HELD * jacobian @ v + HELD**2 * off)
        return M, np.vstack(J), np.concatenate(drift), held_by


def _regulator(about: _About, stands: NDArray[np.bool_], step: Array) -> Array:
    """(K, J, 2 nv) gains of the intervals, of (K, L) which feet stand and their lengths (K,) s.

    The last is of standing for so long; from its end on nothing counts any more.
    """
    robot = about.robot
    Q = np.diag(about.width**-2.0)
    R = np.diag((TORQUE_WIDTH * robot.torque_limit) ** -2.0)
    value = Q.copy()
    gains = np.empty((len(step), len(robot.joint_names), len(Q)))
    for k in range(len(step) - 1, -1, -1):
        steps = max(1, round(step[k] / SHORT))
        A, B = about.over(k, stands[k], step[k] / steps)
        for _ in range(steps):
            seen = B.T @ value
            gains[k] = np.linalg.solve(R + seen @ B, seen @ A)
            value = Q + A.T @ value @ (A - B @ gains[k])
            value = (value + value.T) / 2
        landing = stands[k] & ~stands[k - 1] if k else np.zeros_like(stands[k])
        if landing.any():
            kept = about.landed(k, landing)
            value = kept.T @ value @ kept
    return gains
