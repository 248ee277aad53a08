"""The model against what the whole body does: its turn in flight, and where its feet roll to."""

from typing import Any

import casadi as ca
import numpy as np

from llsrbm.arrays import Array
from llsrbm.body.momentum import momentum_and_inertia
from llsrbm.mechanics import rotation_matrices
from llsrbm.planning.problem.constraints.base import Bounds, Constraint
from llsrbm.planning.problem.constraints.motion import MOMENTUM_BALANCE
from llsrbm.planning.problem.knots import Knots
from llsrbm.planning.problem.layout import Layout
from llsrbm.planning.problem.roles import Role
from llsrbm.planning.problem.stage import Stage
from llsrbm.planning.problem.task import Task

# What a landing bears on top of what disturbances turn the base by, rad (5 deg).
BEARABLE = 0.09
# Of a whole turn, whose touchdown is bounded to 8 deg, rad (1 deg).
BEARABLE_TURNING = 0.02
# How far a body that turns over leans at most on its way, at least, rad: 180 deg but for a twist.
OVER = np.radians(150.0)
# By how much legs may miss their feet's places under models that are there for comparison, m: they
# put the hips a centimetre or two off.
COMPARED_MISS = 0.02
ROLLED_OFF = 0.003  # m by which feet may stand beside where they have rolled


class CheckAlone(Constraint):
    """Has no rows: a finished plan is checked, by the whole body."""

    def applies(self, role: Role) -> bool:
        """Nowhere."""
        return False

    def rows(self, stage: Stage) -> Any:
        """None."""
        return ca.SX(0, 1)

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """None."""
        return np.zeros(0), np.zeros(0)


class Agreement(CheckAlone):
    """A draft does what the whole body does."""

    def checked(self, task: Task) -> bool:
        """True where a draft is to agree with the whole body."""
        return task.agrees


class TrueTurn(Agreement):
    """The model's errors turn the base by no more than a landing bears.

    The maps of the legs are fitted about the standing feet; of feet far out they are a few per cent
    wrong, and a robot that follows such a plan arrives tilted. By Pinocchio: the base with the
    planned momentum and the joints' motion turns at I^-1 (L - h) instead of as planned; the
    difference, over the flight, is the amount. The constant inertia of `srbm` and the point masses
    of `llsrbm` are for comparison, and are not held to it.
    """

    name = "true_turn"
    unit = "rad"

    def violation(self, knots: Knots) -> Array:
        """Beyond what is bearable, at each touchdown."""
        out = np.zeros(len(knots.time))
        if knots.model.is_true:
            for flight in knots.flights:
                turn = float(np.linalg.norm(turn_error(knots, flight)))
                bearable = BEARABLE_TURNING if knots.layout.turns else BEARABLE
                out[flight.stop] = max(turn - bearable, 0.0)
        return out


class LegsReach(CheckAlone):
    """Legs reach where the plan has their feet, at the knots and half way between them.

    What inverse kinematics misses no robot can do, and every other check by the whole body would be
    of another motion.
    """

    name = "legs_reach"
    unit = "m"

    def violation(self, knots: Knots) -> Array:
        """Miss of the worst foot, at each knot or over the interval after it."""
        out = knots.postures.residual_m.copy()
        out[:-1] = np.maximum(out[:-1], knots.loads.foot_residual)
        return out if knots.model.is_true else np.maximum(out - COMPARED_MISS, 0.0)


class TurnsOver(CheckAlone):
    """A body that is to turn over is upside down on its way.

    Attitudes with the sign of their quaternion tell apart an odd and an even number of turns, no
    more: a front flip with half a twist to the left ends as half a twist to the right without one.
    """

    name = "turns_over"
    unit = "rad"

    def violation(self, knots: Knots) -> Array:
        """Short of `OVER`, at the first touchdown."""
        out = np.zeros(len(knots.time))
        if knots.layout.turns:
            lean = np.arccos(np.clip(rotation_matrices(knots.quat)[:, 2, 2], -1.0, 1.0))
            out[knots.flights[0].stop] = max(OVER - float(lean.max()), 0.0)
        return out


class Rolling(Agreement):
    """Feet of a body that turns over stand where they have rolled to, in an earlier solution."""

    name = "rolling"
    unit = "m"

    def violation(self, knots: Knots) -> Array:
        """Beyond what is bearable, at each knot."""
        if not (knots.model.is_true and knots.layout.turns):
            return np.zeros(len(knots.time))
        known = knots.task.rolled
        off = np.linalg.norm(knots.rolled - (0.0 if known is None else known), axis=-1)
        return np.maximum((off * knots.layout.standing).max(axis=1) - ROLLED_OFF, 0.0)


def turn_error(knots: Knots, flight: slice) -> Array:
    """(3,) rad, base axes: how far the whole body turns in a flight beyond the plan.

    Args:
        knots: the plan.
        flight: its intervals, of `Knots.flights`.
    """
    momentum, inertia = whole_body(knots, flight)
    missing = knots.momentum_mean[flight] - momentum
    rate = np.linalg.solve(inertia, missing[..., None])[..., 0]
    return knots.dt[flight] @ rate


def whole_body(knots: Knots, intervals: slice = slice(None)) -> tuple[Array, Array]:
    """Angular momentum (K, 3) kg m2/s and inertia (K, 3, 3) kg m2 in the middle of intervals.

    By Pinocchio, about the CoM, in base axes.
    """
    loads = knots.loads
    return momentum_and_inertia(
        knots.task.robot,
        loads.joint_position[intervals],
        loads.joint_velocity[intervals],
        knots.rotation_rate[intervals],
    )


def correction(knots: Knots) -> Array:
    """(N, 3) kg m2/s, base axes: what the model's angular momentum lacks over each interval."""
    task, balance = knots.task, knots.rows[MOMENTUM_BALANCE]
    # The balance is what the model has, with an earlier correction, less the plan's.
    modelled = knots.momentum_mean + MOMENTUM_BALANCE.measured(balance.values, task).reshape(-1, 3)
    if task.correction is not None:
        modelled = modelled - task.correction
    true, _ = whole_body(knots)
    return true - modelled
