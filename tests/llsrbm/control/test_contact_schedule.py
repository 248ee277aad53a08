"""Which feet stand: by the clock when they leave, by what is felt when they land."""

import numpy as np
import pytest

from llsrbm.control.contact_schedule import ContactSchedule
from llsrbm.control.delay import Measurement
from llsrbm.request.schedule import Phase
from tests.llsrbm.schedules import in_a_row, with_schedule
from tests.llsrbm.synthetic import synthetic_plan

TICK = 0.0025
FRONT, HIND = ("LF", "RF"), ("LH", "RH")
ALL = FRONT + HIND
STANDING_ALL, NONE = np.ones(4, dtype=bool), np.zeros(4, dtype=bool)
FRONT_ONLY, HIND_ONLY = np.array([1, 1, 0, 0], bool), np.array([0, 0, 1, 1], bool)
ONE = synthetic_plan(twist=0.0, forward=0.3)  # 0.5 s of take-off, 0.4 s of flight, 0.6 s of landing


class Robot:
    """What a schedule asks of body and legs, put in by hand."""

    legs = 4

    def __init__(self):
        self.foot = np.zeros((4, 3))
        self.foot_velocity = np.zeros((4, 3))
        # As if the heights of the four feet were all that moves.
        self.foot_jacobian = np.zeros((4, 3, 4))
        self.foot_jacobian[:, 2] = np.eye(4)
        self.vertical = np.zeros(4)
        self.loaded = NONE
        self.resets = 0
        self.with_feet = True

    def update(self, torque, v, com_velocity):
        return self.loaded

    def reset(self):
        self.resets += 1

    def met_ground(self):
        return self.with_feet


class Run:
    """A schedule that is stepped tick by tick."""

    def __init__(self, plan):
        self.robot = Robot()
        self.contacts = ContactSchedule(plan, self.robot, self.robot, TICK)
        self.ticks = 0
        self.begun = []

    def step(self, *, hit=False):
        time = self.ticks * TICK
        if self.contacts.follow_clock(time):
            self.begun.append(time)
        v = self.robot.foot_velocity[:, 2]
        self.contacts.find_contacts(
            Measurement(time, np.zeros(19), v, np.zeros(12)), np.zeros(3), hit=hit
        )
        self.ticks += 1
        return self.contacts

    def until(self, time):
        while self.ticks * TICK < time - TICK / 2:
            self.step()
        return self.contacts


def rear_last():
    return with_schedule(
        ONE,
        [
            (Phase("take-off", ALL, "takeoff"), 12),
            (Phase("rear push", HIND, "takeoff"), 4),  # from 0.375 s on
            (Phase("flight", (), "flight"), 16),
            (Phase("front landing", FRONT, "landing", 1), 4),  # from 0.9 s on
            (Phase("landing", ALL, "landing", 1), 12),  # from 1.05 s on
        ],
    )


def test_feet_leave_by_the_clock():
    run = Run(rear_last())
    assert run.until(0.37).standing.all()
    np.testing.assert_array_equal(run.until(0.38).standing, HIND_ONLY)
    assert run.contacts.phase == 1
    assert not run.contacts.flying
    assert not run.contacts.seeking.any()
    contacts = run.until(0.51)
    assert contacts.flying
    assert not contacts.standing.any()
    assert run.begun == [pytest.approx(0.5)]
    assert run.robot.resets == 1


def test_feet_that_leave_early_follow_the_phase_that_begins():
    """Half a tick before the clock's time, whose target would have pushed with other feet."""
    run, early = Run(rear_last()), 0.375 - TICK / 4
    assert run.until(0.37).reference_time(0.3725) == pytest.approx(0.3725)
    run.contacts.follow_clock(early)
    assert run.contacts.phase == 1
    assert run.contacts.plan_time(early) < 0.375 < run.contacts.reference_time(early) < 0.377
    assert run.contacts.reference_time(0.4) == pytest.approx(0.4)


def test_before_the_plan_there_is_no_time_of_it():
    """A player's robot stands for a second there; the plan's first forces would lower it."""
    contacts = ContactSchedule(ONE, Robot(), Robot(), TICK)
    for time in (-1.0, -TICK, 0.0):
        assert contacts.reference_time(time) == time


def test_a_flight_ends_when_something_is_hit_and_not_before():
    run = Run(ONE)
    assert run.until(3.0).flying
    run.robot.vertical = np.array([0.0, 5.0, 60.0, 1.0])
    contacts = run.step(hit=True)
    assert not contacts.flying
    assert contacts.standing.tolist() == [False, False, True, False]  # it feels most
    np.testing.assert_array_equal(contacts.seeking, ~contacts.standing)
    assert contacts.detected == pytest.approx(3.0)
    assert contacts.plan_time(3.0) == pytest.approx(0.9, abs=2e-3)


