"""Planning anew in the loop: when it is asked, when it is followed, and what it is worth."""

from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

import llsrbm
from llsrbm.errors import InputError
from llsrbm.motion.trajectory import load
from llsrbm.request.scenario import DURATION, Push, Scenario
from llsrbm.robots import load_robot
from llsrbm.simulation import replanning
from llsrbm.simulation.checks import check_scenario
from llsrbm.simulation.replanning import LATENCY, LATENCY_FEW_LEGS, PERIOD, latency_of
from llsrbm.simulation.simulate import simulate
from tests.llsrbm.planning.solved import solved

ROBOT = load_robot("anymal")
TICK = 1 / ROBOT.file.control.rate
ASIDE = (0.0, 20.0, 0.0)  # N s: of what few landings recover without planning anew


class Clock:
    """In place of the processor's: every computation takes as long as is said."""

    def __init__(self, seconds):
        self.seconds, self.now = seconds, 0.0

    def thread_time(self):
        self.now += self.seconds
        return self.now


@pytest.fixture
def takes(monkeypatch):
    """Set how long a computation takes, s, whatever the machine does."""
    return lambda seconds: monkeypatch.setattr(replanning, "time", Clock(seconds))


def plan():
    return solved("llsrbm-plus", "twist").plan


def middle():
    return (plan().lift_off + plan().touchdown) / 2


def pushed_at_lift_off():
    """So that it has departed from its plan whenever it is planned anew."""
    return (Push(plan().lift_off - 2 * TICK - DURATION, (0.0, 10.0, 0.0)),)


@cache
def replanned_at_lift_off():
    """A rollout in which every computation takes 8 ms."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(replanning, "time", Clock(0.008))
        return simulate(plan(), ROBOT, Scenario(pushes=pushed_at_lift_off(), replan=True))


def test_it_is_asked_at_50_hz_in_flight_and_after_and_followed_after_the_latency():
    rollout = replanned_at_lift_off()
    asked = np.array([replan.measured for replan in rollout.replans])
    applied = np.array([replan.applied for replan in rollout.replans])
    assert rollout.outcome.replans == len(asked) > 20
    assert asked[0] == pytest.approx(plan().lift_off, abs=2 * TICK)
    assert np.diff(asked).min() == pytest.approx(PERIOD, abs=1e-6)
    detected = rollout.outcome.touchdown_detected_s
    assert (asked > detected).any()
    followed = ~np.isnan(applied)
    assert followed.mean() > 0.9  # not the one that touchdown overtook
    assert applied[followed] - asked[followed] == pytest.approx(LATENCY, abs=1e-6)
    assert rollout.outcome.replan_median_s == pytest.approx(0.008)


def test_with_a_measured_latency_a_slow_answer_is_followed_when_it_is_there(takes):
    takes(0.05)
    scenario = Scenario(pushes=pushed_at_lift_off(), replan=True, replan_latency="measured")
    rollout = simulate(plan(), ROBOT, scenario)
    asked = np.array([replan.measured for replan in rollout.replans])
    applied = np.array([replan.applied for replan in rollout.replans])
    followed = ~np.isnan(applied)
    assert applied[followed] - asked[followed] == pytest.approx(0.05, abs=1.5 * TICK)
    assert np.diff(asked).min() >= 0.05 - 1e-6
    assert rollout.landed


def test_a_rollout_does_not_depend_on_how_long_computing_takes(monkeypatch):
    """Nor on a clock that runs backwards, as a loaded machine's may seem to."""
    rng = np.random.default_rng(1)
    clock = SimpleNamespace(thread_time=lambda: float(rng.uniform(0.0, 0.2)))
    monkeypatch.setattr(replanning, "time", clock)
    idle = replanned_at_lift_off()
    loaded = simulate(plan(), ROBOT, Scenario(pushes=pushed_at_lift_off(), replan=True))
    assert idle.outcome.replan_p95_s != loaded.outcome.replan_p95_s  # still the real time
    assert [r.applied for r in idle.replans] == pytest.approx(
        [r.applied for r in loaded.replans], abs=0, nan_ok=True
    )
    for name in ("qpos", "qvel", "torque", "contact_force", "phase"):
        np.testing.assert_array_equal(getattr(idle, name), getattr(loaded, name))


def test_the_latency_is_the_robots():
    assert latency_of(ROBOT) == LATENCY
    assert latency_of(load_robot("slider")) == LATENCY_FEW_LEGS
    control = ROBOT.file.control.model_copy(update={"replan_latency": 0.035})
    file = ROBOT.file.model_copy(update={"control": control})
    assert latency_of(SimpleNamespace(file=file, legs=ROBOT.legs)) == 0.035
    with pytest.raises(InputError, match=r'no replan latency "none"; .*fixed, measured'):
        check_scenario(Scenario(replan_latency="none"), ROBOT)


def test_an_unknown_kind_of_drives_is_refused():
    with pytest.raises(InputError, match='no drives "none"; valid: true, ideal'):
        check_scenario(Scenario(drives="none"), ROBOT)


CALM = Scenario(seed=3, noise=1.0)


