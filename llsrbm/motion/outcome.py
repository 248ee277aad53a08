"""`Outcome`: the end of a simulation in figures."""

from __future__ import annotations

import math
from dataclasses import dataclass

SATURATED = 0.99  # share of what a drive can give

# The thresholds of strict success.
FEET_WITHIN = 0.05  # m, horizontally
FINAL_TILT = math.radians(2.0)
PEAK_TILT = math.radians(15.0)
SECOND_FLIGHT = 0.03  # s


@dataclass(frozen=True)
class Outcome:
    """End of a simulation, in figures; angles in rad.

    "Touchdown" is the first contact of a foot after the robot has left the ground; of several
    flights it is the last one's that counts, and there is none where the robot did not get there.

    Attributes:
        status: "landed" or "fell"; reason, fell_at_s: of a fall.
        strict: whether it landed by the strict measure: see `llsrbm.simulation.verdict`.
        final_yaw_error, final_position_error, final_tilt: at the end, against the plan's last knot,
            or where the CoM comes to rest after it: rad, m (CoM, horizontal), rad.
        final_speed: largest speed of the CoM in the last 0.2 s, m/s.
        touchdown_planned_s: the plan's, retimed by the touchdowns before it.
        touchdown_true_s, touchdown_detected_s: the simulator's first contact, and when the
            controller detected it; None: never. foot_touchdown_s: the simulator's, a foot.
        false_touchdowns: detections while no foot touched the ground, of all flights.
        yaw_error_at_touchdown: yaw of the base at the true touchdown minus the plan's at its own;
            of a base far from upright, the vertical part of the turn between the two.
        yaw_error_at_lift_off: of the last flight, against the yaw that is tracked;
            yaw_error_in_flight: how much further than planned the base turned from there until the
            first contact or the planned touchdown, whichever came first. Their sum differs from the
            error at touchdown by the turn in the time between the two touchdowns. `model_turn` in
            `llsrbm.analysis` has what the plan's model makes of both.
        yaw_error_at_planned_touchdown: at that instant, standing or not, minus the plan's then.
        foot_error_at_touchdown: largest horizontal distance of a foot, at its first contact, from
            where the plan lands it, m; foot_error: at the end.
        peak_tilt: largest after touchdown; of a body that turned over, from the planned attitude.
        second_flight_s: time without any foot in contact, from the true touchdown on.
        trunk_touched: whether the trunk, or what it carries, touched anything.
        touched: which links but the feet touched what (also each other), and when first: "LH_SHANK
            touched the box at 0.61 s; ..."; "" if none did. No strict success with any.
        peak_torque_ratio, peak_speed_ratio: largest share of the robot file's limits.
        takeoff_joint_speed: largest until lift-off, rad/s or m/s.
        saturated_fraction: share of ticks with a torque at its limit.
        unsolved_ticks: ticks whose QP was not solved; their torques were held for 10 ms, then
            damped the joints (`llsrbm.control.inverse_dynamics`). No strict success with any.
        tick_median_s, tick_p99_s: wall time of a controller tick.
        real_time_factor: simulated time / wall time, controller included.
        control_rate_hz: ticks a simulated second.
        landing_strategy: the one that ran.
        recovered: whether it landed by the strict measure but for the feet's place, which pushes
            and replanning move.
        replans: how often was planned anew; replan_median_s, replan_p95_s: the processor's time.
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
    landing_strategy: str
    recovered: bool
    touched: str = ""
    replans: int = 0
    replan_median_s: float | None = None
    replan_p95_s: float | None = None
    yaw_error_at_lift_off: float | None = None
    yaw_error_in_flight: float | None = None
    yaw_error_at_planned_touchdown: float | None = None

    @property
    def shortfalls(self) -> tuple[str, ...]:
        """Names of the demands that a landing misses, empty of a strict one.

        "feet", "touched", "tilt", "peak_tilt", "second_flight", "unsolved"; "rebound" where a
        flight before the last did not end on all feet that were to stand.
        """
        if self.strict:
            return ()
        found = {
            "feet": self.recovered or self.foot_error >= FEET_WITHIN,
            "touched": self.touched != "",
            "tilt": self.final_tilt >= FINAL_TILT,
            "peak_tilt": self.peak_tilt >= PEAK_TILT,
            "second_flight": self.second_flight_s >= SECOND_FLIGHT,
            "unsolved": self.unsolved_ticks > 0,
        }
        return tuple(name for name, wrong in found.items() if wrong) or ("rebound",)