def test_what_is_not_hit_with_the_feet_is_no_touchdown():
    run = Run(ONE)
    run.until(0.7)
    run.robot.with_feet = False
    assert run.step(hit=True).flying
    run.robot.with_feet = True
    assert not run.step(hit=True).flying


def test_front_feet_land_first_and_hind_feet_when_they_meet_the_ground():
    run = Run(rear_last())
    run.until(0.85)  # 50 ms early
    run.robot.loaded = FRONT_ONLY
    contacts = run.step(hit=True)
    np.testing.assert_array_equal(contacts.standing, FRONT_ONLY)
    assert not contacts.seeking.any()  # the hind feet swing as planned
    run.robot.foot_velocity[:, 2] = 0.0  # not sinking is no landing before their time
    assert not run.until(0.99).standing[2:].any()
    run.robot.foot_velocity[2:, 2] = -0.2
    contacts = run.until(1.03)
    np.testing.assert_array_equal(contacts.seeking, HIND_ONLY)
    assert not contacts.standing[2:].any()
    run.robot.foot_velocity[3, 2] = 0.0
    assert run.until(1.06).standing.tolist() == [True, True, False, True]
    run.robot.loaded = STANDING_ALL
    assert run.until(1.07).standing.all()


def test_a_step_while_others_stand():
    """Load early in the swing is that of a foot that leaves late."""
    plan = with_schedule(
        ONE,
        [
            (Phase("stand", ALL, "takeoff"), 4),
            (Phase("step", HIND, "takeoff"), 8),  # 0.125 to 0.375 s
            (Phase("push", ALL, "takeoff"), 4),
            (Phase("flight", (), "flight"), 16),
            (Phase("landing", ALL, "landing", 1), 16),
        ],
    )
    run = Run(plan)
    run.until(0.13)
    run.robot.loaded = STANDING_ALL
    np.testing.assert_array_equal(run.until(0.24).standing, HIND_ONLY)
    assert run.until(0.26).standing.all()
    assert run.until(0.4).phase == 2
    assert run.until(0.6).flying


def test_hops_are_retimed_by_every_touchdown():
    """Flights of 0.4 s from 0.5 and, after a rebound of 1.1 s, from 2.0 s on."""
    run = Run(in_a_row(ONE, ONE))
    run.until(0.94)
    run.step(hit=True)
    assert run.contacts.lands(1.0)
    assert not run.until(1.6).lands(1.6)  # the second half pushes
    assert run.until(2.03).phase == 2
    assert run.until(2.05).flying
    assert run.begun == [pytest.approx(0.5), pytest.approx(2.04, abs=TICK)]
    first, second = run.contacts.flights
    assert (first.lift_off, first.touchdown) == (pytest.approx(0.5), pytest.approx(0.9))
    assert second.lift_off == pytest.approx(2.039)
    assert second.touchdown == pytest.approx(2.439)
    assert run.contacts.detected is None
    run.until(2.42)
    contacts = run.step(hit=True)
    assert contacts.phase == 4
    assert [flight.detected for flight in contacts.flights] == pytest.approx([0.94, 2.42])
    assert contacts.plan_time(2.42) == pytest.approx(2.4, abs=2e-3)
    assert run.until(5.0).lands(5.0)


def test_the_ground_is_measured_at_each_place():
    plan = in_a_row(ONE, ONE)
    run = Run(plan)
    run.until(0.9)
    run.robot.foot[:, 2] = 0.02
    run.robot.loaded = STANDING_ALL
    assert run.step(hit=True).ground_shift == pytest.approx(0.02)
    run.until(2.3)
    assert run.contacts.flying
    assert run.contacts.ground_shift == pytest.approx(0.02)
    run.robot.foot[:, 2] = -0.01
    contacts = run.step(hit=True)
    assert contacts.ground_shift == pytest.approx(-0.01)
    np.testing.assert_allclose(contacts.foothold, plan.foot_position[-1])


def test_feet_that_stand_without_load_carry_nothing_after_a_while():
    run = Run(ONE)
    assert run.until(0.2).carrying.all()  # nobody asks for their load before they leave
    assert not run.until(0.85).carrying.any()  # in flight
    run.robot.loaded = STANDING_ALL
    assert run.step(hit=True).carrying.all()
    run.robot.loaded = FRONT_ONLY
    assert run.until(run.ticks * TICK + 0.015).carrying.all()
    contacts = run.until(run.ticks * TICK + 0.010)
    assert contacts.carrying.tolist() == FRONT_ONLY.tolist()
    assert contacts.standing.all()
    run.robot.loaded = STANDING_ALL
    assert run.step().carrying.all()
