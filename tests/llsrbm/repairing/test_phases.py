"""Contact phases against motions of feet in closed form, and against a simulator's contacts."""

from dataclasses import replace

import numpy as np
import pytest

import llsrbm
from llsrbm.motion.flights import flights
from llsrbm.motion.whole_body import whole_body_motion
from llsrbm.repairing.phases import contact_phases
from llsrbm.repairing.stances import noise
from tests.llsrbm.player.stages import stored_plan
from tests.llsrbm.repairing.foreign import GO2, of_states, stepping

LEGS = GO2.leg_names
EDGE = 0.02  # s


@pytest.mark.parametrize("fps", [30.0, 50.0, 120.0])
@pytest.mark.parametrize("ground", [0.0, -0.03, 0.4])
def test_a_jump_has_three_phases_whose_edges_are_met(fps, ground):
    phases = contact_phases(stepping([0.61] * 4, [0.97] * 4, fps=fps, ground=ground))
    assert [phase.feet for phase in phases] == [LEGS, (), LEGS]
    assert [phase.name for phase in phases] == ["all feet stand", "flight", "all feet stand"]
    np.testing.assert_allclose([phases[1].start_s, phases[1].end_s], [0.61, 0.97], atol=EDGE)
    assert (phases[0].start_s, phases[-1].end_s) == (0.0, pytest.approx(2.0, abs=0.05))


def test_what_lands_higher_has_landed():
    phases = contact_phases(stepping([0.6] * 4, [1.0] * 4, rise=0.2))
    assert [phase.feet for phase in phases] == [LEGS, (), LEGS]
    assert phases[1].end_s == pytest.approx(1.0, abs=EDGE)


def test_frames_that_are_off_tell_the_same_phases():
    motion = stepping([0.6] * 4, [1.0] * 4, noise=0.003)
    phases = contact_phases(motion)
    assert [phase.feet for phase in phases] == [LEGS, (), LEGS]
    np.testing.assert_allclose([phases[1].start_s, phases[1].end_s], [0.6, 1.0], atol=2 * EDGE)


def test_feet_that_leave_one_pair_after_the_other_have_phases_of_their_own():
    front = [leg in ("FL", "FR") for leg in LEGS]
    lift = np.where(front, 0.6, 0.8)
    phases = contact_phases(stepping(lift, [1.2] * 4))
    hind = tuple(leg for leg, is_front in zip(LEGS, front, strict=True) if not is_front)
    assert [phase.feet for phase in phases] == [LEGS, hind, (), LEGS]
    assert phases[1].name == f"{', '.join(hind)} stand"
    np.testing.assert_allclose([p.start_s for p in phases[1:]], [0.6, 0.8, 1.2], atol=EDGE)


def test_feet_that_leave_within_a_few_hundredths_of_a_second_leave_together():
    phases = contact_phases(stepping([0.60, 0.61, 0.62, 0.63], [1.03, 1.02, 1.01, 1.0]))
    assert [phase.feet for phase in phases] == [LEGS, (), LEGS]
    np.testing.assert_allclose([phases[1].start_s, phases[1].end_s], [0.63, 1.0], atol=EDGE)


def test_standing_still_is_one_phase():
    (phase,) = contact_phases(stepping([5.0] * 4, [6.0] * 4))
    assert phase.feet == LEGS


def sliding(lift, land, by=0.15, **how):
    """The same with feet that slide all the while, each in a direction of its own, m/s."""
    motion = stepping(lift, land, **how)
    ways = by * np.array([[1.0, 0.5, 0.0], [1.0, -0.5, 0.0], [0.8, 0.0, 0.0], [1.2, 0.3, 0.0]])
    return replace(motion, foot_position=motion.foot_position + motion.time[:, None, None] * ways)


@pytest.mark.parametrize("fps", [30.0, 50.0, 120.0])
@pytest.mark.parametrize("rise", [0.0, 0.2])
def test_of_feet_that_slide_the_com_tells_the_flight(fps, rise):
    phases = contact_phases(sliding([0.61] * 4, [0.97] * 4, fps=fps, rise=rise))
    assert [phase.feet for phase in phases] == [LEGS, (), LEGS]
    np.testing.assert_allclose([phases[1].start_s, phases[1].end_s], [0.61, 0.97], atol=EDGE)


def test_feet_that_slide_without_a_fall_stand():
    motion = sliding([5.0] * 4, [6.0] * 4)
    (phase,) = contact_phases(motion)
    assert phase.feet == LEGS
    # One of them is lifted meanwhile.
    feet = motion.foot_position.copy()
    lifted = (motion.time > 0.5) & (motion.time < 1.2)
    feet[lifted, 0, 2] += 0.1
    found = contact_phases(replace(motion, foot_position=feet))
    assert [phase.feet for phase in found] == [LEGS, LEGS[1:], LEGS]
    np.testing.assert_allclose([phase.start_s for phase in found[1:]], [0.5, 1.2], atol=0.05)


@pytest.mark.parametrize("slower", [0.8, 1.3, 1.9])
def test_feet_that_rise_at_once_fly_however_slowly(slower):
    motion = stepping([0.61] * 4, [0.97] * 4)
    phases = contact_phases(replace(motion, time=slower * motion.time))
    assert [phase.feet for phase in phases] == [LEGS, (), LEGS]


def test_noise_is_told_from_motion():
    time = np.linspace(0.0, 2.0, 101)
    smooth = 0.1 * np.sin(3 * time)
    assert noise(smooth) < 1e-4
    off = np.random.default_rng(3).normal(scale=0.01, size=len(time))
    assert noise(smooth + off) == pytest.approx(0.01, rel=0.3)


@pytest.mark.parametrize("fps", [30.0, 50.0])
def test_edges_of_a_simulated_flight_are_met(fps):
    rollout = llsrbm.simulate(stored_plan(), seed=4)
    (truth,) = flights(rollout)
    motion = whole_body_motion(rollout, fps)
    # As a file without velocities, in which impacts are smeared.
    phases = contact_phases(of_states(motion.time, motion.qpos))
    assert [phase.feet for phase in phases] == [LEGS, (), LEGS]
    told = np.array([phases[1].start_s, phases[1].end_s]) + rollout.time[0]
    np.testing.assert_allclose(told, [truth.lift_off, truth.touchdown], atol=EDGE)
