"""Replanning of the rest of a jump from a measured state, fast enough for 50 Hz.

The same stages, constraints and costs as a plan's, from a state in which the robot is under way: in
flight the CoM's parabola and the angular momentum are what they are, and what is left to choose is
how the legs move, when and where they meet the ground, and the forces after that. All places where
feet will land are shifted alike (`Layout`); feet that stand stay where they are.

The horizon is short, a few intervals a phase, and each solve starts from the last one: of the plan
at first, sampled at the new knots.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from llsrbm.arrays import Array
from llsrbm.errors import InputError
from llsrbm.mechanics import GRAVITY, interpolated, sign_continuous
from llsrbm.models import free_arms_of, make_model
from llsrbm.motion.plan import Plan
from llsrbm.ocp import solvers
from llsrbm.ocp.horizon import Iterate, Solution
from llsrbm.ocp.progress import when_idle
from llsrbm.planning.problem.knots import Knots, Sampled, pack, unpack
from llsrbm.planning.problem.layout import NOMINAL_PHASES, Layout
from llsrbm.planning.problem.placement import task_of
from llsrbm.planning.problem.rotations import feet_seen
from llsrbm.planning.problem.task import Footholds, InMotion, Task, contact_points
from llsrbm.planning.replan.under_way import (
    State,
    falling_time,
    plan_quat,
    planned_state,
    relaxed_limits,
    swings_begun,
)
from llsrbm.planning.solve.formulation import Formulation, knot_arrays
from llsrbm.planning.solve.kept import kept
from llsrbm.planning.solve.solver_cache import cached_solver, of_jumps
from llsrbm.request.schedule import Schedule
from llsrbm.robots.drives.variants import with_strength
from llsrbm.robots.robot import Robot

# Of a stance, and of a flight, whose stages take twice as long to solve. Plans have 16; what
# is left of a phase is shorter, and the next answer comes soon.
STANCE_INTERVALS, FLIGHT_INTERVALS = 6, 4

SHORTEST = 0.02  # s that what is left of a phase may be shortened to
SAME_TIME = 2e-3  # s; a knot of the plan that is nearer to the state's time is left out
MAX_EXTENSION = 0.3  # s by which a phase may outlast its limit: a push upwards is longer in the air
# From the sampled plan, which is near a solution where nothing has happened.
FIRST = solvers.SolveOptions(
    mu=1e-4, iterations=25, tolerance=1e-3, push=0.02, within=solvers.WITHIN, acceptable=(5e-3, 4)
)
# Near solutions creep as well, SLIDER's for all iterations that they are given: stopped so, half of
# them come 10 ms sooner, and as many land.
ACCEPTABLE = (5e-3, 1)
# Rows of an answer may be off by this much, in their units of about 1: a millimetre, a per mille of
# the weight. The next answer comes 20 ms later.
GOOD_ENOUGH = 2e-3
# A last solution that violates its rows now by more is no start: of one from the
# last period, and of an older one. Without a push 40 ms make 0.6, right after one it is 1 and more.
# Of 70 pushes at the edge of what is recovered from 66 are with 8, 62 with 4. Looser solves take
# fewer iterations from there, and of their plans fewer land: 52 at ten times the tolerance.
MAX_MISS_LAST, MAX_MISS_OLDER = 8.0, 0.8
MAX_AGE_LAST = 0.025  # s
# A guess that violates rows by more is of a robot that has fallen, or soon will have: guesses after
# pushes that are recovered from violate them by 1 to 3, and Fatrop may not come back from far away.
MAX_GUESS_MISS = 8.0
# Quantities of the plan that a guess is made of.
SAMPLED = (
    "com",
    "com_velocity",
    "angular_momentum",
    "base_quat",
    "angular_velocity",
    "foot_in_hip",
    "joint_position",
)
MAX_AGE = 0.12  # s; the last solution is a start for so long


@dataclass(frozen=True, eq=False)
class Answer:
    """Result of replanning from a state.

    Attributes:
        plan: the whole jump, with what remains of it planned anew; None if nothing was found.
        iterations, solve_time_s: of the solves.
    """

    plan: Plan | None
    iterations: int
    solve_time_s: float


class Replanner:
    """Plans what remains of one jump; a solver for each phase in which it replans.

    Attributes:
        plan: the one that is followed, to be set when an answer is taken over.
        in_flight: whether it plans flights: of a jump over something it does not see what is to be
            cleared, and plans the landing alone.
    """

    def __init__(self, plan: Plan, robot: Robot) -> None:
        """Nothing has been planned anew.

        Args:
            plan: one that converged, of `robot`.
            robot: as the controller believes it is.

        Raises:
            InputError: the plan has a payload.
        """
        jump = plan.jump
        if jump.payload:
            raise InputError(
                "replan: plans anew for the robot alone; expected a plan without a payload"
            )
        when_idle()
        self.plan = plan
        # Rows are of the file's drives, whatever the plan says of them.
        self._robot = with_strength(robot.turning if jump.turns else robot)
        free = free_arms_of(jump, self._robot)
        self._model = make_model(jump.model, self._robot, free_arms=free)
        task = task_of(plan, self._robot)
        self._task = relaxed_limits(task)
        self.in_flight = not task.clears
        self._formulations: dict[Layout, Formulation] = {}
        # And for which time, s on the plan's clock.
        self._last: dict[Layout, tuple[float, Iterate]] = {}

    def prepare(self, phase: int, *, settled: bool = False) -> None:
        """Load the solvers of what remains in a phase, or build them, and solve it as planned.

        `settled`: wait for a compiler that is at work on them: answers come as fast as ever then.
        Twice, as guesses and solutions have solvers of their own: so that the first answer comes as
        fast as the later ones.
        """
        state = planned_state(self.plan, phase)
        if settled:
            self._formulation(self._task_from(state).schedule).solver.settle()
        for _ in range(2):
            self.replan(state)

    def replan(self, state: State) -> Answer:
        """Plan what remains: what is found replaces `plan` from the state's time on."""
        task = self._task_from(state)
        layout, found, iterations, seconds = self._solved(task, state)
        if found is None:
            return Answer(None, iterations, seconds)
        plan = self._spliced(unpack(found.variables, layout, task, self._model), state)
        return Answer(plan, iterations, seconds)

    def _solved(self, task: Task, state: State) -> tuple[Layout, Solution | None, int, float]:
        """From the last solution, else from the sampled plan; with all iterations and seconds."""
        formulation = self._formulation(task.schedule)
        layout, solver = formulation.layout, formulation.solver
        problem = formulation.problem(task)
        solved_at, last = self._last.pop(layout, (-np.inf, None))
        solution: Solution | None = None
        iterations, seconds = 0, 0.0
        for start in ("last", "sampled"):
            if start == "sampled":
                guess = pack(layout, self._sampled(task, layout, state))
                if solver.miss(problem, guess) > MAX_GUESS_MISS:
                    break
                solution = solver.solve(problem, guess, options=FIRST)
            elif last is not None and state.time - solved_at < MAX_AGE:
                max_miss = (
                    MAX_MISS_LAST if state.time - solved_at < MAX_AGE_LAST else MAX_MISS_OLDER
                )
                solution = solver.follow(problem, last, max_miss, ACCEPTABLE)
            if solution is None:
                continue
            iterations += solution.iterations
            seconds += solution.solve_time_s
            if np.isfinite(solution.variables).all() and solution.violation < GOOD_ENOUGH:
                self._last[layout] = (state.time, solution)
                return layout, solution, iterations, seconds
        return layout, None, iterations, seconds

    def _rest(self, phase: int, time: tuple[float, float]) -> Schedule:
        rest = self._task.schedule.rest(phase, time)
        shares = (FLIGHT_INTERVALS / STANCE_INTERVALS if p.is_flight else 1.0 for p in rest)
        phases = tuple(replace(p, share=s) for p, s in zip(rest, shares, strict=True))
        return replace(rest, phases=phases)

    def _formulation(self, rest: Schedule) -> Formulation:
        layout = Layout.of(
            rest,
            len(self._robot.legs) * len(self._robot.corners),
            NOMINAL_PHASES * STANCE_INTERVALS,
            self._robot.foot_coordinates,
            turns=self._task.jump.turns,
            arm_joints=len(self._task.free_arms),
        )
        if layout not in self._formulations:  # held: answers have no time to load one
            own = self._robot, self._task.jump.model, layout
            self._formulations[layout] = kept((Formulation, *own), lambda: _formulation(*own))
        return self._formulations[layout]

    def _task_from(self, state: State) -> Task:
        """The task of the rest of the jump, from a state on."""
        task, plan = self._task, self.plan
        elapsed = state.time - float(plan.phase_start[state.phase])
        low, high = task.times(state.phase)
        least = low - elapsed
        if self._falls(state.phase):  # and is down before where it was pushed down
            landing = interpolated(float(plan.phase_start[state.phase + 1]), plan.time, plan.com)
            least = min(least, falling_time(state.com[2] - landing[2], state.com_velocity[2]))
        least = max(least, SHORTEST)
        rest = self._rest(state.phase, (least, max(high - elapsed, least) + MAX_EXTENSION))
        R_base_world = Rotation.from_quat(state.base_quat, scalar_first=True).inv().as_matrix()
        index = task.free_arms
        arms = state.joints[index], state.joint_speeds[index]
        x, xdot = feet_seen(self._model)(
            R_base_world.T,
            state.com,
            state.com_velocity,
            R_base_world @ state.angular_velocity,
            state.foot_position.T,
            state.foot_velocity.T,
            state.foot_yaw,
            state.foot_yaw_rate,
            *(arms if len(index) else ()),
        )
        motion = InMotion(
            momentum=state.angular_momentum,
            feet=np.array(x).T,
            feet_velocity=np.array(xdot).T,
            heights=state.foot_position[:, 2],
            begun=swings_begun(plan, state),
            arms=arms,
        )
        places, goal = self._places(state)
        # The goal's sign is that of the way there.
        quat = state.base_quat * np.sign(plan_quat(plan, state.time) @ state.base_quat)
        return replace(
            task,
            schedule=rest,
            places=places,
            start_position=state.com,
            start_velocity=state.com_velocity,
            start_quat=quat,
            goal_position=goal,
            motion=motion,
            clears=False,
        )

    def _places(self, state: State) -> tuple[tuple[Footholds, ...], Array]:
        """Where feet stand and will stand, and where the CoM ends.

        Standing feet are where they are; what comes after is moved by as much as their mean.
        """
        task = self._task
        phase = task.schedule[state.phase]
        places = list(task.places)
        stands = task.schedule.stands[state.phase]
        if not stands.any():
            return tuple(places), task.goal_position
        planned = places[phase.place]
        moved = (state.foot_position - planned.feet)[stands].mean(axis=0) * [1.0, 1.0, 0.0]
        corners = task.corners
        for k in range(phase.place, len(places)):
            feet, yaw = places[k].feet + moved, places[k].yaw.copy()
            if k == phase.place:
                feet[stands, :2] = state.foot_position[stands, :2]
                yaw[stands] = state.foot_yaw[stands]
            places[k] = replace(
                places[k],
                feet=feet,
                yaw=yaw,
                contacts=contact_points(feet, yaw, corners),
                origin=places[k].origin + moved,
            )
        return tuple(places), task.goal_position + moved

    def _sampled(self, task: Task, layout: Layout, state: State) -> Sampled:
        """The newest plan from the state's time on, moved to where the state is.

        In flight the CoM falls from the state to the height at which it is planned to land. Its
        error there moves all that follows; other differences fade until the end.
        """
        plan, flying = self.plan, self._falls(state.phase)
        starts = plan.phase_start[state.phase :].copy()
        starts[0] = state.time
        landing = interpolated(starts[1], plan.time, plan.com)
        durations = self._durations(task, starts, landing, state)
        # Of the plan: a flight that takes longer is as far at the same share of it.
        times = starts[layout.phase] + layout.progress * np.diff(starts)[layout.phase]
        since = layout.progress * durations[0]
        com, velocity, momentum, quat, omega, feet, joints = (
            interpolated(times, plan.time, getattr(plan, name)) for name in SAMPLED
        )
        shift = np.zeros(3)
        fading = 1 - (times - state.time)[:, None] / (starts[-1] - state.time)
        position = com + fading * (state.com - com[0])
        speed = velocity + fading * (state.com_velocity - velocity[0])
        if flying:
            fall, T = np.array([0.0, 0.0, -GRAVITY]), durations[0]
            shift[:2] = (state.com + T * state.com_velocity - landing)[:2]
            t, falls = since[:, None], (layout.phase == 0)[:, None]
            parabola = state.com + t * state.com_velocity + t**2 / 2 * fall
            position = np.where(falls, parabola, com + shift)
            speed = np.where(falls, state.com_velocity + t * fall, speed)
        assert task.motion is not None
        feet[0] = task.motion.feet
        steps = durations[layout.phase[:-1]] / [role.intervals for role in layout.roles[:-1]]
        rate = np.concatenate(
            [task.motion.feet_velocity[None], np.diff(feet, axis=0) / steps[:, None, None]]
        )
        arms = joints[:, task.free_arms]
        arms[0], speeds = task.motion.arms
        arm_rate = np.concatenate([speeds[None], np.diff(arms, axis=0) / steps[:, None]])
        quat = sign_continuous(quat / np.linalg.norm(quat, axis=1, keepdims=True))
        quat = quat * (np.sign(quat[0] @ task.start_quat) or 1.0)
        R = Rotation.from_quat(quat, scalar_first=True)
        force = self._forces(layout, times) / (task.mass * GRAVITY / layout.contacts)
        first = layout.first_knots[1] if flying else 0
        return Sampled(
            durations=durations,
            position=position,
            velocity=speed,
            quat=quat,
            momentum=(momentum + fading * (state.angular_momentum - momentum[0])) / task.mass,
            rotation_rate=R.inv().apply(omega),
            feet=feet,
            feet_velocity=rate,
            arms=arms,
            arms_velocity=arm_rate,
            force=force,
            landing_force=force[first],
            shift=shift[:2],
        )

    def _forces(self, layout: Layout, times: Array) -> Array:
        """(K, L, c, 3) N, the plan's at times (K,) s."""
        plan = self.plan
        at = np.clip(np.searchsorted(plan.time, times + 1e-6) - 1, 0, len(plan.time) - 2)
        return plan.contact_force[at].reshape(len(times), layout.legs, layout.corners, 3)

    def _durations(self, task: Task, starts: Array, landing: Array, state: State) -> Array:
        """(P,) s of the phases that begin and end at `starts` (P+1,), within the task's limits."""
        durations = np.diff(starts)
        if self._falls(state.phase):
            durations[0] = falling_time(state.com[2] - landing[2], state.com_velocity[2])
        return np.clip(durations, *np.array([task.times(p) for p in range(len(durations))]).T)

    def _falls(self, phase: int) -> bool:
        return self._task.schedule[phase].is_flight

    def _spliced(self, knots: Knots, state: State) -> Plan:
        """The plan until the state, and what was found from there on."""
        plan = self.plan
        near = interpolated(state.time + knots.time, plan.time, plan.joint_position)
        knots = replace(knots, near_angles=near)
        before = plan.time < state.time - SAME_TIME
        before |= (plan.phase < state.phase) & (plan.time < state.time - 1e-6)
        found = knot_arrays(knots)
        found["time"] = found["time"] + state.time
        found["phase"] = found["phase"] + state.phase
        arrays: dict[str, Any] = {
            name: values
            if name == "leg_mass"
            else np.concatenate([getattr(plan, name)[before], values])
            for name, values in found.items()
        }
        return replace(
            plan,
            **arrays,
            joint_velocity=None,
            joint_torque=None,
            joint_torque_limit=None,
            feedback_gain=None,
            solution=None,
            # Its knots are the first stage's from there on.
            refinement=None,
            certificate=None,
        )


def _formulation(robot: Robot, model: str, layout: Layout) -> Formulation:
    made = make_model(model, robot, free_arms=layout.arm_joints > 0)
    return Formulation(
        robot, made, layout, cached_solver(solvers.Fatrop, of_jumps(made, layout, robot))
    )
