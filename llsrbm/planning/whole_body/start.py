"""A centroidal plan as the whole-body problem begins from it: states and rates of its posture."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from llsrbm.body.knot_motion import KnotMotion, states
from llsrbm.body.momentum import base_velocities
from llsrbm.body.postures import Postures, solve_postures
from llsrbm.mechanics import (
    apply,
    interpolated,
    quaternion_product,
    quaternions_about_z,
    rotation_matrices,
    sign_continuous,
    slerp,
)
from llsrbm.models import MODELS
from llsrbm.motion.block import Block
from llsrbm.motion.plan import Plan
from llsrbm.motion.surroundings import surroundings
from llsrbm.planning.problem.placement import task_of
from llsrbm.planning.problem.task import Task
from llsrbm.planning.whole_body.apart import Apart
from llsrbm.planning.whole_body.grid import SAME_INSTANT, Grid
from llsrbm.planning.whole_body.sizes import NODES, WEIGHTS, Sizes, parts
from llsrbm.planning.whole_body.tops import tops
from llsrbm.request.jump import COMPONENTS
from llsrbm.request.scenario import Scenario
from llsrbm.request.slopes import leaning, normals
from llsrbm.robots.feet import foot_contacts
from llsrbm.robots.robot import Robot

Array = NDArray[np.float64]

# Weight of nearness to the motion of an earlier round.
NEAR = 1.0
# To a draft, which is found in fewer iterations: with 0.1, 3, 10 and 30 drafts of Go2's jumps that
# its table leads nowhere for took 684, 469, 540 and 543 (15 jumps, of two simulations each 27, 28,
# 24 and 24 strict), ANYmal's at most 610, 431, 479 and 723 (9, 11, 11 and 11 found, 16, 20, 21 and
# 20 strict).
NEAR_DRAFT = 3.0
# Models for comparison keep their own motion, as near to it as the body can. At the same shares of
# their flights, feet and base are 0.9 to 2.3 cm and 0.4 to 0.9 cm from the drafts' (ANYmal, four
# jumps of both models), Go2's 1.5 to 2.5 and 1.4 to 2.9 (three jumps).
OWN = {
    "near": 30.0,
    **dict.fromkeys(("level", "turning", "joint_speed", "posture", "time"), 0.0),
}
# Times the weights where legs stand after a flight. A level trunk: of Go2's and ANYmal's jumps that
# come down leaning by less than 8 degrees 315 of 323 land strictly, of those by more than 11 one of
# six. Even forces: where two of four feet carried nothing for 0.2 s of a landing (Go2, 99 degrees
# with 18 cm and 8 cm down) two of three simulations fell; with these weights none does.
LANDED = {"level": 200.0, "force": 20.0}
STRAIGHTER = 5.0  # times the costs of what is steep, where much is missing between the nodes
INSIDE = 1e-3  # s, of a duration's bounds
ROOM = 1e-4  # rad and m, beyond what is wanted of an offset: solvers need some
# m that the trunk keeps from the ground once the robot has landed: simulated trunks sink 1 to 6 cm
# deeper than planned, and with them knees and shanks. Of 16 of Go2's jumps at the edges of its
# ranges, each simulated three times with everything disturbed, 34 of 48 land strictly without and
# 44 with 5 cm; with 8 a shank still touches the ground after twists of 133 and 138 degrees.
SINKS = 0.1
# m that it keeps before: the trunk of a Go2 whose plan crouched down to the ground touched it, 8 mm
# lower in the simulator.
CROUCHES = 0.03


@dataclass(frozen=True, eq=False)
class Start:
    """A plan on a grid of N intervals.

    Attributes:
        task: what is asked.
        phase_start: (P + 1,) s: edges of the phases.
        time: (2 N + 1,) s: the knots and the middles between them.
        state: name -> (N + 1, n), at the knots; motion: name -> (N, nodes, n), at the nodes.
        force: (N, nodes, 3 C) N, of all contact points.
        place, foot_quat: (2 N + 1, L, 3) m, (2 N + 1, L, 4) of the feet: where they stand, their
            places.
        tilt: (N + 1, L, 2) gradients of the ground that feet stand on, or swing over; level:
            (N + 1, 2) x and y of the quaternion of a base that is level to it.
        weights: of costs, but for what differs where the robot has landed.
        solids: the ground and blocks; apart: distances of links from each other and from them, and
            of the CoM from the limits of its apex.
        rolled: (N + 1, L, 2) m, by how much feet that stand have rolled away from where they rest;
            None: as they do in this state.
        wanted: (4,) rad and m, by how much more than the task's is wanted of each component; price:
            of a whole range that is not done.
    """

    task: Task
    phase_start: Array
    time: Array
    state: Mapping[str, Array]
    motion: Mapping[str, Array]
    force: Array
    place: Array
    foot_quat: Array
    tilt: Array
    level: Array
    weights: Mapping[str, float]
    solids: tuple[Block, ...]
    apart: Apart
    rolled: Array | None = None
    wanted: Array = field(default_factory=partial(np.zeros, len(COMPONENTS)))
    price: float = 0.0

    @property
    def offset_bounds(self) -> tuple[Array, Array]:
        """(4,) rad and m each: an offset is between nothing and what is wanted.

        Where nothing is it does not count, and is bounded by what it never comes to.
        """
        none = np.where(self.wanted, ROOM, 1.0)
        return np.minimum(self.wanted, 0.0) - none, np.maximum(self.wanted, 0.0) + none

    @cached_property
    def duration_bounds(self) -> tuple[Array, Array]:
        """(P,) s each: shortest and longest phases; one that is given has a little room."""
        durations = np.diff(self.phase_start)
        low, high = np.array([self.task.times(p) for p in range(len(durations))]).T
        given = high - low < 2 * INSIDE
        return np.where(given, low - INSIDE, low), np.where(given, high + INSIDE, high)

    @property
    def heading(self) -> Array:
        """(N + 1, L, 2) in which direction the feet look."""
        ahead: Array = rotation_matrices(self.foot_quat[::2])[..., :2, 0]
        return ahead

    def timed(self, durations: Array, grid: Grid) -> Start:
        """The same with phases that last so long, s (P,)."""
        edges = np.concatenate([[0.0], np.cumsum(durations)])

        def moved(time: float) -> float:
            known = np.isfinite(time)
            return float(np.interp(time, self.phase_start, edges)) if known else time

        solids = tuple(
            replace(block, from_s=moved(block.from_s), until_s=moved(block.until_s))
            for block in self.solids
        )
        return replace(self, phase_start=edges, time=grid.times(edges), solids=solids)

    def beside(self, state: Mapping[str, Array]) -> Start:
        """The same beside a motion of these states, but for its ends, and for its attitudes, from
        which the distances' turns count.
        """
        moved = {name: values.copy() for name, values in self.state.items()}
        for name, values in moved.items():
            if name != "quat":
                values[1:-1] = state[name][1:-1]
        return replace(self, state=moved)

    def ended(self, robot: Robot) -> Start:
        """The same, at rest where the request ends, in the posture in which it begins.

        Between jumps nearby ends are up to some degrees and centimetres off. On slopes and
        stones the robot begins and ends as it stands there.
        """
        task, state = self.task, {name: values.copy() for name, values in self.state.items()}
        R_begun, R_end = rotation_matrices(np.array([task.start_quat, task.goal_quat]))
        from_com = R_end @ R_begun.T @ (state["position"][0] - task.start_position)
        state["position"][-1] = task.goal_position + from_com
        state["quat"][-1] = task.goal_quat
        for name in ("joint_position", "velocity", "omega", "joint_velocity"):
            state[name][-1] = state[name][0]
        uneven = any(place.lean.any() or place.aside.any() for place in task.places)
        if uneven or self.tilt[[0, -1]].any():
            stands = _standing(task, robot)
            state["quat"][0] = task.start_quat
            state["position"][[0, -1]] = stands.base_position
            state["joint_position"][[0, -1]] = stands.joint_position
        return replace(self, state=state)

    def straighter(self) -> Start:
        """The same with straighter lines of accelerations and forces, which miss less between."""
        steep = {n: STRAIGHTER * w for n, w in self.weights.items() if n.startswith("steep")}
        return replace(self, weights={**self.weights, **steep})

    def nearer(self) -> Start:
        """The same with a motion that stays near its state."""
        return replace(self, weights={**self.weights, "near": max(NEAR, self.weights["near"])})

    @property
    def keeps_own(self) -> bool:
        """Whether it is of a model for comparison, whose own motion is kept."""
        return not MODELS[self.task.jump.model].is_true

    def of_draft(self) -> Start:
        """The same beside a draft: of a model that keeps its own motion, that motion."""
        return replace(self, weights={**self.weights, "near": NEAR_DRAFT}).of_refined()

    def of_refined(self) -> Start:
        """The same beside a whole body's motion, which of such a model is its own already."""
        return replace(self, weights={**self.weights, **(OWN if self.keeps_own else {})})

    def kept(self, near: float) -> Start:
        """The same beside a motion that is to be kept as it is, by a weight of nearness to it."""
        return replace(self, weights={**self.weights, **OWN, "near": near})


