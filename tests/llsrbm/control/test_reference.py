from dataclasses import replace

import numpy as np
import pytest

from llsrbm.control.reference import BRAKING, Reference, com_at_rest
from llsrbm.control.swing import UnderWay
from llsrbm.request.schedule import Phase
from tests.llsrbm.schedules import in_a_row, with_schedule
from tests.llsrbm.synthetic import quat_about_z, synthetic_plan

WEIGHT = 30.0 * 9.81


@pytest.fixture(scope="module")
def plan():
    return synthetic_plan(twist=0.8, forward=0.3)


@pytest.fixture(scope="module")
def reference(plan):
    return Reference(plan, WEIGHT)


def test_stands_still_after_the_end(plan, reference):
    target = reference.at(99.0)
    np.testing.assert_allclose(target.com, plan.com[-1])
    assert not target.com_velocity.any()
    assert not target.angular_velocity.any()
    assert not target.angular_momentum_rate.any()
    np.testing.assert_allclose(target.contact_force.sum(axis=0), [0, 0, WEIGHT])


def test_stands_still_before_the_start(plan, reference):
    target, first = reference.at(-0.3), reference.at(0.0)
    np.testing.assert_allclose(target.com, plan.com[0])
    assert first.com_acceleration.any()  # as the plan begins
    for name in ("com_velocity", "com_acceleration", "angular_acceleration", "joint_velocity"):
        assert not getattr(target, name).any()
    assert not target.foot_acceleration_from_com.any()
    np.testing.assert_allclose(target.contact_force.sum(axis=0), [0, 0, WEIGHT])


def test_attitude_turns_at_the_angular_velocity(reference):
    dt = 0.05
    for t in (0.2, 0.6, 1.2):
        targets = [reference.at(t + s) for s in np.arange(0, dt, 5e-4)]
        turned = sum(target.angular_velocity[2] for target in targets) * 5e-4
        heading = [
            np.arctan2(R[1, 0], R[0, 0])
            for R in (targets[0].R_world_base, reference.at(t + dt).R_world_base)
        ]
        assert turned == pytest.approx(heading[1] - heading[0], abs=2e-3)


def test_rotation_steps_at_lift_off_and_touchdown(plan):
    """A base that turns at 1 rad/s on the ground, at 3 in the air, at 0.5 when it has landed."""
    takeoff, touchdown = plan.phase_start[1:3]
    yaw = np.interp(
        plan.time,
        [0.0, takeoff, touchdown, plan.time[-1]],
        np.cumsum([0.0, takeoff, 3 * (touchdown - takeoff), 0.5 * (plan.time[-1] - touchdown)]),
    )
    reference = Reference(replace(plan, base_quat=quat_about_z(yaw)), WEIGHT)
    tick = 2.5e-3
    for time, rate in (
        (takeoff - tick, 1.0),
        (takeoff + tick, 3.0),
        (touchdown - tick, 3.0),
        (touchdown + tick, 0.5),
    ):
        target = reference.at(time)
        np.testing.assert_allclose(target.angular_velocity, [0, 0, rate], atol=1e-6)
        np.testing.assert_allclose(target.angular_acceleration, 0.0, atol=1e-6)
    # It starts and ends at rest.
    np.testing.assert_allclose(reference.at(0.0).angular_velocity, 0.0, atol=1e-6)
    assert reference.at(0.005).angular_acceleration[2] > 10.0
    assert reference.at(plan.time[-1] - 0.005).angular_acceleration[2] < -10.0


def test_feet_leave_and_meet_the_ground_at_rest(plan, reference):
    for t in (plan.lift_off + 5e-4, plan.touchdown - 5e-4):
        target = reference.at(t)
        foot_velocity = target.foot_velocity_from_com + target.com_velocity
        assert np.abs(foot_velocity).max() < 0.25  # 0.75 ms of a swing that starts hard
    middle = reference.at((plan.lift_off + plan.touchdown) / 2)
    assert np.abs(middle.foot_velocity_from_com + middle.com_velocity).max() > 0.5


def test_swing_is_smooth(reference):
    """Velocity and acceleration are derivatives of the position."""
    dt = 5e-4
    for t in (0.6, 0.7, 0.8):
        before, now, after = (reference.at(t + s) for s in (-dt, 0.0, dt))
        np.testing.assert_allclose(
            (after.foot_from_com - before.foot_from_com) / (2 * dt),
            now.foot_velocity_from_com,
            atol=1e-3,
        )
        np.testing.assert_allclose(
            (after.foot_velocity_from_com - before.foot_velocity_from_com) / (2 * dt),
            now.foot_acceleration_from_com,
            atol=0.5,
        )


