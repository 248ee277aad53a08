"""A plan played on a simulated robot through its wire, in lock-step, and judged by the truth.

    played = play(plan, robot, "closed-loop", seed=3)
    played.ended.line, played.log, played.rollout.outcome.strict

`Rollout` and outcome are those of `llsrbm.simulate`, of the true motion from the plan's start on:
what the robot, its estimator and its player believe does not enter. Contacts of a plan's table are
the plan's, as it knows no others.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import takewhile
from typing import Any

import numpy as np

from llsrbm.control.contact_schedule import Flight
from llsrbm.control.controller import Tick
from llsrbm.control.inverse_dynamics import Command
from llsrbm.control.reference import Reference
from llsrbm.errors import Cancelled
from llsrbm.mechanics import GRAVITY
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Disturbance, Mode, Rollout
from llsrbm.motion.sampling import resample
from llsrbm.motion.surroundings import Surroundings, surroundings
from llsrbm.player import Ended, Player, Tier, make_tier
from llsrbm.player.closed_loop import ClosedLoop
from llsrbm.player.play_log import PlayLog
from llsrbm.player.states import Jumping, State, outline
from llsrbm.player.tier import PlanTier
from llsrbm.request.scenario import Scenario
from llsrbm.robots import Robot
from llsrbm.robots.drives.variants import driven
from llsrbm.simulation.disturbance import draw_disturbance
from llsrbm.simulation.episode import LEAST_TICKS, Fall, Recorder, fallen
from llsrbm.simulation.verdict import judge
from llsrbm.simulation.world import FLAT, TickResult
from llsrbm.wire.simulated_robot import (
    NOMINAL,
    TICK,
    UNDISTURBED,
    Conditions,
    DirectLink,
    SimulatedRobot,
    TrueTick,
)

_LOOK_EVERY = 20  # ticks between two calls of `cancelled` and `progress`


@dataclass(frozen=True, eq=False)
class Played:
    """How a play ended, what the player has recorded, and the true motion of the jump.

    `rollout`: None of a play that was stopped before its jump began.
    """

    ended: Ended
    log: PlayLog
    rollout: Rollout | None


class Witness:
    """Sees the true ticks of a jump, and the tier's decisions in them."""

    def __init__(self, tier: Tier) -> None:
        self._tier = tier
        self._state: State | None = None
        self.seen: list[tuple[TrueTick, Tick | None]] = []

    def enter(self, state: State) -> None:
        """The player's state that begins."""
        self._state = state

    def observe(self, true: TrueTick) -> None:
        """A tick of the simulated robot."""
        if isinstance(self._state, Jumping):
            self.seen.append((true, getattr(self._tier, "tick", None)))


def play(
    plan: Plan,
    robot: Robot,
    tier: str,
    seed: int = 0,
    *,
    conditions: Conditions = NOMINAL,
    around: Surroundings = FLAT,
    disturbance: Disturbance = UNDISTURBED,
    observer: Callable[[TrueTick], None] | None = None,
) -> Played:
    """Play a plan, without looking at its certificate; `observer` is called with each tick.

    `around`: by the plan's own time; its jump begins when the robot has stood for a while.
    Raises `InputError`: as the parts do.
    """
    chosen = make_tier(tier, plan, robot)
    before = takewhile(lambda row: row[0] != Jumping.name, outline(chosen, robot.posture[7:]))
    around = around.later(sum(duration for _, duration, _ in before))
    simulated = SimulatedRobot(
        robot, conditions, seed, surroundings=around, disturbance=disturbance
    )
    witness = Witness(chosen)
    simulated.observers.append(witness.observe)
    if observer is not None:
        simulated.observers.append(observer)
    player = Player(chosen, DirectLink(simulated), lambda: simulated.time, witness.enter)
    ended = player.run()
    rollout = None
    if len(witness.seen) >= LEAST_TICKS:
        rollout = _rollout(chosen, simulated, disturbance, witness, ended, seed)
    return Played(ended, player.log, rollout)