def _standing(task: Task, robot: Robot) -> Postures:
    """The robot as it stands at the start, and at the end."""
    ends = task.places[0], task.places[-1]
    tilt, feet = (np.array([getattr(place, name) for place in ends]) for name in ("tilt", "feet"))
    # A ball that touches a slope beside its lowest point is higher.
    up = foot_contacts(robot)[0].radius * (1 / normals(tilt)[..., 2] - 1)
    feet[..., 2] += up if task.foot.is_point else 0.0
    level = quaternions_about_z(np.array([place.yaw for place in ends]))
    return solve_postures(
        robot,
        np.array([task.start_position, task.goal_position]),
        np.array([task.start_quat, task.goal_quat]),
        feet,
        quaternion_product(leaning(tilt), level),
    )


def start_of(plan: Plan, robot: Robot, grid: Grid, task: Task | None = None) -> Start:
    """A plan as the whole-body problem begins from it; `task`: its own, None: of its request."""
    task = task or task_of(plan, robot)
    time, known = grid.times(plan.phase_start), plan.time
    state = _states(plan, robot, time)
    halves = np.diff(time)[:, None]
    rates = {
        "acceleration": "velocity",
        "omega_rate": "omega",
        "joint_acceleration": "joint_velocity",
    }
    middles = (time[1:] + time[:-1]) / 2
    interval = np.searchsorted(known, middles, side="right") - 1
    force = plan.contact_force.reshape(len(known), -1)[interval]
    last_knot = np.searchsorted(known, time + SAME_INSTANT, side="right") - 1
    count, solids = grid.intervals, surroundings(robot, plan, Scenario()).solids
    q = np.hstack([state["position"], np.roll(state["quat"], -1, axis=1), state["joint_position"]])
    return Start(
        task=task,
        phase_start=plan.phase_start,
        time=time,
        state={name: values[::2] for name, values in state.items()},
        motion={
            name: (np.diff(state[of], axis=0) / halves).reshape(count, len(NODES), -1)
            for name, of in rates.items()
        },
        force=force.reshape(count, len(NODES), -1),
        place=_places(plan, task, grid),
        foot_quat=plan.foot_quat[last_knot],
        tilt=tilts(task, grid),
        level=_level(task, grid),
        weights=_weights(task),
        solids=solids,
        apart=Apart.near(
            *(q, time, state["quat"][::2], robot, solids, trunk_room(grid)),
            others=tops(q, grid, task, robot),
        ),
    )


