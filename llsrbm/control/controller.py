"""The whole-body controller: what is wanted in each phase of a plan, and torques for it."""

from dataclasses import dataclass

import numpy as np

from llsrbm.arrays import Array, BoolArray
from llsrbm.control import landing, tasks
from llsrbm.control.contact_schedule import JUST_AFTER, ContactSchedule, Flight
from llsrbm.control.delay import DelayEstimate, Measurement
from llsrbm.control.detection import CentroidalState, make_detector, model_uncertainty
from llsrbm.control.foot_force import FootForces
from llsrbm.control.inverse_dynamics import Command, InverseDynamics
from llsrbm.control.joint_bounds import JointBounds
from llsrbm.control.leaving import SWEEPING, SWINGING, leaving
from llsrbm.control.link_bounds import LinkBounds
from llsrbm.control.reference import Reference, Target
from llsrbm.control.swing import UnderWay
from llsrbm.control.take_off import TakeOff
from llsrbm.control.unmodelled import Unmodelled
from llsrbm.control.whole_body import WholeBody
from llsrbm.mechanics import GRAVITY
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Mode
from llsrbm.request.scenario import Scenario
from llsrbm.robots import Robot
from llsrbm.robots.drives.torques import friction_torque, torque_range

_FREE_FALL = np.array([0.0, 0.0, -GRAVITY])
_NOT_NEEDED = np.zeros(6)  # by detectors, which listen in flight alone
# A foot of a body that turns over sweeps over the ground at 4 m/s; where it seeks the ground it
# stops that, so many times as fast as feet that swing are damped.
_STOPS_SWEEPING = 3.0
# m/s at which feet seek the ground once others stand. A body that lands tilted has one pair of feet
# 1 cm above the ground, and it falls on while it waits for them, as forces of the other pair alone
# would turn it: at 0.5 m/s they come 30 ms late, and the trunk may meet the ground. 4 m/s is no
# better, and feet slip more.
_SEEKING = 2.5
# As feet strike, legs that are still in the air are what the attitude's weight would swing to hold
# it, at 7 m/s and off the ground: where feet seek it they count so many times as where they swing.
_SEEKS = 10.0
# Where a take-off is steered the CoM's accelerations go with the momentum's rate: they count more.
_STEERED = 10.0
_SINKING = -0.1  # m/s; a plan lands at least as fast
_STRETCH = 0.05  # m; farther from its planned height a robot meets other ground than planned


@dataclass(frozen=True, eq=False)
class Tick:
    """The controller's decision of one tick."""

    command: Command  # torques, accelerations and forces
    phase: int  # index of the plan's phase, as the controller believes
    mode: Mode  # likewise
    target: Target  # what was tracked
    foot_target: Array  # (L, 3) m: where the feet's lowest points should be, world frame
    average_spatial_velocity_norm: float  # ‖v_G‖
    detection_signal: float  # the detector's


