"""Pushes in the loop: what the momenta show of them, which are drawn, which are refused."""

import math

import numpy as np
import pytest

from llsrbm.errors import InputError
from llsrbm.motion.trajectory import load
from llsrbm.request.scenario import DURATION, Push, Scenario
from llsrbm.robots import load_robot
from llsrbm.simulation.disturbance import Pushes, drawn_push
from llsrbm.simulation.episode import Situation
from llsrbm.simulation.simulate import simulate
from tests.llsrbm.formats.jumps import planned

ROBOT = load_robot("anymal")


def plan():
    return planned("anymal")


class Scales:
    """A world that sums what it is pushed with."""

    def __init__(self, tick):
        self.tick, self.impulse, self.moment, self.pushed_at = tick, np.zeros(3), np.zeros(3), []

    def push(self, force, moment):
        self.impulse += self.tick * force
        self.moment += self.tick * moment


def weighed(pushes, tick):
    world = Scales(tick)
    for k in range(round(1.0 / tick)):
        before = world.impulse.copy()
        pushes.before(Situation(k * tick, None, None, world, []))
        if (world.impulse != before).any():
            world.pushed_at.append(k * tick)
    return world


@pytest.mark.parametrize("tick", [1 / 400, 1 / 333, 1 / 1000, 0.03])
@pytest.mark.parametrize("at", [0.0, 0.3, 0.3012])
def test_the_impulse_is_exact_whatever_the_tick(tick, at):
    push = Push(at, (1.0, -2.0, 3.0), (0.1, 0.2, -0.3))
    world = weighed(Pushes(plan(), Scenario(pushes=(push,)), 3.0), tick)
    assert world.impulse == pytest.approx(push.impulse)
    assert world.moment == pytest.approx(push.moment)
    first, last = world.pushed_at[0], world.pushed_at[-1] + tick
    assert first <= at + 1e-9
    assert last >= at + DURATION - 1e-9
    assert last - first < DURATION + 2 * tick


def test_pushes_at_one_moment_add_up():
    pushes = (Push(0.3, (1, 0, 0)), Push(0.31, (0, 2, 0)), Push(0.3, (4, 0, 0)))
    world = weighed(Pushes(plan(), Scenario(pushes=pushes), 3.0), 1 / 400)
    assert world.impulse == pytest.approx([5, 2, 0])


def test_a_robot_in_flight_gains_the_impulse(tmp_path):
    start = plan().lift_off + 0.1
    push = Push(start, (4.0, -3.0, 1.0))
    pushed, calm = (simulate(plan(), ROBOT, Scenario(pushes=given)) for given in ((push,), ()))
    after = np.searchsorted(pushed.time, start + DURATION - 1e-9)
    gained = pushed.linear_momentum[after] - calm.linear_momentum[after]
    assert gained == pytest.approx(push.impulse, abs=0.02)
    before = slice(0, np.searchsorted(pushed.time, start))
    np.testing.assert_array_equal(pushed.qpos[before], calm.qpos[before])
    pushed.save(tmp_path / "pushed.npz")
    assert load(tmp_path / "pushed.npz").pushes == pushed.pushes == (push,)


def test_pushed_aside_it_recovers_though_its_feet_are_elsewhere():
    """The strict measure asks for the feet's place, which a push rightly moves."""
    push = Push(plan().lift_off + 0.05, (0.0, 7.0, 0.0))
    outcome = simulate(plan(), ROBOT, Scenario(pushes=(push,))).outcome
    assert outcome.foot_error > 0.05
    assert outcome.recovered
    assert not outcome.strict
    assert (outcome.replans, outcome.replan_median_s, outcome.replan_p95_s) == (0, None, None)


def test_a_drawn_push_is_the_seeds_whatever_its_size():
    drawn = [drawn_push(plan(), Scenario(seed=seed, random_push=10)) for seed in range(50)]
    assert drawn == [drawn_push(plan(), Scenario(seed=seed, random_push=10)) for seed in range(50)]
    assert all(math.hypot(*push.impulse) == pytest.approx(10) for push in drawn)
    assert all(push.impulse[2] == 0 and not any(push.moment) for push in drawn)
    times = [push.time for push in drawn]
    assert 0 <= min(times) < 0.2 * plan().touchdown < 0.8 * plan().touchdown < max(times)
    assert max(times) <= plan().touchdown
    sides = {(push.impulse[0] > 0, push.impulse[1] > 0) for push in drawn}
    assert len(sides) == 4
    larger = drawn_push(plan(), Scenario(seed=7, random_push=20))
    assert larger.time == drawn[7].time
    assert larger.impulse == pytest.approx(2 * np.array(drawn[7].impulse))
    assert drawn_push(plan(), Scenario(random_push=10)) == drawn[0]
    assert drawn_push(plan(), Scenario(seed=3)) is None


def test_a_rollout_tells_what_was_drawn(monkeypatch, tmp_path):
    monkeypatch.setattr("llsrbm.simulation.simulate.STANDING", -0.4)  # the landing is no matter
    scenario = Scenario(random_push=3.0, pushes=(Push(0.1, (0, 0, 1)),))
    rollout = simulate(plan(), ROBOT, scenario)
    expected = (Push(0.1, (0, 0, 1)), drawn_push(plan(), scenario))
    rollout.save(tmp_path / "rollout.npz")
    for one in (rollout, load(tmp_path / "rollout.npz")):
        assert one.pushes == expected
        assert one.disturbance.random_push == expected[1]


def test_a_push_after_the_simulations_end_is_refused():
    end = plan().duration + 1.0
    with pytest.raises(InputError) as caught:
        simulate(plan(), ROBOT, Scenario(pushes=(Push(9.0, (1, 0, 0)),)))
    assert str(caught.value) == (
        f"push: time: expected 0 to {end - DURATION:.2f} s, as the simulation ends at "
        f"{end:.2f} s, got 9 s"
    )
    Pushes(plan(), Scenario(pushes=(Push(end - DURATION, (1, 0, 0)),)), end)
