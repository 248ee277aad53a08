"""`Rollout`: what the whole robot did in the simulator, one array a quantity, T control ticks."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import IntEnum
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from llsrbm.mechanics import rotation_matrices
from llsrbm.motion.plan import Plan, leg_names, sliding_joints
from llsrbm.motion.quantity import (
    JOINT,
    LEG,
    POSITION,
    TENSOR,
    TIME,
    VELOCITY,
    WXYZ,
    XYZ,
    Array,
    Between,
    Kind,
    Quantity,
)
from llsrbm.motion.replan import Replan
from llsrbm.request.jump import Jump
from llsrbm.request.push import Push
from llsrbm.request.scenario import Scenario
from llsrbm.request.schedule import Schedule, together


class Mode(IntEnum):
    """What the controller follows."""

    TRACKING = 0
    FORCE = 1


@dataclass(frozen=True)
class Disturbance:
    """What of the simulated world differs from what the controller believes.

    Attributes:
        trunk_mass_factor: of the simulated trunk, mass and inertia; the controller believes 1.
        friction: coefficient between feet and ground.
        contact_time: MuJoCo's time constant of a contact, s.
        torque_delay_ticks: control ticks by which torques arrive late.
        base_velocity_noise: standard deviation of the measured base velocity, m/s and rad/s.
        joint_velocity_noise: standard deviation of the measured joint velocities, rad/s.
        random_push: the push that was drawn, if one was asked for.
    """

    trunk_mass_factor: float = 1.0
    friction: float = 0.8
    contact_time: float = 0.006
    torque_delay_ticks: int = 0
    base_velocity_noise: float = 0.0
    joint_velocity_noise: float = 0.0
    random_push: Push | None = None


@dataclass(frozen=True)
class Outcome:
    """How a simulation ended, in figures; angles in rad.

    "Touchdown" is the first contact of a foot after the robot has left the ground; of several
    flights it is the last one's that counts, and there is none where the robot did not get there.

    Attributes:
        status: "landed" or "fell".
        reason: what gave way; "" when it landed.
        fell_at_s: when; None when it landed.
        strict: whether it landed by the strict measure: see `llsrbm.simulation.verdict`.
        final_yaw_error, final_position_error, final_tilt: at the end, against the plan's last knot,
            or where the CoM comes to rest after it: rad, m (CoM, horizontal), rad.
        final_speed: largest speed of the CoM in the last 0.2 s, m/s.
        touchdown_planned_s: the plan's, retimed by the touchdowns before it.
        touchdown_true_s: the simulator's first contact; None if there was none.
        touchdown_detected_s: None if it was never detected.
        foot_touchdown_s: the simulator's, a foot.
        false_touchdowns: detections while no foot touched the ground, of all flights.
        yaw_error_at_touchdown: yaw of the base at the true touchdown minus the plan's at its own;
            of a base far from upright, the vertical part of the turn between the two.
        foot_error_at_touchdown: largest horizontal distance of a foot, at its first contact, from
            where the plan lands it, m.
        foot_error: largest horizontal distance of a foot from the plan's at the end, m.
        peak_tilt: largest after touchdown; of a body that turned over, from the planned attitude.
        second_flight_s: time without any foot in contact, from the true touchdown on.
        trunk_touched: whether anything but the feet touched the ground.
        peak_torque_ratio, peak_speed_ratio: largest share of the robot file's limits.
        takeoff_joint_speed: largest until lift-off, rad/s or m/s.
        saturated_fraction: share of ticks with a torque at its limit.
        unsolved_ticks: ticks whose QP was not solved; their torques were held for 10 ms, then
            damped the joints (`llsrbm.control.inverse_dynamics`). No strict success with any.
        tick_median_s, tick_p99_s: wall time of a controller tick.
        real_time_factor: simulated time / wall time, controller included.
        control_rate_hz: ticks a simulated second.
        landing_strategy: the one that ran; "" in files that were written before outcomes had it.
        recovered: whether it landed by the strict measure but for the feet's place, which pushes
            and replanning move; None in files that were written before outcomes had it.
        replans: how often was planned anew, with or without success.
        replan_median_s, replan_p95_s: the processor's time for that; None without any.
    """

    status: str
    reason: str
    fell_at_s: float | None
    strict: bool
    final_yaw_error: float
    final_position_error: float
    final_tilt: float
    final_speed: float
    touchdown_planned_s: float
    touchdown_true_s: float | None
    touchdown_detected_s: float | None
    foot_touchdown_s: tuple[float | None, ...]
    false_touchdowns: int
    yaw_error_at_touchdown: float | None
    foot_error_at_touchdown: float | None
    foot_error: float
    peak_tilt: float
    second_flight_s: float
    trunk_touched: bool
    peak_torque_ratio: float
    peak_speed_ratio: float
    takeoff_joint_speed: float
    saturated_fraction: float
    unsolved_ticks: int
    tick_median_s: float
    tick_p99_s: float
    real_time_factor: float
    control_rate_hz: float
    landing_strategy: str = ""
    recovered: bool | None = None
    replans: int = 0
    replan_median_s: float | None = None
    replan_p95_s: float | None = None


@dataclass(frozen=True, eq=False)
class Rollout:
    """A simulated jump at T control ticks: L legs, J joints.

    States are those at the beginning of a tick, torques and forces those of the tick that begins:
    momenta change by the recorded forces. What each array is stands beside it;
    `llsrbm.motion.quantity` explains the words.

    Attributes:
        jump: the plan's request.
        robot_parameters: the numbers of the robot that was simulated, as plain data.
        scenario, disturbance: what was asked, and what was drawn for it.
        outcome: how it ended.
        control_parameters: the controller's numbers that ran, as plain data: the robot file's
            [control] and [uncertainty] with their defaults; empty in files that were written
            before rollouts had it.
        plan: what was followed; None in files that were written before rollouts had it.
        replans: what was planned anew under way, in the order in which it was asked for.
    """

    jump: Jump
    robot_parameters: dict[str, Any]
    scenario: Scenario
    disturbance: Disturbance
    outcome: Outcome
    time: Annotated[Array, Quantity((TIME,), "s", "evenly spaced", Between.LINEAR)]
    qpos: Annotated[
        Array,
        Quantity(
            (TIME, POSITION),
            "m, rad",
            "MuJoCo's: position, w x y z, joints",
            Between.POSE,
            "world",
            listed=False,
        ),
    ]
    qvel: Annotated[
        Array,
        Quantity(
            (TIME, VELOCITY),
            "m/s, rad/s",
            "MuJoCo's: linear velocity in the world's axes, angular in the base's, joints",
            Between.LINEAR,
            "world, base",
            rate=True,
            listed=False,
        ),
    ]
    joint_names: Annotated[
        tuple[str, ...],
        Quantity(
            (JOINT,),
            "",
            "order of the joints in qpos, qvel and torque",
            kind=Kind.TEXT,
            listed=False,
        ),
    ]
    torque: Annotated[
        Array,
        Quantity(
            (TIME, JOINT),
            "Nm",
            "as applied, mean of the tick",
            Between.HELD,
            column="joint_torque",
        ),
    ]
    torque_limit: Annotated[
        Array,
        Quantity(
            (TIME, JOINT),
            "Nm",
            "what the drives could give at that speed, in the torque's direction",
            Between.HELD,
            column="joint_torque_limit",
        ),
    ]
    com: Annotated[Array, Quantity((TIME, XYZ), "m", "centre of mass", Between.LINEAR, "world")]
    base_quat: Annotated[
        Array,
        Quantity((TIME, WXYZ), "", "attitude of the URDF's root link", Between.TURNING, "world"),
    ]
    base_position: Annotated[
        Array, Quantity((TIME, XYZ), "m", "origin of the URDF's root link", Between.LINEAR, "world")
    ]
    linear_momentum: Annotated[
        Array,
        Quantity((TIME, XYZ), "kg m/s", "linear momentum", Between.LINEAR, "world", rate=True),
    ]
    angular_momentum: Annotated[
        Array,
        Quantity(
            (TIME, XYZ),
            "kg m2/s",
            "angular momentum about the CoM",
            Between.LINEAR,
            "world",
            rate=True,
        ),
    ]
    inertia: Annotated[
        Array,
        Quantity(
            (TIME, TENSOR),
            "kg m2",
            "centroidal inertia of the whole body",
            Between.LINEAR,
            "world",
        ),
    ]
    foot_position: Annotated[
        Array,
        Quantity(
            (TIME, LEG, XYZ),
            "m",
            "lowest point of a foot, of a sole its middle",
            Between.LINEAR,
            "world",
        ),
    ]
    contact: Annotated[
        NDArray[np.int64],
        Quantity(
            (TIME, LEG),
            "",
            "whether the foot touches anything, the simulator's truth",
            Between.HELD,
            kind=Kind.WHOLE,
            codes=("in the air", "touches"),
        ),
    ]
    contact_force: Annotated[
        Array,
        Quantity(
            (TIME, LEG, XYZ),
            "N",
            "sum over a foot, mean of the tick",
            Between.HELD,
            "world",
        ),
    ]
    average_spatial_velocity_norm: Annotated[
        Array,
        Quantity(
            (TIME,),
            "m/s and rad/s",
            "norm of the average spatial velocity v_G as the controller measures it, in one norm "
            "as in the paper",
            Between.LINEAR,
        ),
    ]
    detection_signal: Annotated[
        Array, Quantity((TIME,), "the detector's", "the contact detector's signal", Between.HELD)
    ]
    detection_threshold: Annotated[
        float, Quantity((), "the detector's", "above it, contact is detected", listed=False)
    ]
    mode: Annotated[
        NDArray[np.int64],
        Quantity(
            (TIME,),
            "",
            "what the controller follows",
            Between.HELD,
            kind=Kind.WHOLE,
            codes=("tracking", "force"),
        ),
    ]
    phase: Annotated[
        NDArray[np.int64],
        Quantity(
            (TIME,),
            "",
            "phase of the schedule, as the controller believes",
            Between.HELD,
            kind=Kind.WHOLE,
            coded_by="phase_names",
        ),
    ]
    reference_com: Annotated[
        Array, Quantity((TIME, XYZ), "m", "tracked: centre of mass", Between.LINEAR, "world")
    ]
    reference_base_quat: Annotated[
        Array,
        Quantity((TIME, WXYZ), "", "tracked: attitude of the base", Between.TURNING, "world"),
    ]
    reference_foot_position: Annotated[
        Array, Quantity((TIME, LEG, XYZ), "m", "tracked: feet", Between.LINEAR, "world")
    ]
    reference_angular_momentum: Annotated[
        Array,
        Quantity(
            (TIME, XYZ),
            "kg m2/s",
            "tracked: angular momentum about the CoM",
            Between.LINEAR,
            "world",
            rate=True,
        ),
    ]
    control_parameters: dict[str, Any] = field(default_factory=dict)
    plan: Plan | None = field(default=None, repr=False)
    replans: tuple[Replan, ...] = field(default=(), repr=False)

    @property
    def pushes(self) -> tuple[Push, ...]:
        """Those that were stated, and the one that was drawn."""
        drawn = self.disturbance.random_push
        return (*self.scenario.pushes, *(() if drawn is None else (drawn,)))

    @property
    def base_velocity(
        self,
    ) -> Annotated[
        Array,
        Quantity((TIME, XYZ), "m/s", "velocity of the base's origin", Between.LINEAR, "world"),
    ]:
        """(T, 3) m/s, world frame."""
        return self.qvel[:, :3]

    @property
    def angular_velocity(
        self,
    ) -> Annotated[
        Array,
        Quantity((TIME, XYZ), "rad/s", "angular velocity of the base", Between.LINEAR, "world"),
    ]:
        """(T, 3) rad/s of the base, world frame; `qvel` has it in the base's axes."""
        return np.einsum("kij,kj->ki", rotation_matrices(self.base_quat), self.qvel[:, 3:6])

    @property
    def joint_position(
        self,
    ) -> Annotated[Array, Quantity((TIME, JOINT), "rad", "positions", Between.LINEAR)]:
        """(T, J) rad or m, in the order of `joint_names`."""
        return self.qpos[:, 7:]

    @property
    def joint_velocity(
        self,
    ) -> Annotated[Array, Quantity((TIME, JOINT), "rad/s", "velocities", Between.LINEAR)]:
        """(T, J) rad/s or m/s, in the order of `joint_names`."""
        return self.qvel[:, 6:]

    @property
    def sliding_joints(self) -> frozenset[str]:
        """Names of the joints whose position is in metres."""
        return sliding_joints(self.robot_parameters)

    @property
    def leg_names(self) -> tuple[str, ...]:
        """As in the robot file, when the rollout says which robot it is of."""
        return leg_names(self.robot_parameters, self.foot_position.shape[1])

    @property
    def schedule(self) -> Schedule:
        """The plan's; of a rollout that does not hold its plan, `together`, the only one then."""
        return together(self.leg_names) if self.plan is None else self.plan.schedule

    @property
    def phase_names(self) -> tuple[str, ...]:
        """(P,) what the numbers of `phase` stand for."""
        return self.schedule.names

    @property
    def duration(self) -> float:
        """From the first tick to the last, s."""
        return float(self.time[-1] - self.time[0])

    @property
    def landed(self) -> bool:
        """Whether the robot stands at the end."""
        return self.outcome.status == "landed"

    def save(self, path: str | Path) -> None:
        """Write llsrbm.rollout/1.

        Raises:
            InputError: the file cannot be written.
        """
        from llsrbm.files.rollout_file import save_rollout

        save_rollout(self, path)
