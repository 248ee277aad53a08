"""Planning anew while the robot is under way: the loop around the replanner.

Every `PERIOD` the newest measurement is handed to the replanner, extrapolated by the robot's
latency, after which the answer is followed. The latency is a number of the robot's file, so that a
rollout does not depend on how busy the machine is; with `replan_latency="measured"` answers whose
computation took longer come that much later. An answer that comes after feet have met the ground is
dropped, and where none is found the old plan goes on. Answers are followed once the robot has
departed from its first plan.
"""

import math
import time
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from llsrbm.arrays import Array
from llsrbm.control.reference import Reference
from llsrbm.control.swing import UnderWay
from llsrbm.control.whole_body import WholeBody
from llsrbm.mechanics import GRAVITY
from llsrbm.motion.plan import Plan
from llsrbm.motion.replan import Replan
from llsrbm.planning.replan.replanner import Answer, Replanner
from llsrbm.planning.replan.under_way import State
from llsrbm.robots import Robot
from llsrbm.simulation.episode import Hook, Situation

PERIOD = 0.02  # s: 50 Hz
# s from a measurement until its answer is followed, where a robot's file states none: with four
# legs or more, and with fewer. Above the 95th percentiles of ANYmal and Go2, and of SLIDER.
LATENCY, LATENCY_FEW_LEGS = 0.02, 0.03
# s that are left of a flight, or of the last stance, in which the last plan is as good as new ones.
LEAST_FLIGHT = 0.03
LEAST_STANCE = 0.10
FOLLOWS = 0.06  # m from its target: a foot that is nearer is where it is wanted
# From the plan, of the CoM horizontally and, in flight, vertically, m/s, and of the whole body's
# mean turning in flight, rad/s: who departs less is as well off with the first plan, whose landing
# was shaped without haste. Disturbed robots that nobody pushes depart by 0.21 m/s at most, by 0.13
# at the 95th percentile; ANYmal lands from pushes of 0.3 m/s without new plans, SLIDER of 0.24.
DEPARTED_ALONG, DEPARTED_UP, DEPARTED_TURNING = 0.2, 0.3, 1.0
# And in flight, with soles, m horizontally that the CoM comes down from where it was planned to.
# Legs with soles are heavy and turn the base as they move: SLIDER, pushed by 0.3 m/s in mid-flight,
# 0.04 m, lands in 64 of 80 cases on its first plan, in 48 with feet moved in the last moment. After
# 0.24 m/s at the end of take-off, 0.07 m, there is time to move them.
DEPARTED_ASIDE = 0.055


def latency_of(robot: Robot) -> float:
    """Time (s) from a measurement until a plan made from it is followed."""
    stated = robot.file.control.replan_latency
    if stated is not None:
        return stated
    return LATENCY if len(robot.legs) >= 4 else LATENCY_FEW_LEGS


@dataclass(frozen=True, eq=False)
class _Pending:
    """An answer that is not followed yet: its place among the replans, and when it is ready, s."""

    index: int
    phase: int
    ready: float
    reference: Reference