def trunk_room(grid: Grid) -> Array:
    """(2 N + 1,) m that the trunk keeps from ground and boxes: where legs stand."""
    return np.where(grid.landed, SINKS, np.where(grid.stood, CROUCHES, 0.0))


def variables(start: Start, grid: Grid, sizes: Sizes) -> Array:
    """All variables, in units: states with durations, then the controls at both nodes."""
    low, high = start.duration_bounds
    durations = np.clip(np.diff(start.phase_start), low + INSIDE, high - INSIDE)
    found = []
    for k, knot in enumerate(grid.knots):
        own = [*(values[k] for values in start.state.values()), durations]
        own.append(np.zeros(len(COMPONENTS)))
        for node in range(0 if knot.last else len(NODES)):
            own += [values[k, node] for values in start.motion.values()]
            force = start.force[k, node].reshape(sizes.legs, -1)
            own.append(force[list(knot.standing)].ravel())
        found.append(np.concatenate(own) / sizes.unit(knot))
    return np.concatenate(found)


def without_offset(variables: Array, grid: Grid, sizes: Sizes) -> Array:
    """The same variables with an offset of zeros."""
    found, at = variables.copy(), 0
    for knot in grid.knots:
        parts(found[at : at + sizes.states], sizes.state)["offset"][:] = 0.0
        at += sizes.states + sizes.controls(knot)
    return found


def _weights(task: Task) -> dict[str, float]:
    own = dict(WEIGHTS)
    if task.jump.turns:
        own["level"] = 0.0
    return own


