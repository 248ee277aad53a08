"""Schedules beyond take-off, flight and landing, simulated whole."""

import numpy as np
import pytest

from llsrbm.analysis.diagnosis import diagnose
from llsrbm.motion.plan import Plan
from llsrbm.request.scenario import Scenario
from llsrbm.request.schedule import Phase
from llsrbm.robots import load_robot
from llsrbm.simulation.simulate import simulate
from llsrbm.simulation.world import World
from tests.llsrbm.planning.solved import solved
from tests.llsrbm.schedules import in_a_row, with_schedule

ROBOT = load_robot("anymal")
ALL = tuple(leg.name for leg in ROBOT.legs)
FRONT = ALL[:2]


def forward() -> Plan:
    return solved("llsrbm-plus", "forward").plan


def hops() -> Plan:
    """Twice 30 cm; the rebound is a landing and a take-off, with a moment of rest between."""
    return in_a_row(forward(), forward())


@pytest.fixture(scope="module")
def hopped():
    return simulate(hops(), ROBOT, Scenario(seed=3))


def test_two_jumps_in_a_row_land_strictly(hopped):
    assert hopped.outcome.strict, hopped.outcome
    assert diagnose(hopped) == ()
    np.testing.assert_allclose(hopped.com[-1, 0] - hopped.com[0, 0], 0.6, atol=0.05)


def test_the_second_flight_is_as_much_later_as_the_first_touchdown(hopped):
    plan = hopped.plan
    begun = [hopped.time[hopped.phase == phase][0] for phase in range(5)]
    late = begun[2] - plan.phase_start[2]
    # What stands is told to rise as early as drives are late; in flight nothing is foreseen.
    ahead = ROBOT.drive_delay
    again = begun[3] - plan.phase_start[3]
    assert again == pytest.approx(late - ahead, abs=2 * hopped.time[1])
    outcome = hopped.outcome
    assert outcome.touchdown_planned_s - plan.phase_start[4] == pytest.approx(late, abs=2e-3)
    assert outcome.touchdown_detected_s == pytest.approx(begun[4])
    # Feet that are put down gently as planned are felt late.
    assert 0 <= outcome.touchdown_detected_s - outcome.touchdown_true_s < 0.025
    assert min(outcome.foot_touchdown_s) == outcome.touchdown_true_s
    assert outcome.false_touchdowns == 0


def test_a_hop_that_falls_before_its_last_flight_has_no_last_touchdown(monkeypatch):
    advance = World.advance

    def pushed(world, torque):
        if world.time > 0.9:
            torque = 0.0 * torque
        return advance(world, torque)

    monkeypatch.setattr(World, "advance", pushed)
    rollout = simulate(hops(), ROBOT, Scenario())
    outcome = rollout.outcome
    assert not rollout.landed
    assert outcome.touchdown_true_s is None
    assert outcome.touchdown_detected_s is None
    assert not outcome.strict
    diagnose(rollout)


def test_front_feet_that_land_first():
    """The hind feet are due 90 ms later, but were planned on the ground: they stand when felt."""
    plan = forward()
    counts = np.bincount(plan.phase[:-1])
    early = with_schedule(
        plan,
        [
            (Phase("take-off", ALL, "takeoff"), int(counts[0])),
            (Phase("flight", (), "flight"), int(counts[1])),
            (Phase("front landing", FRONT, "landing", 1), 3),
            (Phase("landing", ALL, "landing", 1), int(counts[2]) - 3),
        ],
    )
    outcome = simulate(early, ROBOT, Scenario(seed=1)).outcome
    assert outcome.strict, outcome
