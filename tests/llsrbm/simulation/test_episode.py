"""The loop and its hooks: when they act, what they see, and that they change nothing by looking."""

import numpy as np
import pytest

from llsrbm.control.controller import WholeBodyController
from llsrbm.motion.rollout import Disturbance
from llsrbm.motion.surroundings import surroundings
from llsrbm.request.scenario import Scenario
from llsrbm.robots import load_robot
from llsrbm.simulation.episode import Episode, Hook, Recorder
from llsrbm.simulation.sensors import Sensors
from llsrbm.simulation.simulate import standing_state
from llsrbm.simulation.world import World
from tests.llsrbm.formats.jumps import planned

ROBOT = load_robot("anymal")
TICK = 1 / 400


def episode(*hooks, **scenario):
    plan, scenario = planned("anymal"), Scenario(**scenario)
    disturbance = Disturbance(base_velocity_noise=0.01)
    world = World(ROBOT, surroundings(ROBOT, plan, scenario), disturbance, TICK)
    world.reset(standing_state(ROBOT, plan), np.zeros(18))
    recorder = Recorder(ROBOT, Disturbance())
    controller = WholeBodyController(ROBOT, plan, scenario)
    sensors = Sensors(ROBOT, disturbance, scenario, TICK)
    return Episode(world, sensors, controller, recorder, hooks), recorder


class Watching(Hook):
    """Notes what it sees; adds a word to the replans each tick."""

    def __init__(self, name="", notes=None):
        self.name, self.notes = name, [] if notes is None else notes

    def before(self, situation):
        self.notes.append(("before", self.name, situation))
        situation.replans.append(f"{self.name} at {situation.time:.4f}")

    def after(self, situation, tick, result):
        self.notes.append(("after", self.name, situation, tick, result))


def test_hooks_act_in_their_order_around_each_tick():
    notes = []
    run, recorder = episode(Watching("a", notes), Watching("b", notes))
    run.run(3)
    assert [note[:2] for note in notes] == 3 * [
        ("before", "a"), ("before", "b"), ("after", "a"), ("after", "b"),
    ]  # fmt: skip
    for k in range(3):
        before, _, after, _ = notes[4 * k : 4 * k + 4]
        assert before[2] is after[2]
        assert after[3] is recorder.ticks[k]
        assert after[4] is recorder.results[k]
        seen = before[2]
        assert seen.time == seen.measurement.time == k * TICK
        np.testing.assert_array_equal(seen.measurement.q, recorder.q[k])
        assert (seen.measurement.v != recorder.v[k])[:6].all()  # noise
        torque = recorder.results[k - 1].torque if k else np.zeros(12)
        np.testing.assert_array_equal(seen.measurement.torque, torque)
        assert seen.controller.contacts.standing.all()
    assert run.replans == [f"{name} at {k * TICK:.4f}" for k in range(3) for name in "ab"]
    assert run.fall is None
    assert run.wall_time > 0


def test_hooks_that_look_change_nothing():
    (plain, first), (watched, second) = episode(), episode(Watching())
    plain.run(40)
    watched.run(40)
    np.testing.assert_array_equal(first.q, second.q)
    np.testing.assert_array_equal(first.v, second.v)


def test_a_hook_pushes_in_the_tick_that_it_sees():
    class Pushing(Hook):
        def before(self, situation):
            if situation.time == pytest.approx(5 * TICK):
                situation.world.push(np.array([0.0, 2000.0, 0.0]), np.zeros(3))

    (plain, first), (pushed, second) = episode(), episode(Pushing())
    plain.run(7)
    pushed.run(7)
    np.testing.assert_array_equal(first.q[:6], second.q[:6])
    moved = second.v[6][:3] - first.v[6][:3]
    assert moved[1] > 0.05
