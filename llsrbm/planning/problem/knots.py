"""A vector of all variables as arrays over the knots, by the stage's own expressions, and back."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import casadi as ca
import numpy as np

from llsrbm.arrays import Array, IntArray
from llsrbm.body.joint_loads import JointLoads, joint_loads
from llsrbm.body.knot_motion import KnotMotion
from llsrbm.body.postures import Postures, solve_postures
from llsrbm.body.rolling import rolled
from llsrbm.mechanics import quaternion_product, quaternions_about_z
from llsrbm.models.base import CentroidalModel
from llsrbm.planning.problem.layout import SHIFT, TURNED, Layout
from llsrbm.planning.problem.parameters import (
    OWN,
    local_parameters,
    parameter_places,
    parameter_symbols,
    parameters,
)
from llsrbm.planning.problem.roles import Role
from llsrbm.planning.problem.stage import Stage
from llsrbm.planning.problem.task import Task, contact_points
from llsrbm.request.slopes import leaning

DYNAMICS = "dynamics"
"""Rows that are gaps between the body's states and what they follow from; those of other states are
under their names."""

AT_KNOTS = (
    "position",
    "velocity",
    "quat",
    "momentum",
    "feet_in_hip",
    "inertia",
    "leg_com",
    "foot_position",
    "foot_heading",
    "arm_angles",
)
OVER_INTERVALS = ("duration", "contact_force", "rotation_rate", "momentum_mean_base")


@dataclass(frozen=True, eq=False)
class RowValues:
    """Rows of one kind at all knots that have them: n values, their bounds, and the knots' numbers.

    Attributes:
        values, lower, upper, knot: (n,).
    """

    values: Array
    lower: Array
    upper: Array
    knot: IntArray


# Task and variables -> rows of each constraint, and of the dynamics under "dynamics".
Evaluate = Callable[[Task, Array], Mapping[Hashable, RowValues]]


class StageValues:
    """Quantities of a `Stage` as numbers at all knots: a CasADi function for each kind of stage."""

    def __init__(self, model: CentroidalModel, layout: Layout) -> None:
        self._layout = layout
        symbols = parameter_symbols(layout)
        families: dict[Role, list[int]] = {}
        for knot, role in enumerate(layout.roles):
            # The phase as such does not enter an expression.
            families.setdefault(replace(role, phase=0), []).append(knot)
        self._families = []
        self.shapes: dict[str, tuple[int, int]] = {}
        for role, knots in families.items():
            stage = Stage(role, layout, model, symbols)
            names = AT_KNOTS if role.terminal else (*AT_KNOTS, *OVER_INTERVALS)
            values = {name: ca.SX(getattr(stage, name)) for name in names}
            self.shapes |= {name: value.shape for name, value in values.items()}
            column = ca.vertcat(*(ca.densify(ca.vec(value)) for value in values.values()))
            function = ca.Function(
                "values",
                [stage.variables, ca.vertcat(*symbols.values()), stage.local, stage.own],
                [stage.lift.resolve(column)],
                {"cse": True},
            )
            variables = np.array([np.r_[layout.stage(k)] for k in knots])
            self._families.append((function, knots, variables, names))
        places = parameter_places(layout)
        self._local = [
            np.r_[tuple(places[name] for name in local_parameters(int(phase)))]
            for phase in layout.phase
        ]
        self._own = places[OWN]

    def __call__(self, w: Array, p: Array) -> dict[str, Array]:
        """Name -> (N+1, n, m) of what is (m, n) in a stage, (N+1, m) of columns.

        Over intervals the last is zero.

        Args:
            w: all variables; p: all parameters.
        """
        count = self._layout.knots
        out = {name: np.zeros((count, n, m)) for name, (m, n) in self.shapes.items()}
        numbers = self._layout.own_numbers
        own = np.vstack([p[self._own].reshape(-1, numbers), np.zeros(numbers)])
        for function, knots, variables, names in self._families:
            local = p[np.array([self._local[k] for k in knots])]
            columns = np.array(function(w[variables].T, p, local.T, own[knots].T))
            start = 0
            for name in names:
                shape = out[name].shape[1:]
                end = start + shape[0] * shape[1]
                out[name][knots] = columns[start:end].T.reshape(len(knots), *shape)
                start = end
        return {name: v[:, 0] if v.shape[1] == 1 else v for name, v in out.items()}


@lru_cache(maxsize=32)
def _stage_values(model: CentroidalModel, layout: Layout) -> StageValues:
    return StageValues(model, layout)


@dataclass(frozen=True, eq=False)
class Knots:
    """N + 1 knots and the N intervals between them; world frame, SI units.

    Attributes:
        layout: which feet stand where.
        variables: all of them, from which everything else follows.
        durations: (P,) s.
        time: (N+1,) s.
        position, velocity: (N+1, 3) m, m/s, CoM; quat: (N+1, 4); momentum: (N+1, 3) kg m2/s.
        force: (N+1, C, 3) N.
        rotation_rate: (N, 3) rad/s, base axes.
        momentum_mean: (N, 3) kg m2/s: R^T L, L's mean over the interval, R at its middle.
        feet_in_hip: (N+1, L, d) m, rad: x.
        inertia: (N+1, 3, 3) kg m2 of the model, leg_com: (N+1, L, 3) m from the CoM; base axes.
        foot_position: (N+1, L, 3) m; foot_heading: (N+1, L) rad: as the model sees them in flight,
            as they stand in contact.
        arm_angles: (N+1, A n) rad, of free arms; (N+1, 0) of others.
        near_angles: (N+1, J) joint angles close to the postures, where they are known.
        evaluate: the rows of the constraints under a task, where they are known.
    """

    task: Task
    model: CentroidalModel
    layout: Layout
    variables: Array
    durations: Array
    time: Array
    position: Array
    velocity: Array
    quat: Array
    momentum: Array
    force: Array
    rotation_rate: Array
    momentum_mean: Array
    feet_in_hip: Array
    inertia: Array
    leg_com: Array
    foot_position: Array
    foot_heading: Array
    arm_angles: Array
    near_angles: Array | None = None
    evaluate: Evaluate | None = None

    @property
    def phase(self) -> IntArray:
        """(N+1,) of the schedule, of the interval that begins at a knot."""
        return self.layout.phase

    @cached_property
    def rows(self) -> Mapping[Hashable, RowValues]:
        """Rows of each constraint, of the dynamics (`DYNAMICS`), and of other states' gaps."""
        assert self.evaluate is not None
        return self.evaluate(self.task, self.variables)

    @cached_property
    def flights(self) -> tuple[slice, ...]:
        """The intervals of each flight; `stop` is the knot of touchdown."""
        first = self.layout.first_knots
        return tuple(slice(int(first[p]), int(first[p + 1])) for p in self.task.schedule.flights)

    @cached_property
    def dt(self) -> Array:
        """(N,) s."""
        return np.diff(self.time)

    @cached_property
    def contact_point(self) -> Array:
        """(N+1, C, 3) m: corners of the feet, wherever they are."""
        return contact_points(
            self.foot_position, self.foot_heading, self.task.corners, self._foot_tilt
        )

    @cached_property
    def foot_quat(self) -> Array:
        """(N+1, L, 4) w, x, y, z: of soles with their headings, as their surfaces lean."""
        level = quaternions_about_z(self.foot_heading)
        if self.task.foot.is_point:
            return level
        return quaternion_product(leaning(self._foot_tilt), level)

    @cached_property
    def _foot_tilt(self) -> Array:
        """(N+1, L, 2) gradients of what feet stand on, or between which they swing."""
        layout = self.layout
        found = np.zeros((layout.knots, layout.legs, 2))
        for phase in range(layout.phases):
            here = layout.phase == phase
            found[here] = self.task.tilt(phase, layout.swing_progress[0][here])
        return found

    @cached_property
    def postures(self) -> Postures:
        """Postures of the whole body that realise the plan at the knots."""
        robot, near = self.task.robot, self.near_angles
        if near is None and self.layout.arm_joints:
            near = np.tile(robot.posture[7:], (len(self.time), 1))
        if near is not None and self.layout.arm_joints:
            near = near.copy()
            near[:, robot.arm_joint_index] = self.arm_angles
        feet = self.foot_position, self.foot_quat
        return solve_postures(robot, self.position, self.quat, *feet, near=near)

    @cached_property
    def rolled(self) -> Array:
        """(N+1, L, 2) m: how far standing feet roll in these postures, `llsrbm.body.rolling`."""
        task, angles = self.task, self.postures.joint_position
        return rolled(task.robot, angles, self.quat, task.schedule, self.phase)

    @cached_property
    def loads(self) -> JointLoads:
        """Motion and torques of the joints in these postures, by Pinocchio."""
        motion = KnotMotion(
            time=self.time,
            schedule=self.task.schedule,
            phase=self.phase,
            com=self.position,
            com_velocity=self.velocity,
            base_quat=self.quat,
            foot_position=self.foot_position,
            foot_quat=self.foot_quat,
            contact_point=self.contact_point,
            contact_force=self.force,
            joint_position=self.postures.joint_position,
        )
        return joint_loads(self.task.robot, motion)

    def under(self, task: Task) -> Knots:
        """The same motion under other limits; postures and loads are not computed again, but loads
        with other drives.
        """
        other = replace(self, task=task)
        for name in ("postures", "loads"):
            same = name == "postures" or task.robot is self.task.robot
            if same and name in vars(self):
                vars(other)[name] = vars(self)[name]
        return other


