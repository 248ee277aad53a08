"""The verdict: each term of strict success by itself, just within its limit and just beyond."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from llsrbm.control.contact_schedule import Flight
from llsrbm.mechanics import turned
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot
from llsrbm.simulation.contacts import Touch
from llsrbm.simulation.episode import Fall, fallen
from llsrbm.simulation.verdict import judge
from llsrbm.simulation.world import TickResult
from tests.app.synthetic_plan import synthetic_plan
from tests.llsrbm.schedules import in_a_row

PLAN = synthetic_plan(Jump(twist=1.2))
NOTHING = TickResult.unknown(4, 12)  # touched


def quat(*turns: Rotation) -> np.ndarray:
    """Of rotations one after the other, the last first, w first."""
    whole = Rotation.identity()
    for turn in turns:
        whole = whole * turn
    return whole.as_quat(scalar_first=True)


def about(axis: str, degrees: float) -> Rotation:
    return Rotation.from_euler(axis, degrees, degrees=True)


@pytest.mark.parametrize("pitch", [-360.0, 0.0, 20.0, 360.0])
def test_yaw_error_is_the_headings_difference_near_upright(pitch):
    actual = quat(about("z", 80.0), about("y", pitch))[None]
    assert np.degrees(turned(actual, quat(about("z", 69.0))[None])) == pytest.approx(11.0)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_yaw_error_of_an_upside_down_base_is_the_turn_from_its_plan(sign):
    """A heading jumps by 180 deg where the nose passes the vertical; this does not."""
    planned = quat(about("y", 170.0))[None]
    actual = sign * quat(about("z", 12.0), about("y", 170.0))[None]
    assert np.degrees(turned(actual, planned)) == pytest.approx(12.0)


@pytest.mark.parametrize(
    ("pitch", "planned", "falls"),
    [(59.0, 0.0, False), (61.0, 0.0, True), (180.0, 180.0, False), (0.0, 120.0, True)],
)
def test_a_robot_topples_away_from_where_it_should_be(pitch, planned, falls):
    q = np.zeros(19)
    q[3:7] = about("y", pitch).as_quat()
    fall = fallen(1.0, q, about("y", planned).as_matrix(), NOTHING)
    assert (fall is not None) == falls


def test_what_touches_a_hurdle_has_not_jumped_over_it():
    q = np.zeros(19)
    q[6] = 1.0
    fall = fallen(1.0, q, np.eye(3), replace(NOTHING, obstacle_contact=True))
    assert fall is not None
    assert fall.reason == "it touched the hurdle"


TICK = 1 / 400
ROBOT = load_robot("anymal")


class Landing:
    """A rollout made by hand: it flies as planned, lands, and stands as the plan ends.

    Attributes:
        columns: as the recorder's.
        after: (T,) ticks since touchdown.
    """

    def __init__(self, plan=PLAN):
        self.plan = plan
        time = np.arange(0.0, plan.duration + 1.0, TICK)
        count = len(time)
        knot = np.searchsorted(plan.time, time + 1e-9, side="right") - 1
        flights = [plan.phase_start[[p, p + 1]] for p in plan.schedule.flights]
        aloft = np.any([(time >= a) & (time < b) for a, b in flights], axis=0)
        self.after = time >= plan.touchdown
        self.flights = [
            Flight(p, start, end, detected=end + 0.005)
            for p, (start, end) in zip(plan.schedule.flights, flights, strict=True)
        ]
        self.landing = "tracking"
        self.columns = {
            "time": time,
            "phase": plan.phase[knot],
            "base_quat": plan.base_quat[knot],
            "reference_base_quat": plan.base_quat[knot],
            "foot_position": plan.foot_position[knot].copy(),
            "com": plan.com[knot].copy(),
            "linear_momentum": np.zeros((count, 3)),
            "contact": np.repeat(~aloft[:, None], 4, axis=1),
            "torque": np.zeros((count, 12)),
            "torque_limit": np.ones((count, 12)),
        }
        self.mass, self.v, self.tick_times = ROBOT.mass, np.zeros((count, 18)), np.ones(count)
        self.touches, self.solved = [()] * count, np.ones(count, dtype=bool)

    def __len__(self):
        return len(self.columns["time"])

    @property
    def results(self):
        time, contact = self.columns["time"], self.columns["contact"]
        first = np.where(contact, time[:, None], np.nan)
        return [
            replace(NOTHING, first_contact=row, touches=touches)
            for row, touches in zip(first, self.touches, strict=True)
        ]

    @property
    def ticks(self):
        return [SimpleNamespace(command=SimpleNamespace(solved=bool(s))) for s in self.solved]

    def lean(self, ticks, degrees):
        rotated = about("x", degrees) * Rotation.from_quat(
            self.columns["base_quat"][ticks], scalar_first=True
        )
        self.columns["base_quat"][ticks] = rotated.as_quat(scalar_first=True)

    def outcome(self, fall=None):
        return judge(ROBOT, self.plan, self, self.columns, self, fall, 1.0)


def foot_aside(landing, amount):
    landing.columns["foot_position"][-1, 2, 1] += amount


def leans_at_the_end(landing, amount):
    landing.lean(slice(-1, None), amount)


def leaned_after_touchdown(landing, amount):
    landing.lean([np.flatnonzero(landing.after)[0] + 20], amount)


def thrown_up_again(landing, ticks):
    begin = np.flatnonzero(landing.after)[0] + 40
    landing.columns["contact"][begin : begin + ticks] = False


def touches(landing, ticks, touch):
    begin = np.flatnonzero(landing.after)[0] + 8
    for tick in range(begin, begin + ticks):
        landing.touches[tick] = ((touch, landing.columns["time"][tick]),)


def trunk_touches(landing, ticks):
    touches(landing, ticks, Touch("base", "the ground", trunk=True))


def shin_touches(landing, ticks):
    touches(landing, ticks, Touch("LH_SHANK", "the box", trunk=False))


def legs_touch(landing, ticks):
    touches(landing, ticks, Touch("LH_SHANK", "RH_SHANK", trunk=False))


def unsolved(landing, ticks):
    landing.solved[:ticks] = False


def moves_at_the_end(landing, speed):
    landing.columns["linear_momentum"][-20, 0] = speed * ROBOT.mass


def sits(landing, share):
    feet = landing.columns["foot_position"][-1, :, 2].mean()
    landing.columns["com"][-1, 2] = feet + share * (PLAN.com[-1, 2] - PLAN.foot_position[-1, 0, 2])


@pytest.mark.parametrize(
    ("change", "within", "beyond"),
    [
        (leans_at_the_end, 1.9, 2.1),
        (leaned_after_touchdown, 14.8, 15.2),
        (thrown_up_again, 11, 13),
        (trunk_touches, 0, 1),
        (shin_touches, 0, 1),
        (legs_touch, 0, 1),
        (unsolved, 0, 1),
        (moves_at_the_end, 0.09, 0.11),
        (sits, 0.71, 0.69),
    ],
)
def test_each_term_of_strict_success_decides_alone(change, within, beyond):
    good, bad = Landing(), Landing()
    change(good, within)
    change(bad, beyond)
    assert (good.outcome().strict, good.outcome().recovered) == (True, True)
    assert (bad.outcome().strict, bad.outcome().recovered) == (False, False)


def test_what_touched_is_named_once_with_its_time():
    landing = Landing()
    shin_touches(landing, 3)
    at = landing.columns["time"][np.flatnonzero(landing.after)[0] + 8]
    outcome = landing.outcome()
    assert outcome.touched == f"LH_SHANK touched the box at {at:.2f} s"
    assert (outcome.trunk_touched, outcome.status) == (False, "landed")
    assert Landing().outcome().touched == ""


def test_a_robot_that_is_moved_aside_has_recovered_and_is_not_strict():
    good, bad = Landing(), Landing()
    foot_aside(good, 0.049)
    foot_aside(bad, 0.051)
    assert good.outcome().strict
    assert (bad.outcome().strict, bad.outcome().recovered) == (False, True)


def test_a_fall_or_no_touchdown_is_no_success():
    assert Landing().outcome().status == "landed"
    fell = Landing().outcome(Fall(1.0, "it toppled over"))
    assert (fell.status, fell.strict, fell.recovered) == ("fell", False, False)
    never = Landing()
    never.columns["contact"][never.after] = False
    assert "never touched the ground again" in never.outcome().reason


@pytest.mark.parametrize("missing", [False, True])
def test_a_rebound_is_on_all_feet_that_are_to_stand(missing):
    hops = Landing(in_a_row(synthetic_plan(Jump()), synthetic_plan(Jump())))
    if missing:
        first, second = hops.flights
        between = (hops.columns["time"] > first.lift_off) & (
            hops.columns["time"] < second.lift_off + 1e-6
        )
        hops.columns["contact"][between, 3] = False
    assert hops.outcome().strict == (not missing)


def test_the_speed_at_the_end_is_that_of_the_mass_that_was_simulated():
    heavy = Landing()
    heavy.mass *= 1.5
    moves_at_the_end(heavy, 0.12)
    assert heavy.outcome().final_speed == pytest.approx(0.08)
    assert heavy.outcome().strict


def test_the_yaw_gained_in_flight_is_told_from_that_of_take_off():
    """5 deg ahead at lift-off, then 8 behind the plan's turn: 3 behind as it lands."""
    landing = Landing()
    time, quat = landing.columns["time"], landing.columns["base_quat"]
    start, end = PLAN.lift_off, PLAN.touchdown
    ahead = np.interp(time, [0.0, start, end], [0.0, 5.0, -3.0])
    rotated = Rotation.from_euler("z", ahead[:, None], degrees=True)
    quat[:] = (rotated * Rotation.from_quat(quat, scalar_first=True)).as_quat(scalar_first=True)
    outcome = landing.outcome()
    assert np.degrees(outcome.yaw_error_at_lift_off) == pytest.approx(5.0, abs=0.1)
    assert np.degrees(outcome.yaw_error_in_flight) == pytest.approx(-8.0, abs=0.2)
    assert np.degrees(outcome.yaw_error_at_planned_touchdown) == pytest.approx(-3.0, abs=0.1)
    landing.flights = []
    missed = landing.outcome()
    assert missed.yaw_error_at_lift_off is missed.yaw_error_at_planned_touchdown is None