@cache
def calm():
    return simulate(plan(), ROBOT, CALM)


def test_where_nothing_happens_it_lands_as_it_does_without(takes):
    takes(0.01)
    replanned = simulate(plan(), ROBOT, replace(CALM, replan=True))
    assert replanned.outcome.strict
    assert any(replan.solved for replan in replanned.replans)
    np.testing.assert_array_equal(replanned.qpos, calm().qpos)


@cache
def pushed_gently():
    """A rollout with a push in mid-flight and computations of 10 ms."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(replanning, "time", Clock(0.01))
        push = (Push(middle(), (0.0, 8.0, 0.0)),)
        return simulate(plan(), ROBOT, Scenario(pushes=push, replan=True))


def test_the_first_plan_is_followed_until_a_push():
    replans = pushed_gently().replans
    before = [replan for replan in replans if replan.measured < middle()]
    after = [replan for replan in replans if replan.measured > middle() + DURATION]
    assert len(before) > 2
    assert all(replan.solved and np.isnan(replan.applied) for replan in before)
    assert np.mean([np.isfinite(replan.applied) for replan in after]) > 0.8


def test_a_push_in_mid_flight_is_recovered_from_only_by_planning_anew(takes):
    """With knees off the ground: legs that may lie down land less tilted.

    Of seeds 1 to 6 this one is farthest from either verdict: 16.5 and 9.6 degrees of at most 15.
    Planning anew recovers five of them, and two are recovered without.
    """
    takes(0.015)
    push = (Push(middle(), ASIDE),)
    without, anew = (
        simulate(plan(), ROBOT, Scenario(seed=3, noise=1.0, pushes=push, replan=on)).outcome
        for on in (False, True)
    )
    assert not without.recovered
    assert anew.recovered
    assert anew.peak_tilt < 0.7 * without.peak_tilt


@pytest.mark.nightly
def test_the_whole_bodys_plan_is_planned_anew_with_its_feet_where_they_shall_land(takes):
    takes(0.0)
    jump = llsrbm.Jump(robot="go2", twist=0.5, forward=0.1, stones={"FL": (0.03, 0.02)})
    plan = llsrbm.plan(jump)
    assert plan.certified
    push = Push(float(plan.phase_start[1]) + 0.05, (0.0, 6.0, 0.0))
    rollout = simulate(plan, load_robot("go2"), Scenario(pushes=(push,), replan=True))
    assert rollout.landed
    followed = [each for each in rollout.replans if np.isfinite(each.applied)]
    assert followed
    # All feet by as much, as far as the push has moved the robot.
    moved = followed[-1].foot_position[-1] - plan.foot_position[-1]
    np.testing.assert_allclose(moved - moved.mean(axis=0), 0.0, atol=0.01)


def test_what_is_recorded_is_what_was_followed(tmp_path):
    rollout = pushed_gently()
    after = next(replan for replan in rollout.replans if replan.measured > middle() + 0.03)
    assert after.solved
    assert after.time[0] == pytest.approx(after.measured + LATENCY, abs=1e-6)
    assert after.touchdown == pytest.approx(rollout.outcome.touchdown_true_s, abs=0.02)
    # The CoM comes down where that answer saw it come down.
    down = np.searchsorted(rollout.time, after.touchdown)
    seen = after.com[np.argmin(np.abs(after.time - after.touchdown))]
    assert rollout.com[down] == pytest.approx(seen, abs=0.02)
    rollout.save(tmp_path / "replanned.npz")
    read = load(tmp_path / "replanned.npz")
    assert len(read.replans) == len(rollout.replans)
    np.testing.assert_array_equal(read.replans[-1].com, rollout.replans[-1].com)


def test_where_nothing_is_found_the_old_plan_goes_on(takes, monkeypatch):
    takes(0.01)
    none = replanning.Answer(None, 0, 0.0)
    monkeypatch.setattr(replanning.Replanner, "replan", lambda self, state: none)
    lost = simulate(plan(), ROBOT, replace(CALM, replan=True))
    assert lost.replans
    assert not any(replan.solved for replan in lost.replans)
    np.testing.assert_array_equal(lost.qpos, calm().qpos)


@cache
def quarter_turn():
    return llsrbm.plan(llsrbm.Jump(robot="slider", twist=np.radians(45)), draft=True)


@pytest.mark.nightly
@pytest.mark.parametrize("moment", ["lift-off", "mid-flight"])
def test_soles_are_moved_elsewhere_only_where_there_is_time(takes, moment):
    takes(0.015)
    slider = quarter_turn()
    middle = (slider.lift_off + slider.touchdown) / 2
    at = {"lift-off": slider.lift_off - DURATION, "mid-flight": middle}[moment]
    forward = {"lift-off": 5.0, "mid-flight": 3.7}[moment]  # N s; less departs too little
    push = (Push(at, (forward, 0.0, 0.0)),)
    rollout = simulate(slider, load_robot("slider"), Scenario(pushes=push, replan=True))
    followed = [r for r in rollout.replans if r.applied < slider.touchdown - 0.01]
    assert bool(followed) == (moment == "lift-off")
    assert rollout.outcome.recovered
