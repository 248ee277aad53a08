"""`Rollout`: what the whole robot did in the simulator, one array a quantity, T control ticks."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import IntEnum
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from llsrbm.jump import Jump
from llsrbm.scenario import Scenario

Array = NDArray[np.float64]


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
    """

    trunk_mass_factor: float = 1.0
    friction: float = 0.8
    contact_time: float = 0.006
    torque_delay_ticks: int = 0
    base_velocity_noise: float = 0.0
    joint_velocity_noise: float = 0.0


@dataclass(frozen=True)
class Outcome:
    """How a simulation ended, in figures; angles in rad.

    "Touchdown" is the first contact of a foot after the robot has left the ground.

    Attributes:
        status: "landed" or "fell".
        reason: what gave way; "" when it landed.
        fell_at_s: when; None when it landed.
        strict: whether it landed by the strict measure: see `llsrbm.simulation.verdict`.
        final_yaw_error, final_position_error, final_tilt: at the end, against the plan's last knot:
            rad, m (CoM, horizontal), rad.
        final_speed: largest speed of the CoM in the last 0.2 s, m/s.
        touchdown_planned_s: the plan's.
        touchdown_true_s: the simulator's first contact; None if there was none.
        touchdown_detected_s: None if it was never detected.
        foot_touchdown_s: the simulator's, a foot.
        false_touchdowns: detections while no foot touched the ground.
        yaw_error_at_touchdown: yaw of the base at the true touchdown minus the plan's at its own.
        foot_error_at_touchdown: largest horizontal distance of a foot, at its first contact, from
            where the plan lands it, m.
        foot_error: largest horizontal distance of a foot from the plan's at the end, m.
        peak_tilt: largest after touchdown.
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


@dataclass(frozen=True, eq=False)
class Rollout:
    """A simulated jump at T control ticks: L legs, J joints; world frame, SI units.

    States are those at the beginning of a tick, torques and forces those of the tick that begins:
    momenta change by the recorded forces.

    Attributes:
        jump: the plan's request.
        robot_parameters: the numbers of the robot that was simulated, as plain data.
        scenario, disturbance: what was asked, and what was drawn for it.
        outcome: how it ended.
        time: (T,) s, evenly spaced.
        qpos, qvel: (T, 7 + J), (T, 6 + J) MuJoCo's conventions: position, w x y z, joints; linear
            velocity in the world frame, angular in the base's.
        joint_names: (J,) order of the joints in qpos, qvel and torque.
        torque: (T, J) Nm or N, as applied, mean of the tick.
        torque_limit: (T, J) what the drives could give at that speed, in the torque's direction.
        com: (T, 3) m.
        base_quat, base_position: (T, 4) w, x, y, z, (T, 3) m: of the URDF's root link.
        linear_momentum, angular_momentum: (T, 3) kg m/s, kg m2/s about the CoM.
        inertia: (T, 3, 3) kg m2: the whole body's, about its CoM.
        foot_position: (T, L, 3) m: the lowest point of a foot, of a sole its middle.
        contact: (T, L) whether the foot touches anything, the simulator's truth.
        contact_force: (T, L, 3) N, sum a foot, mean of the tick.
        average_spatial_velocity_norm: (T,) ‖v_G‖ as the controller measures it (m/s and rad/s in
            one norm, as in the paper).
        detection_signal: (T,) the detector's own signal; detection_threshold: its threshold.
        mode: (T,) `Mode`.
        phase: (T,) `llsrbm.motion.plan.Phase` as the controller believes.
        reference_com, reference_base_quat, reference_foot_position, reference_angular_momentum:
            (T, 3), (T, 4), (T, L, 3), (T, 3): what was tracked.
        control_parameters: the controller's numbers that ran, as plain data: the robot file's
            [control] and [uncertainty] with their defaults; empty in files that were written
            before rollouts had it.
    """

    jump: Jump
    robot_parameters: dict[str, Any]
    scenario: Scenario
    disturbance: Disturbance
    outcome: Outcome
    time: Array
    qpos: Array
    qvel: Array
    joint_names: tuple[str, ...]
    torque: Array
    torque_limit: Array
    com: Array
    base_quat: Array
    base_position: Array
    linear_momentum: Array
    angular_momentum: Array
    inertia: Array
    foot_position: Array
    contact: NDArray[np.int64]
    contact_force: Array
    average_spatial_velocity_norm: Array
    detection_signal: Array
    detection_threshold: float
    mode: NDArray[np.int64]
    phase: NDArray[np.int64]
    reference_com: Array
    reference_base_quat: Array
    reference_foot_position: Array
    reference_angular_momentum: Array
    control_parameters: dict[str, Any] = field(default_factory=dict)

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
        from llsrbm.motion.rollout_file import save_rollout

        save_rollout(self, path)