def play_in(
    plan: Plan,
    robot: Robot,
    scenario: Scenario,
    progress: Callable[[float], None],
    cancelled: Callable[[], bool],
) -> Played:
    """Play a plan by the closed loop in a scenario: its board, its drives, what its seed disturbs.

    Delay and sensors' noise are the wire's own. `progress`, `cancelled`: as `llsrbm.simulate` has
    them. Raises `Cancelled`.
    """
    tier, robot = ClosedLoop.name, driven(robot, scenario.drives)
    states = outline(make_tier(tier, plan, robot), robot.posture[7:])
    total = sum(duration for _, duration, _ in states)

    def look(true: TrueTick) -> None:
        if round(true.time / TICK) % _LOOK_EVERY == 0:
            if cancelled():
                raise Cancelled("the robot simulator was cancelled")
            progress(min(true.time / total, 1.0))

    disturbance = replace(draw_disturbance(robot, scenario), torque_delay_ticks=0)
    played = play(
        *(plan, robot, tier, scenario.seed or 0),
        around=surroundings(robot, plan, scenario),
        disturbance=disturbance,
        observer=look,
    )
    if played.rollout is None:
        return played
    ran = replace(played.rollout.scenario, drives=scenario.drives)
    return replace(played, rollout=replace(played.rollout, scenario=ran))


@dataclass(frozen=True)
class _Followed:
    """All that `judge` asks of a controller."""

    flights: list[Flight]
    landing: str


def _rollout(
    tier: PlanTier,
    simulated: SimulatedRobot,
    disturbance: Disturbance,
    witness: Witness,
    ended: Ended,
    seed: int,
) -> Rollout:
    plan, robot = tier.plan, tier.robot
    recorder = Recorder(robot, disturbance)
    begun = witness.seen[0][0].time
    by_clock = None if isinstance(tier, ClosedLoop) else _ByClock(plan, robot)
    fall = None
    if ended.reason:
        fall = Fall(ended.time - begun, f"the player stopped: {ended.reason}")
    for true, decided in witness.seen:
        time = true.time - begun
        tick = by_clock.tick(time) if by_clock is not None else decided
        assert tick is not None  # the tier has decided before the robot moved
        result = _since(true.result, begun)
        recorder.add(true.state, true.mujoco_state, tick, 0.0, result)
        seen = fallen(time, true.state[0], tick.target.R_world_base, result)
        if seen is not None and (fall is None or seen.time < fall.time):
            fall = seen
    order = simulated.world.joint_order
    columns = recorder.arrays(order)
    columns["time"] = np.arange(len(recorder)) * TICK
    if isinstance(tier, ClosedLoop):
        flights, landing = tier.controller.flights, tier.controller.landing
        threshold = tier.controller.detector.threshold
    else:
        flights, landing, threshold = _planned_flights(plan), tier.name, 0.0
    followed: Any = _Followed(flights, landing)
    return Rollout(
        jump=plan.jump,
        robot_parameters=robot.parameters(),
        control_parameters=robot.control_parameters(),
        scenario=Scenario(seed=seed, noise=0.0, estimator="imu"),
        disturbance=disturbance,
        outcome=judge(robot, plan, recorder, columns, followed, fall, len(recorder) * TICK),
        plan=plan,
        joint_names=tuple(robot.joint_names[j] for j in order),
        detection_threshold=threshold,
        **columns,
    )


def _since(result: TickResult, begun: float) -> TickResult:
    """With times since the jump's start."""
    return replace(
        result,
        first_contact=result.first_contact - begun,
        touches=tuple((touch, time - begun) for touch, time in result.touches),
    )


def _planned_flights(plan: Plan) -> list[Flight]:
    start = plan.phase_start
    return [Flight(k, float(start[k]), float(start[k + 1])) for k in plan.schedule.flights]


class _ByClock:
    """Decisions as a table has them: the plan's, at its own times."""

    def __init__(self, plan: Plan, robot: Robot) -> None:
        self._plan = plan
        self._reference = Reference(plan, robot.mass * GRAVITY)
        nothing = np.zeros(robot.model.nv)
        self._command = Command(
            nothing[6:], nothing, np.zeros_like(plan.contact_force[0]), solved=True
        )

    def tick(self, time: float) -> Tick:
        """At a time, s since the plan's start."""
        plan = self._plan
        at = resample(plan, np.array([min(time, plan.duration)]))
        return Tick(
            *(self._command, int(at.phase[0]), Mode.TRACKING, self._reference.at(time)),
            *(at.foot_position[0], 0.0, 0.0),
        )