def _states(plan: Plan, robot: Robot, time: Array) -> dict[str, Array]:
    """Name -> (K, n) of a plan's posture at instants (K,) s."""
    assert plan.joint_velocity is not None  # a plan that converged has it
    order = [plan.joint_names.index(name) for name in robot.joint_names]
    known = plan.time
    knots, _ = states(robot, KnotMotion.of_plan(plan))
    omega = apply(np.swapaxes(rotation_matrices(plan.base_quat), -1, -2), knots.omega)
    position, velocity = plan.joint_position[:, order], plan.joint_velocity[:, order]
    base = plan.base_position, plan.base_quat, omega
    base_velocity = base_velocities(robot, plan.com_velocity, *base, position, velocity)
    return {
        "position": interpolated(time, known, plan.base_position),
        "quat": _turning(time, known, plan.base_quat),
        "joint_position": interpolated(time, known, position),
        "velocity": interpolated(time, known, base_velocity),
        "omega": interpolated(time, known, omega),
        "joint_velocity": interpolated(time, known, velocity),
    }


def footholds(task: Task, grid: Grid) -> tuple[Array, Array]:
    """(2 N + 1, L, 3) m, where feet stand, and (2 N + 1, L, 4) w, x, y, z, how: soles lean as the
    ground does. NaN in the air.
    """
    halves, legs = 2 * grid.intervals + 1, len(task.places[0].feet)
    place, quat = np.full((halves, legs, 3), np.nan), np.full((halves, legs, 4), np.nan)
    for half in range(halves):
        knot, phase = grid.knots[half // 2], grid.phase_at(half)
        # A foot that leaves there stood in the phase before.
        there = task.footholds_before(phase)
        resting = list(knot.standing if half % 2 else knot.resting)
        place[half, resting] = there.feet[resting]
        level = quaternions_about_z(there.yaw[resting])
        lean = leaning(there.tilt[resting])
        quat[half, resting] = level if task.foot.is_point else quaternion_product(lean, level)
    return place, quat


def tilts(task: Task, grid: Grid) -> Array:
    """(N + 1, L, 2) gradients of the ground that feet stand on.

    In the air it is that of what they left, and from the middle of their swing on that of what they
    land on.
    """
    shares, stands = grid.shares[::2], task.schedule.stands
    found = np.zeros((len(shares), stands.shape[1], 2))
    for k, share in enumerate(shares):
        phase = grid.phase_at(2 * k)
        before, after = task.footholds_before(phase).tilt, task.footholds_after(phase).tilt
        for leg, rests in enumerate(stands[phase]):
            lands = False
            if not rests:
                there = np.flatnonzero(stands[:, leg])
                lift, touch = there[there < phase][-1] + 1, there[there > phase][0]
                lands = share - lift > (touch - lift) / 2
            found[k, leg] = after[leg] if lands else before[leg]
    return found


def _level(task: Task, grid: Grid) -> Array:
    """(N + 1, 2) x and y of the quaternion of a base that is level to what is below it."""
    leans = quaternion_product(
        leaning(np.array([place.lean for place in task.places])),
        quaternions_about_z([place.heading for place in task.places]),
    )[:, 1:3]
    phases = list(task.schedule)
    found = []
    for k, share in enumerate(grid.shares[::2]):
        phase = grid.phase_at(2 * k)
        here, there = phases[phase].place, phases[min(phase + 1, len(phases) - 1)].place
        moved = share - phase if phases[phase].is_flight else 0.0
        found.append(leans[here] + moved * (leans[there] - leans[here]))
    return np.array(found)


def _places(plan: Plan, task: Task, grid: Grid) -> Array:
    """(2 N + 1, L, 3) m: feet on the way, and where they stand their footholds."""
    known = plan.foot_position.reshape(len(plan.time), -1)
    way = interpolated(grid.times(plan.phase_start), plan.time, known)
    stands, _ = footholds(task, grid)
    return np.where(np.isnan(stands), way.reshape(stands.shape), stands)


def _turning(time: Array, known: Array, quat: Array) -> Array:
    quat = sign_continuous(quat)
    left = np.clip(np.searchsorted(known, time + SAME_INSTANT, side="right") - 1, 0, len(known) - 2)
    share = np.clip((time - known[left]) / np.diff(known)[left], 0.0, 1.0)
    return sign_continuous(slerp(quat[left], quat[left + 1], share))