def unpack(
    w: Array,
    layout: Layout,
    task: Task,
    model: CentroidalModel,
    evaluate: Evaluate | None = None,
) -> Knots:
    """The variables w, in the layout's order and units, as `Knots`."""
    w = layout.normalised(w)
    known = parameters(layout, task, at_knots=True)
    values = _stage_values(model, layout)(w, np.concatenate([*known.values()]))
    durations = values["duration"][layout.first_knots[:-1], 0]
    starts = np.concatenate([[0.0], np.cumsum(durations)])
    return Knots(
        task=task,
        model=model,
        layout=layout,
        variables=w,
        durations=durations,
        time=starts[layout.phase] + layout.progress * durations[layout.phase],
        position=values["position"],
        velocity=values["velocity"],
        quat=values["quat"],
        momentum=values["momentum"] * task.mass,
        force=values["contact_force"].reshape(layout.knots, layout.contacts, 3),
        rotation_rate=values["rotation_rate"][:-1],
        momentum_mean=values["momentum_mean_base"][:-1] * task.mass,
        feet_in_hip=values["feet_in_hip"],
        inertia=values["inertia"],
        leg_com=values["leg_com"],
        foot_position=values["foot_position"],
        foot_heading=_continuous(values["foot_heading"], layout, task),
        arm_angles=values["arm_angles"],
        evaluate=evaluate,
    )