ALL = ("LF", "RF", "LH", "RH")


def rear_last(plan):
    return with_schedule(
        plan,
        [
            (Phase("take-off", ALL, "takeoff"), 12),
            (Phase("rear push", ALL[2:], "takeoff"), 4),  # from 0.375 s on
            (Phase("flight", (), "flight"), 16),
            (Phase("landing", ALL, "landing", 1), 16),
        ],
    )


@pytest.mark.parametrize(
    ("time", "moving"), [(0.37, 0), (0.45, 2), (0.49, 2), (0.55, 4), (0.95, 0)]
)
def test_every_foot_swings_from_its_own_lift_off(plan, time, moving):
    """The front feet leave at 0.375 s, the hind feet at 0.5 s, and all land at 0.9 s."""
    target = Reference(rear_last(plan), WEIGHT).at(time)
    moves = target.foot_velocity_from_com.any(axis=1)
    assert moves.tolist() == [foot < moving for foot in range(4)]


def test_feet_of_hops_swing_in_each_flight(plan):
    """In the rebound between them feet are held where the nearest swing has them."""
    joined = in_a_row(plan, plan)
    reference = Reference(joined, WEIGHT)
    for time, knot in ((0.5, 16), (0.9, 32), (1.0, 32), (1.9, 64), (2.0, 64), (2.4, 80)):
        target = reference.at(time)
        planned = joined.foot_position[knot] - joined.com[knot]
        np.testing.assert_allclose(target.foot_from_com, planned, atol=2e-3)
    assert not reference.at(1.5).foot_velocity_from_com.any()
    for flight, end in ((1, 0.9), (3, 2.4)):
        late = reference.late(flight)
        assert not late.foot_velocity_from_com.any()
        np.testing.assert_allclose(late.foot_from_com, reference.at(end).foot_from_com, atol=5e-3)


def test_a_speed_at_the_end_is_braked_evenly(plan):
    speed = np.array([0.4, 0.0, 0.0])
    ending = plan.com_velocity.copy()
    ending[-1] = speed
    plan = replace(plan, jump=replace(plan.jump, end_speed=0.4), com_velocity=ending)
    reference, end = Reference(plan, WEIGHT), plan.duration
    for since in (0.05, 0.15, 0.25):
        target = reference.at(end + since)
        share = 1 - since / BRAKING
        np.testing.assert_allclose(target.com_velocity, share * speed, atol=2e-3)
        np.testing.assert_allclose(target.com_acceleration, -speed / BRAKING)
        way = 0.4 * (since - since**2 / 2 / BRAKING)
        np.testing.assert_allclose(target.com - plan.com[-1], [way, 0, 0], atol=2e-4)
        np.testing.assert_allclose(
            target.contact_force.sum(axis=0), [-WEIGHT / 9.81 * 0.4 / BRAKING, 0, WEIGHT]
        )
    rest = reference.at(99.0)
    np.testing.assert_allclose(rest.com, com_at_rest(plan), atol=1e-9)
    np.testing.assert_allclose(rest.com - plan.com[-1], [0.2 * BRAKING, 0, 0], atol=1e-9)
    assert not rest.com_velocity.any()
    assert not rest.com_acceleration.any()


def test_no_line_is_drawn_from_another_plan(plan):
    """Of a plan made under way: what is before its first knot was measured otherwise."""
    k = int(np.argmax(plan.phase == 1)) + 3
    before = np.arange(len(plan.time)) < k
    jump = 0.05 * before[:, None]
    spliced = replace(
        plan,
        com_velocity=plan.com_velocity + jump,
        angular_momentum=plan.angular_momentum + jump,
        foot_position=plan.foot_position + jump[:, None],
        base_quat=np.where(before[:, None], plan.base_quat[:1], plan.base_quat),
    )
    legs = plan.foot_position.shape[1]
    velocity = np.tile([0.3, -0.2, 0.1], (legs, 1))
    target = Reference(spliced, WEIGHT, UnderWay(plan.time[k], velocity, np.zeros(legs))).at(
        plan.time[k] + 1e-9
    )
    dt = plan.time[k + 1] - plan.time[k]
    ahead = np.diff(plan.com_velocity[k : k + 2], axis=0)[0] / dt
    np.testing.assert_allclose(target.com_acceleration, ahead, atol=1e-6)
    np.testing.assert_allclose(target.foot_velocity_from_com, velocity, atol=0.05)
    np.testing.assert_allclose(target.foot_from_com, plan.foot_position[k] - plan.com[k], atol=5e-4)
    np.testing.assert_allclose(target.angular_velocity, plan.angular_velocity[k], atol=0.05)
