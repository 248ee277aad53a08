"""The whole-body controller: phases of a jump, what is wanted in each, torques."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from llsrbm.control import landing, tasks
from llsrbm.control.detection import CentroidalState, make_detector, model_uncertainty
from llsrbm.control.foot_force import FootForces
from llsrbm.control.inverse_dynamics import Command, InverseDynamics
from llsrbm.control.reference import Reference, Target
from llsrbm.control.whole_body import WholeBody
from llsrbm.motion.plan import Phase, Plan
from llsrbm.motion.rollout import Mode
from llsrbm.robots import Robot
from llsrbm.robots.drives import torque_range
from llsrbm.scenario import Scenario

Array = NDArray[np.float64]

_GRAVITY = 9.81
_JUST_AFTER = (
    1e-3  # s after touchdown, where the nearest sample of a plan surely is one on the ground
)
# A foot that seeks the ground from rest sinks at 0.2 m/s after this time, s; one that then is
# slower than this, m/s, for so many ticks has met it.
_SEEKING_TIME = 0.015
_STOPPED_BELOW = 0.05
_STILL_TICKS = 3


@dataclass(frozen=True, eq=False)
class Tick:
    """What the controller did in one tick.

    Attributes:
        command: torques, accelerations and forces.
        phase, mode: as the controller believes.
        target: what was tracked.
        foot_target: (L, 3) m: where the feet's lowest points should be, world frame.
        average_spatial_velocity_norm: ‖v_G‖.
        detection_signal: the detector's.
    """

    command: Command
    phase: Phase
    mode: Mode
    target: Target
    foot_target: Array
    average_spatial_velocity_norm: float
    detection_signal: float


class WholeBodyController:
    """Follows one plan, tick by tick, from standing to standing.

    Attributes:
        detected_at: when touchdown was detected, s; None before.
        detector: the contact detector.
        landing: name of the landing strategy.
    """

    def __init__(self, robot: Robot, plan: Plan, scenario: Scenario) -> None:
        """Take a plan.

        Args:
            robot: as the controller believes it is.
            plan: what to follow.
            scenario: names of detector, landing strategy and QP solver.

        Raises:
            InputError: one of those names is unknown, or the strategy not for this robot.
        """
        settings = robot.file.control
        self._settings = settings
        self._tick = 1.0 / settings.rate
        self._robot = robot
        self.landing = landing.resolved(scenario.landing, settings.force_phase)
        self._landing = landing.landing_strategy(self.landing)
        self._body = body = WholeBody(robot)
        self._dynamics = InverseDynamics(body, settings.friction, scenario.solver, self._tick)
        self._reference = Reference(plan, robot.mass * _GRAVITY)
        self.detector = make_detector(scenario.detector, self._tick, model_uncertainty(robot.file))
        self._foot_forces = FootForces(body, robot.leg_joint_index, self._tick)
        gains, legs = settings.gains, range(body.legs)
        self._com = tasks.CentreOfMass(gains.com)
        self._angular_momentum = tasks.AngularMomentum(gains.angular_momentum)
        self._orientation = tasks.BaseOrientation(gains.orientation)
        self._posture = tasks.Posture(body.velocities - 6, gains.posture)
        self._swing = [tasks.SwingFoot(i, gains.swing) for i in legs]
        self._seeking = [tasks.SeekingFoot(i, gains.swing[1]) for i in legs]
        points = body.contacts // body.legs
        self._standing = [tasks.StandingFoot(i, points, gains.standing) for i in legs]
        self._level = [tasks.FootOrientation(i, gains.swing) for i in legs] if points > 1 else []
        self._points = points

        self._touching = np.ones(body.legs, dtype=bool)
        self._still = np.zeros(body.legs, dtype=np.int64)
        self._landing_foot = plan.foot_position[-1]
        self._takeoff_foot = plan.foot_position[0]
        self._ground_shift = 0.0
        self._momentum_share = 1.0
        self.detected_at: float | None = None

    def tick(self, time: float, q: Array, v: Array, torque: Array) -> Tick:
        """Decide the torques of the tick that begins at `time`, s.

        Args:
            time: since the plan's start.
            q: (nq,) and v: (nv,) measured, Pinocchio's conventions.
            torque: (J,) measured, mean of the tick that ended.
        """
        body = self._body
        body.update(q, v)
        state = CentroidalState(
            body.mass,
            body.com_velocity,
            body.angular_momentum,
            body.inertia,
            body.trunk_momentum,
        )
        # Half a tick, so that rounding of times cannot shift a phase by a whole one.
        flying = self.detected_at is None and time >= self._reference.takeoff - self._tick / 2
        if flying:
            if self._touching.any():
                self.detector.reset()
                self._foot_forces.reset()
                self._touching[:] = False
            loaded = self._foot_forces.update(torque)
            if self.detector.update(state):
                self._touch_down(time, loaded)
                flying = False
        elif self.detected_at is not None:
            self._touching |= self._foot_forces.update(torque) | self._stopped(time)
            self._ground_shift = self._height_of_ground()
        target = self._target(time, flying=flying)
        mode = self._mode(time)
        phase = self._phase(flying=flying)
        command = self._solve(target, phase, mode)
        return Tick(
            command,
            phase,
            mode,
            target,
            self._foot_target(phase, target),
            state.average_spatial_velocity_norm,
            self.detector.signal if phase == Phase.FLIGHT or time == self.detected_at else 0.0,
        )

    def _phase(self, *, flying: bool) -> Phase:
        if flying:
            return Phase.FLIGHT
        return Phase.TAKEOFF if self.detected_at is None else Phase.LANDING

    def _mode(self, time: float) -> Mode:
        if self.detected_at is None or not self._landing.follows_forces:
            return Mode.TRACKING
        early = time - self.detected_at < self._settings.force_phase - self._tick / 2
        return Mode.FORCE if early else Mode.TRACKING

    def _touch_down(self, time: float, loaded: NDArray[np.bool_]) -> None:
        self.detected_at = time
        planned = self._reference.late.com_velocity[2]
        self._momentum_share = float(self._body.com_velocity[2] / min(planned, -0.1))
        # Something has been hit; where no leg is sure yet, it is the one that feels most.
        self._still = np.zeros(self._body.legs, dtype=np.int64)
        self._touching = loaded.copy()
        self._touching[int(np.argmax(self._foot_forces.vertical))] = True
        self._ground_shift = self._height_of_ground()

    def _stopped(self, time: float) -> NDArray[np.bool_]:
        """(L,) feet that should sink and do not: they stand, however little they carry.

        A foot that is put down gently shows no force that can be told from noise.
        """
        sinking = self._body.foot_velocity[:, 2] < -_STOPPED_BELOW
        self._still = np.where(sinking, 0, self._still + 1)
        since = time - (self.detected_at or 0.0)
        stopped: NDArray[np.bool_] = (self._still >= _STILL_TICKS) & (since > _SEEKING_TIME)
        return stopped

    def _height_of_ground(self) -> float:
        """Of the ground under the feet that stand, above the plan's, m."""
        height = self._body.foot[:, 2] - self._landing_foot[:, 2]
        return float(height[self._touching].mean())

    def _target(self, time: float, *, flying: bool) -> Target:
        """The plan, from detection on retimed to it and raised by the height of the ground."""
        reference = self._reference
        if self.detected_at is None:
            late = flying and time > reference.touchdown - _JUST_AFTER
            return reference.late if late else reference.at(time)
        target = reference.at(reference.touchdown + _JUST_AFTER + time - self.detected_at)
        return replace(target, com=target.com + np.array([0.0, 0.0, self._ground_shift]))

    def _foot_target(self, phase: Phase, target: Target) -> Array:
        if phase == Phase.TAKEOFF:
            return self._takeoff_foot
        if phase == Phase.LANDING:
            return self._landing_foot
        return self._body.com + target.foot_from_com

    def _solve(self, target: Target, phase: Phase, mode: Mode) -> Command:
        weights, body = self._settings.weights, self._body
        flying = phase == Phase.FLIGHT
        following_forces = mode == Mode.FORCE
        tracking = not flying and not following_forces
        orientation, angular_momentum = {
            Phase.TAKEOFF: (weights.orientation_in_takeoff, weights.angular_momentum_in_takeoff),
            Phase.FLIGHT: (weights.orientation_in_flight, 0.0),
            Phase.LANDING: (weights.orientation, weights.angular_momentum if tracking else 0.0),
        }[phase]
        contact = np.ones(body.legs, dtype=bool) if phase == Phase.TAKEOFF else self._touching
        in_the_air = self._swing if flying else self._seeking
        feet: list[tuple[tasks.Task, float]] = [
            (self._standing[i], weights.contact) if contact[i] else (in_the_air[i], weights.swing)
            for i in range(body.legs)
        ]
        feet += [
            (level, weights.swing_orientation)
            for level, stands in zip(self._level, contact, strict=False)
            if not stands
        ]
        wanted = target.contact_force
        if phase == Phase.LANDING:
            standing = np.array([0.0, 0.0, body.mass * _GRAVITY / body.contacts])
            wanted = self._landing.force(wanted, standing, self._momentum_share)
        return self._dynamics.solve(
            chain(
                (
                    (self._com, weights.com if tracking else 0.0),
                    (self._angular_momentum, angular_momentum),
                    (self._orientation, orientation),
                    (self._posture, weights.posture),
                ),
                feet,
            ),
            target,
            np.repeat(contact, self._points),
            wanted,
            weights.force_in_landing if following_forces else weights.force,
            torque_range(self._robot, body.v[6:]),
        )
