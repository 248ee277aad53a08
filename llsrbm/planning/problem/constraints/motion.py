"""The laws of motion beside the dynamics, durations, and where and how the motion ends."""

from typing import Any

import casadi as ca
import numpy as np

from llsrbm.arrays import Array
from llsrbm.mechanics import turns_about_z
from llsrbm.planning.problem.constraints.base import Bounds, Constraint
from llsrbm.planning.problem.knots import Knots
from llsrbm.planning.problem.layout import Layout
from llsrbm.planning.problem.limit_table import limits_called
from llsrbm.planning.problem.roles import Role
from llsrbm.planning.problem.stage import BALANCE_SCALE, Stage
from llsrbm.planning.problem.task import Task

# Of the way from the middle of the feet to the nearest of them: forces can still be shared by all.
INSIDE = 0.4
# How far the base may lean from touchdown on, rad. It comes down at some 10 rad/s, and the legs
# stop that within a tenth of a second at best: half a radian.
LEAN = np.radians(35.0)
# How far short of its turn a body touches down, rad. What is disturbed lands up to 8 deg off, and
# past the turn no foot is left to brake with. Before `REBOUND` was there 18 or 19 of 20 front flips
# of Go2 were strict so, and 13 with 12 to 20 deg; of its back flips 19 or 20, and 16 to 19 with 8
# to 16.
SHORT = {
    "front": np.radians([10.0, 18.0]),
    "back": np.radians([12.0, 20.0]),
    "roll": np.radians([12.0, 20.0]),
}
# Likewise where it is caught, when the last feet land.
SHORT_WHEN_CAUGHT = np.radians([0.0, 30.0])
# How fast a flip's CoM may rise again after touchdown, m/s. As fast as it likes, 0.8, feet carry
# 0.6 of the weight, and on soft ground the robot leaves it. Of Go2's front flips on the spot, 0.1 m
# forward and off 40 cm 12, 11 and 8 of 12 are strict with 0.2, 8, 10 and 10 with 0.3, 12, 12 and 0
# with 0.1; below that none is planned off boxes.
REBOUND = 0.2
_AS_FAST_AS_IT_LIKES = 10.0  # m/s
ACROSS = np.radians(10.0)  # how far it may lean across the turn then


class MomentumBalance(Constraint):
    """I omega + h = R^T L over each interval (eqs. 3, 4; `llsrbm-plus`: with h).

    Where the model was found to be wrong, with what it lacks (`Task.correction`).

    I, h and R at the midpoint, L its mean over the interval.
    """

    name = "momentum_balance"
    unit = "kg m2/s"
    equality = True

    def applies(self, role: Role) -> bool:
        """Over every interval."""
        return not role.terminal

    def rows(self, stage: Stage) -> Any:
        """(3, 1)."""
        return stage.balance

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        return np.zeros(3), np.zeros(3)

    def measured(self, rows: Array, task: Task) -> Array:
        """kg m2/s."""
        return rows * (task.mass / BALANCE_SCALE)


MOMENTUM_BALANCE = MomentumBalance()


class FinalState(Constraint):
    """x[N] = x_fin: CoM, attitude and velocity as the target says; no angular momentum.

    Where feet land elsewhere the CoM ends above them. A motion that is planned anew under way has
    room horizontally (`FinalPlace`): where it comes to rest it could not choose in time.
    """

    name = "final_state"
    unit = "m, rad, m/s, m2/s"
    equality = True

    def applies(self, role: Role) -> bool:
        """At the end."""
        return role.terminal

    def rows(self, stage: Stage) -> Any:
        """(12, 1), under way (10, 1): position, vector part of the turn left, velocity, L / m."""
        w, xyz = stage.parameters["goal_quat"][0], stage.parameters["goal_quat"][1:]
        q = stage.quat
        turn = w * q[1:] - q[0] * xyz - ca.cross(xyz, q[1:])
        off = stage.off_goal
        return ca.vertcat(
            off[2] if stage.layout.under_way else off,
            turn,
            stage.velocity - stage.parameters["goal_velocity"],
            stage.momentum,
        )

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        return (np.zeros(10 if layout.under_way else 12),) * 2

    def measured(self, rows: Array, task: Task) -> Array:
        """The turn left as an angle."""
        out = rows.copy()
        out[-9:-6] = 2 * np.arcsin(min(float(np.linalg.norm(rows[-9:-6])), 1.0))
        return out


class ArmsAtRest(Constraint):
    """Free arms end as they hang in the default posture, at rest."""

    name = "arms_at_rest"
    unit = "rad, rad/s"
    equality = True

    def concerns(self, task: Task) -> bool:
        """True if the robot has arms that are free."""
        return len(task.free_arms) > 0

    def applies(self, role: Role) -> bool:
        """At the end."""
        return role.terminal and role.moves_arms

    def rows(self, stage: Stage) -> Any:
        """(2 A n, 1) rad, rad/s."""
        return ca.vertcat(stage.arm_angles - stage.parameters["goal_arms"], stage.arm_rates)

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        return (np.zeros(2 * layout.arm_joints),) * 2