class Replanning(Hook):
    """Asks the replanner in flight and after touchdown, and hands its plans to the controller."""

    def __init__(self, plan: Plan, robot: Robot, tick: float, latency: str) -> None:
        """Load the solvers of all phases that will be planned anew.

        `latency`: "fixed", or "measured": answers that took longer than the robot's come later.
        """
        self._latency, self._measured = latency_of(robot), latency == "measured"
        self._replanner = Replanner(plan, robot)
        self._first = plan.schedule.flights[0]
        for phase in range(self._first, len(plan.schedule)):
            if self._replanner.in_flight or not plan.schedule[phase].is_flight:
                # Where answers come as late as they take, the first run is as good as the next.
                self._replanner.prepare(phase, settled=self._measured)
        self._body = WholeBody(robot)
        self._soles = robot.foot_coordinates > 3
        self._tick = tick
        self._next = 0.0
        self._departed = False  # from the first plan: new ones are followed from then on
        self._pending: _Pending | None = None

    def before(self, situation: Situation) -> None:
        """Take over what has been found, and plan anew."""
        now = situation.time + self._tick / 2  # times are rounded
        contacts = situation.controller.contacts
        self._take_over(situation, now)
        if self._pending is not None or now < self._next or contacts.phase < self._first:
            return
        if contacts.flying and not self._replanner.in_flight:
            return
        left = self._left(situation)
        settled = contacts.flying or not contacts.seeking.any()
        if left > (LEAST_FLIGHT if contacts.flying else LEAST_STANCE) and settled:
            self._plan_anew(situation)

    def _take_over(self, situation: Situation, now: float) -> None:
        pending, controller = self._pending, situation.controller
        if pending is None or now < pending.ready:
            return
        self._pending = None
        if controller.contacts.phase != pending.phase:
            return
        controller.set_reference(pending.reference)
        self._replanner.plan = pending.reference.plan
        replan = situation.replans[pending.index]
        situation.replans[pending.index] = replace(replan, applied=situation.time)

    def _plan_anew(self, situation: Situation) -> None:
        controller, measured = situation.controller, situation.time
        began = time.thread_time()
        state = self._expected(situation)
        answer = self._replanner.replan(state)
        reference = None
        if answer.plan is not None:
            start = UnderWay(
                state.time, state.foot_velocity - state.com_velocity, state.foot_yaw_rate
            )
            reference = controller.reference_of(answer.plan, start)
        computing = time.thread_time() - began
        # From the plan's clock to that of the simulation.
        offset = measured + self._latency - state.time
        situation.replans.append(_record(measured, computing, answer, state, offset))
        delay = self._latency
        if self._measured:
            delay = max(delay, math.ceil(computing / self._tick) * self._tick)
        ready = measured + delay
        self._next = max(measured + PERIOD, ready)
        self._departed = self._departed or self._departs(situation, state)
        if reference is not None and self._departed:
            index = len(situation.replans) - 1
            self._pending = _Pending(index, controller.contacts.phase, ready, reference)

    def _left(self, situation: Situation) -> float:
        """S of the phase that are left when an answer can be followed."""
        contacts = situation.controller.contacts
        end = float(self._replanner.plan.phase_start[contacts.phase + 1])
        return end - float(contacts.plan_time(situation.time)) - self._latency

    def _departs(self, situation: Situation, state: State) -> bool:
        controller = situation.controller
        target = controller.target(situation.time + self._latency)
        along = state.com_velocity - target.com_velocity
        momentum = state.angular_momentum - target.angular_momentum
        turning = np.linalg.solve(self._body.inertia, momentum)
        flying = controller.contacts.flying
        speed = np.hypot(along[0], along[1])
        nearby = flying and self._soles and speed * self._left(situation) < DEPARTED_ASIDE
        return bool(
            (speed > DEPARTED_ALONG and not nearby)
            or (flying and abs(along[2]) > DEPARTED_UP)
            or (flying and np.linalg.norm(turning) > DEPARTED_TURNING)
        )

    def _expected(self, situation: Situation) -> State:
        """The state at the time at which an answer can be followed.

        In flight the CoM falls, and feet move on as they do, seen from it. On the ground the CoM is
        accelerated as planned, and feet stay.
        """
        latency, body, controller = self._latency, self._body, situation.controller
        contacts, measurement = controller.contacts, situation.measurement
        body.update(measurement.q, measurement.v)
        at = situation.time + latency
        target = controller.target(at)
        below = np.array([0.0, 0.0, contacts.ground_shift])
        momentum: Array = np.array(body.angular_momentum)
        if contacts.flying:
            acceleration = np.array([0.0, 0.0, -GRAVITY])
        else:
            acceleration = target.com_acceleration
            momentum = momentum + latency * target.angular_momentum_rate
        velocity = body.com_velocity + latency * acceleration
        com = body.com + latency * body.com_velocity + latency**2 / 2 * acceleration - below
        R = pin.exp3(body.angular_velocity * latency) @ body.R_world_base
        x, y, z, w = pin.Quaternion(R).coeffs()
        yaw = np.arctan2(body.R_world_foot[:, 1, 0], body.R_world_foot[:, 0, 0])
        if contacts.flying:
            rate = body.foot_velocity - body.com_velocity
            from_com = body.foot - body.com + latency * rate
            # Feet that follow their targets go on from there: from where they are, how far they lag
            # behind would be forgotten each time, and they would never catch up.
            follows = np.linalg.norm(target.foot_from_com - from_com, axis=1) < FOLLOWS
            from_com[follows] = target.foot_from_com[follows]
            rate[follows] = target.foot_velocity_from_com[follows]
            foot, foot_velocity = com + from_com, velocity + rate
            yaw_rate = np.array(body.foot_angular_velocity[:, 2])
            yaw = yaw + latency * yaw_rate
        else:
            foot, foot_velocity = body.foot - below, np.zeros_like(body.foot)
            yaw_rate = np.zeros_like(yaw)
        return State(
            time=contacts.plan_time(at),
            phase=contacts.phase,
            com=com,
            com_velocity=velocity,
            base_quat=np.array([w, x, y, z]),
            angular_velocity=np.array(body.angular_velocity),
            angular_momentum=momentum,
            foot_position=foot,
            foot_velocity=foot_velocity,
            foot_yaw=yaw,
            foot_yaw_rate=yaw_rate,
            joints=body.q[7:] + latency * body.v[6:],
            joint_speeds=np.array(body.v[6:]),
        )


def _record(
    measured: float, computing: float, answer: Answer, state: State, offset: float
) -> Replan:
    """The record of an answer; `offset` s from the plan's clock to the simulation's."""
    plan, legs = answer.plan, len(state.foot_position)
    touchdown = math.nan
    shapes: dict[str, tuple[int, ...]] = {"time": (), "com": (3,), "base_quat": (4,)}
    shapes |= {"foot_position": (legs, 3), "foot_quat": (legs, 4)}
    arrays = {name: np.zeros((0, *shape)) for name, shape in shapes.items()}
    if plan is not None:
        new = plan.time >= state.time - 1e-9
        arrays = {name: getattr(plan, name)[new] for name in shapes}
        arrays["time"] = arrays["time"] + offset
        ends = (float(plan.phase_start[p + 1]) for p in plan.schedule.flights)
        touchdown = next((end + offset for end in ends if end > state.time), math.nan)
    return Replan(
        measured=measured,
        applied=math.nan,
        computing_time=computing,
        solved=plan is not None,
        iterations=answer.iterations,
        touchdown=touchdown,
        **arrays,
    )
