"""Tables of a robot file for its controller, what plans leave it, and how far robots may be off."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from llsrbm.request.tables import Length, Positive, Table


class Gains(Table):
    """Feedback of the whole-body controller's tasks: (stiffness 1/s2, damping 1/s).

    Attributes:
        com, orientation, swing, posture, arms: of the CoM, of the base's attitude, of feet in the
            air, of the joints where no other task wants them, of the arms' joints.
        angular_momentum: decay of its error, 1/s.
        standing: damping of feet on the ground, 1/s: brings feet back that bounce.
    """

    com: tuple[Length, Length] = (300.0, 35.0)
    orientation: tuple[Length, Length] = (150.0, 20.0)
    swing: tuple[Length, Length] = (500.0, 40.0)
    posture: tuple[Length, Length] = (100.0, 20.0)
    arms: tuple[Length, Length] = (600.0, 49.0)
    angular_momentum: Length = 40.0
    standing: Length = 20.0


class Weights(Table):
    """Weights of the whole-body controller's tasks: 1 over (the task's unit squared).

    Attributes:
        com, orientation, angular_momentum, swing, contact, posture, arms: of squared accelerations
            (of the angular momentum, its rate).
        swing_orientation: of soles in the air.
        orientation_in_takeoff, angular_momentum_in_takeoff: there the momenta decide where a flight
            leads; a light base between heavy legs must give way to them.
        orientation_in_flight: momentum is conserved there, so the feet come first.
        force: of squared contact force errors while a trajectory is tracked, 1/N2: only chooses
            among forces that do the same.
        force_in_landing: in the force phase, where CoM and angular momentum cost nothing.
    """

    com: Length = 100.0
    orientation: Length = 10.0
    orientation_in_takeoff: Length = 0.1
    orientation_in_flight: Length = 10.0
    angular_momentum: Length = 1.0
    angular_momentum_in_takeoff: Length = 300.0
    swing: Length = 100.0
    swing_orientation: Length = 10.0
    contact: Length = 1e4
    posture: Length = 1e-4
    arms: Length = 1.0
    force: Length = 1e-4
    force_in_landing: Length = 1e-2


class Control(Table):
    """Parameters of the whole-body controller on this robot.

    Attributes:
        rate: of the controller, Hz.
        friction: coefficient that the controller believes in: not above the ground's.
        force_phase: how long forces are followed after touchdown, s.
        replan_latency: s from a measurement until a plan made from it is followed, by what 95 % of
            them take to compute; if left out 20 ms with four legs or more, 30 ms with fewer.
        gains, weights: see there.
    """

    rate: Positive = 400.0
    friction: Positive = 0.5
    force_phase: Length = 0.1
    replan_latency: Positive | None = None
    gains: Gains = Gains()
    weights: Weights = Weights()


class Reserve(Table):
    """Reserves of the whole body's plans for the controller, besides shares of the drives' limits.

    Attributes:
        landing_torque: share of the torque that plans may use, after the last flight.
        carried: what each contact carries at least, besides what its friction takes, before the
            last flight: a share of the weight that all contacts share evenly. landing_carried:
            the same after it.
    """

    landing_torque: Annotated[float, Field(gt=0, le=1)] = 0.7
    carried: Annotated[float, Field(ge=0, lt=1)] = 0.0
    landing_carried: Annotated[float, Field(ge=0, lt=1)] = 0.0


class Uncertainty(Table):
    """Deviation of the robot from its URDF that surprises nobody.

    Attributes:
        trunk_mass: share of the trunk's mass, either way: payload, cables, a battery. The contact
            detector takes it for two standard deviations (`llsrbm.control.detection`).
    """

    trunk_mass: Annotated[float, Field(ge=0, lt=1)] = 0.10