class FinalPlace(Constraint):
    """A motion planned anew ends with its CoM well inside of where its feet stand."""

    name = "final_place"
    unit = "m"

    def applies(self, role: Role) -> bool:
        """At the end of a motion that began under way."""
        return role.terminal and role.under_way

    def rows(self, stage: Stage) -> Any:
        """(2, 1) m: how far the CoM is from its target above the feet, along the target's axes."""
        w, z = stage.parameters["goal_quat"][0], stage.parameters["goal_quat"][3]
        whole = w * w + z * z  # less than one where it leans
        c, s = (w * w - z * z) / whole, 2 * w * z / whole
        x, y = stage.off_goal[0], stage.off_goal[1]
        return ca.vertcat(c * x + s * y, c * y - s * x)

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """Along each of these axes a share of the way to the nearest contact point."""
        last = task.places[-1]
        seen = (last.contacts - task.goal_position) @ turns_about_z(last.heading)
        top = INSIDE * np.abs(seen[:, :2]).min(axis=0)
        return -top, top


class UprightLanding(Constraint):
    """e_z . R e_z >= cos(lean) from touchdown on, of jumps in which the body turns over.

    Others are kept upright by their costs. Without it a flip lands as soon as its front or hind
    feet reach the ground, and turns the rest of the way over them.
    """

    name = "upright_landing"
    unit = "rad"

    def applies(self, role: Role) -> bool:
        """After the last flight; the very end is given."""
        return role.lands_upright and not role.terminal

    def rows(self, stage: Stage) -> Any:
        """(1, 1) the cosine of the lean."""
        return stage.R_world_base[2, 2]

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """At least that of the largest lean."""
        return np.array([np.cos(LEAN)]), np.array([np.inf])

    def measured(self, rows: Array, task: Task) -> Array:
        """Less the lean, rad."""
        return -np.arccos(np.clip(rows, -1.0, 1.0))


class Rebound(Constraint):
    """v_z <= `REBOUND` from touchdown on, of flips: a rebounding CoM unloads the feet.

    Barrel rolls, whose landing is shorter, are not planned so.
    """

    name = "rebound"
    unit = "m/s"

    def applies(self, role: Role) -> bool:
        """After the last flight; the very end is given."""
        return role.lands_upright and not role.terminal

    def rows(self, stage: Stage) -> Any:
        """(1, 1) m/s upward, of the CoM."""
        return stage.velocity[2]

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """No more than that of a body that has turned about its lateral axis."""
        most = REBOUND if task.jump.pitch else _AS_FAST_AS_IT_LIKES
        return np.array([-np.inf]), np.array([most])


class ShortOfTurn(Constraint):
    """A body that turns over touches down short of its turn, never past it.

    What is left is turned while the legs stop it: by e_z . R e_x and e_z . R e_y, the sines of the
    angles of its axes above the horizontal.
    """

    name = "short_of_turn"
    unit = "rad"

    def applies(self, role: Role) -> bool:
        """At the last touchdown."""
        return role.lands_upright and bool(role.landing)

    def rows(self, stage: Stage) -> Any:
        """(2, 1) sines."""
        return stage.R_world_base[2, :2].T

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """`SHORT` about the axis of the turn, little across."""
        across = np.array([-ACROSS, ACROSS])
        # Of a turn forward that is not done e_x points up still, of one to the right e_y down.
        caught = task.schedule.is_caught
        angles = [
            np.sort(np.sign(turn) * (SHORT_WHEN_CAUGHT if caught else SHORT[name]))
            if turn
            else across
            for name, turn in (
                ("front" if task.jump.pitch > 0 else "back", task.jump.pitch),
                ("roll", -task.jump.roll),
            )
        ]
        lower, upper = np.sin(np.transpose(angles))
        return lower, upper

    def measured(self, rows: Array, task: Task) -> Array:
        """The angles, rad."""
        return np.arcsin(np.clip(rows, -1.0, 1.0))


class PhaseTimes(Constraint):
    """T_min <= T <= T_max for each phase (the paper bounds dt; flight collapses without it)."""

    name = "phase_times"
    unit = "s"
    limits = limits_called(
        "takeoff_min", "takeoff_max", "flight_min", "flight_max", "landing_min", "landing_max"
    )

    def applies(self, role: Role) -> bool:
        """Where a duration is chosen: at the start, and at the end of every phase but the last."""
        return role.initial or (role.last and not role.final)

    def rows(self, stage: Stage) -> Any:
        """(1, 1) s."""
        return stage.symbols.get("next_duration", stage.symbols["duration"])

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """The limits of the phase that begins."""
        role = layout.roles[knot]
        low, high = task.times(role.phase + (0 if role.initial else 1))
        return np.array([low]), np.array([high])

    def violation(self, knots: Knots) -> Array:
        """At the knots at which phases begin; rows are where their durations are chosen."""
        out = super().violation(knots)
        return np.concatenate([out[:1], [0.0], out[1:-1]])