def _continuous(headings: Array, layout: Layout, task: Task) -> Array:
    """(N+1, L) rad: without jumps by whole turns from where feet stood to touchdown."""
    for leg, lift, touch in layout.swings:
        stood = task.footholds_before(int(layout.phase[lift])).yaw[leg]
        headings[lift:touch, leg] = np.unwrap(np.append(stood, headings[lift:touch, leg]))[1:]
    return headings


@dataclass(frozen=True, eq=False)
class Sampled:
    """A motion at N + 1 knots, in the solver's units (`Layout`): P phases, L legs, c corners.

    Attributes:
        durations: (P,) s.
        position, velocity: (N+1, 3); quat: (N+1, 4); momentum, rotation_rate: (N+1, 3).
        feet: (N+1, L, d) x; feet_velocity: (N+1, L, d), of the interval before, at lift-off of the
            first one.
        arms: (N+1, A n) rad; arms_velocity: (N+1, A n) rad/s, of the interval before.
        force: (N+1, L, c, 3); landing_force: (L, c, 3), of feet that meet the ground.
        shift: (2,) m.
    """

    durations: Array
    position: Array
    velocity: Array
    quat: Array
    momentum: Array
    rotation_rate: Array
    feet: Array
    feet_velocity: Array
    arms: Array
    arms_velocity: Array
    force: Array
    landing_force: Array
    shift: Array


def pack(layout: Layout, motion: Sampled) -> Array:
    """All variables, in the layout's order; steps of forces are zero."""
    w = np.zeros(layout.size_total)
    feet, rate, durations = motion.feet, motion.feet_velocity, motion.durations
    for k, role in enumerate(layout.roles):
        following = min(k + 1, layout.total)

        def of(name: str, values: Array, role: Role = role) -> Array:
            return np.ravel(values[list(layout.legs_of(name, role))])

        values = {
            "position": motion.position[k],
            "velocity": motion.velocity[k],
            "quat": motion.quat[k],
            "momentum": motion.momentum[k],
            "rotation_rate": motion.rotation_rate[k],
            TURNED: motion.rotation_rate[max(k - 1, 0)],
            "duration": durations[role.phase],
            "next_duration": durations[min(role.phase + 1, layout.phases - 1)],
            "force": of("force", motion.force[k]),
            "next_force": of("next_force", motion.landing_force),
            "feet": of("feet", feet[k]),
            "feet_velocity": of("feet_velocity", rate[k]),
            "feet_step": of("feet_step", rate[following] - rate[k]),
            "next_feet": of("next_feet", feet[following]),
            "next_feet_velocity": of("next_feet_velocity", rate[following]),
            "arms": motion.arms[k],
            "arms_velocity": motion.arms_velocity[k],
            "arms_step": motion.arms_velocity[following] - motion.arms_velocity[k],
            SHIFT: motion.shift,
        }
        for name, place in layout.variables(k).items():
            w[place] = values.get(name, 0.0)
    return w