class WholeBodyController:
    """Follows one plan, tick by tick, from standing to standing.

    `robot` is as the controller believes it is; `scenario` names detector, landing strategy and QP
    solver. Raises `InputError`: one of those is unknown, or the strategy not for this robot.
    """

    def __init__(self, robot: Robot, plan: Plan, scenario: Scenario) -> None:
        settings = robot.file.control
        self._settings = settings
        self._tick = 1.0 / settings.rate
        self._robot = robot
        self.landing = landing.resolved(
            scenario.landing, settings.force_phase, turns=plan.jump.turns
        )
        self._landing = landing.landing_strategy(self.landing)
        self._body = body = WholeBody(robot)
        # The same share of what the plan was made with as of what the robot is planned with.
        friction = settings.friction * (plan.friction / robot.file.limits.friction)
        self._dynamics = InverseDynamics(body, friction, scenario.solver, self._tick)
        self._delay = DelayEstimate(self._tick, robot.drive_delay)
        self._unmodelled = Unmodelled(self._tick, body.velocities)
        self._joints, self._links = JointBounds(robot), LinkBounds(robot)
        self._reference = self.reference_of(plan)
        self.detector = make_detector(scenario.detector, self._tick, model_uncertainty(robot.file))
        # Not of barrel rolls: legs are most of their inertia, and the base turns as they do. A plan
        # that is made anew under way keeps these gains.
        self._take_off = TakeOff(plan, robot.mass, self._tick) if plan.jump.pitch else None
        feet = FootForces(robot, body, self._tick)
        self.contacts = ContactSchedule(plan, body, feet, self._tick)
        gains = settings.gains
        self._com = tasks.CentreOfMass(gains.com)
        self._angular_momentum = tasks.AngularMomentum(gains.angular_momentum)
        self._orientation = tasks.BaseOrientation(gains.orientation)
        self._posture = tasks.Posture(range(body.velocities - 6), body.velocities, gains.posture)
        self._arms: list[tuple[tasks.Task, float]] = []
        if robot.arms:
            arms = tasks.Arms(robot.arm_joint_index.tolist(), body.velocities, gains.arms)
            self._arms = [(arms, settings.weights.arms)]
        points = body.contacts // body.legs
        # By which feet stand and which seek the ground: few of all that could be.
        self._feet: dict[tuple[bytes, bytes], list[tuple[tasks.Task, float]]] = {}
        self._carried: dict[bytes, Array] = {}  # by which feet stand
        self._seeking_damping = gains.swing[1] * (_STOPS_SWEEPING if plan.jump.turns else 1.0)
        self._points = points
        self._momentum_share = 1.0
        self._stretch = np.zeros(3)  # m: of the legs in flight, down if negative

    @property
    def flights(self) -> list[Flight]:
        """Flights that have begun, in order, each with when its touchdown was detected."""
        return self.contacts.flights

    def reference_of(self, plan: Plan, start: UnderWay | None = None) -> Reference:
        """A plan as it can be followed, from where it begins under way; None: from its start."""
        return Reference(plan, self._robot.mass * GRAVITY, start)

    def target(self, time: float) -> Target:
        """The target at a time, s since the first plan's start."""
        return self._reference.at(self.contacts.plan_time(time))

    def set_reference(self, reference: Reference) -> None:
        """Follow another plan from the next step on, of the same schedule and clock."""
        self._reference = reference
        self.contacts.follow(reference.plan)
        if not self.contacts.flying:  # it begins with the landing's real momentum
            self._momentum_share = 1.0

    def step(self, measurement: Measurement) -> Tick:
        """Decide the torques of the tick that begins with a measurement: all that it knows.

        Torques are for the state and the time at which they will begin to act; in flight the ground
        is listened for in what is measured, as what is predicted has not happened.
        """
        body, contacts, measured = self._body, self.contacts, measurement
        self._delay.measured(measured.torque)
        self._unmodelled.measured(measured.v, self._delay.acted(), contacts.standing)
        if self._reference.slopes:
            body.stand_on(self._reference.normals(contacts.plan_time(measured.time)))
        foreseen = self._delay.met(measured, body)
        flew = contacts.flying
        known = measured if flew else foreseen
        (body.update_momentum if flew else body.update)(known.q, known.v)
        if contacts.follow_clock(known.time):
            self.detector.reset()
        flying = contacts.flying
        state = CentroidalState(
            body.mass,
            body.com_velocity,
            body.angular_momentum,
            body.inertia,
            body.trunk_momentum if flying else _NOT_NEEDED,
        )
        hit = flying and self.detector.update(state)
        if flew:  # what is foreseen has not met the ground
            known = measured if hit else foreseen
            body.update(known.q, known.v)
        contacts.find_contacts(measured, state.com_velocity, hit=hit)
        if flying and not contacts.flying:
            planned = self._reference.late(contacts.phase - 1).com_velocity[2]
            self._momentum_share = float(body.com_velocity[2] / min(planned, _SINKING))
        elif hit:  # not by the ground
            known = foreseen
            body.update(known.q, known.v)
        time = known.time
        target = self._target(time)
        mode = self._mode(time)
        command = self._solve(target, mode, time)
        self._delay.sent(command)
        return Tick(
            command,
            contacts.phase,
            mode,
            target,
            self._foot_target(target),
            state.average_spatial_velocity_norm,
            self.detector.signal if flying else 0.0,
        )

    def _mode(self, time: float) -> Mode:
        detected = self.contacts.detected
        if detected is None or not self._landing.follows_forces or not self.contacts.lands(time):
            return Mode.TRACKING
        early = time - detected < self._settings.force_phase - self._tick / 2
        return Mode.FORCE if early else Mode.TRACKING

    def _target(self, time: float) -> Target:
        """The plan, retimed to the last touchdown and raised by the height of its ground."""
        contacts = self.contacts
        target = self._reference.at(contacts.reference_time(time))
        acceleration = target.com_acceleration
        if contacts.flying:
            if time > self.flights[-1].touchdown - JUST_AFTER:
                target = self._reference.late(contacts.phase)
                target = target._replace(foot_from_com=target.foot_from_com + self._stretch)
            else:
                target = self._reaching(target)
                since = time - self.flights[-1].lift_off
                way = SWEEPING if self._reference.plan.jump.turns else SWINGING
                target = leaving(way, target, self._body, since, contacts.foothold[:, 2])
            acceleration = _FREE_FALL
        raised = target.com + np.array([0.0, 0.0, contacts.ground_shift])
        return target._replace(com=raised, com_acceleration=acceleration)

    def _reaching(self, target: Target) -> Target:
        """Feet in flight that meet the ground at the planned time, however high the CoM flies.

        They are put down as gently as the plan has it: some millimetres in height would be 20 ms in
        time, in which a robot that twists turns on.
        """
        above = self.contacts.ground_shift + target.com[2] - self._body.com[2]
        self._stretch[2] = min(max(above, -_STRETCH), _STRETCH)
        rate = np.zeros(3)
        if abs(above) < _STRETCH:
            rate[2] = target.com_velocity[2] - self._body.com_velocity[2]
        return target._replace(
            foot_from_com=target.foot_from_com + self._stretch,
            foot_velocity_from_com=target.foot_velocity_from_com + rate,
        )

    def _foot_target(self, target: Target) -> Array:
        stands = self.contacts.planned[:, None]
        return np.where(stands, self.contacts.foothold, self._body.com + target.foot_from_com)

    def _solve(self, target: Target, mode: Mode, time: float) -> Command:
        weights, body, contacts = self._settings.weights, self._body, self.contacts
        flying, landing, com = contacts.flying, contacts.lands(time), weights.com
        following_forces = mode == Mode.FORCE
        tracking = not flying and not following_forces
        if flying:
            orientation, angular_momentum = weights.orientation_in_flight, 0.0
        elif landing:
            orientation = weights.orientation
            angular_momentum = weights.angular_momentum if tracking else 0.0
        else:
            orientation = weights.orientation_in_takeoff
            angular_momentum = weights.angular_momentum_in_takeoff
            if self._take_off is not None:
                target = self._take_off.corrected(target, body, contacts.plan_time(time))
                com *= _STEERED
        wanted = target.contact_force
        if landing:
            standing = self._weight_carried(contacts.planned)
            wanted = self._landing.force(wanted, standing, self._momentum_share)
        return self._dynamics.solve(
            [
                (self._com, com if tracking else 0.0),
                (self._angular_momentum, angular_momentum),
                (self._orientation, orientation),
                (self._posture, weights.posture),
                *self._arms,
                *self._feet_tasks(contacts.standing, contacts.seeking),
            ],
            target,
            contacts.standing.repeat(self._points),
            wanted,
            weights.force_in_landing if following_forces else weights.force,
            torque_range(self._robot, body.v[6:]),
            self._joints.accelerations(body),
            self._links.rows(body),
            friction_torque(self._robot, body.v[6:]),
            self._unmodelled.acceleration,
        )

    def _weight_carried(self, feet: BoolArray) -> Array:
        """(C, 3) N: the weight, shared by the points of the feet (L,) that stand."""
        key = feet.tobytes()
        if key not in self._carried:
            points = feet.repeat(self._points)
            force = np.zeros((len(points), 3))
            force[points, 2] = self._body.mass * GRAVITY / points.sum()
            self._carried[key] = force
        return self._carried[key]

    def _feet_tasks(
        self, standing: BoolArray, seeking: BoolArray
    ) -> list[tuple[tasks.Task, float]]:
        key = standing.tobytes(), seeking.tobytes()
        if key not in self._feet:
            weights, gains = self._settings.weights, self._settings.gains
            stand, seek, swing = (
                np.flatnonzero(feet).tolist() for feet in (standing, seeking, ~(standing | seeking))
            )
            feet: list[tuple[tasks.Task, float]] = []
            if stand:
                task = tasks.StandingFeet(stand, self._points, gains.standing)
                feet.append((task, weights.contact))
            if seek:
                down = tasks.SeekingFeet(seek, _SEEKING, self._seeking_damping)
                feet.append((down, _SEEKS * weights.swing))
            if swing:
                feet.append((tasks.SwingFeet(swing, gains.swing), weights.swing))
            if self._points > 1:
                feet += [
                    (tasks.FootOrientation(i, gains.swing), weights.swing_orientation)
                    for i in sorted(seek + swing)
                ]
            self._feet[key] = feet
        return self._feet[key]
