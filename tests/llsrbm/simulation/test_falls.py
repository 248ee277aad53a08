"""Falls whose cause is known, because it was put there: the first event has to name it."""

import pytest

from llsrbm.analysis.diagnosis import diagnose, fall_in_words
from llsrbm.motion.rollout import Disturbance
from llsrbm.request.scenario import Scenario
from llsrbm.robots import load_robot
from llsrbm.robots.drives.torques import torque_in_direction
from llsrbm.simulation import simulate as loop
from llsrbm.simulation import world
from tests.llsrbm.planning.solved import solved


def follow(scenario=None):
    plan = solved("llsrbm-plus", "forward").plan
    return loop.simulate(plan, load_robot("anymal"), scenario or Scenario())


def ice(monkeypatch):
    disturbance = Disturbance(friction=0.05)
    monkeypatch.setattr(loop, "draw_disturbance", lambda *_: disturbance)


def weak_drives(monkeypatch):
    def weaker(robot, speed, torque):
        return 0.35 * torque_in_direction(robot, speed, torque)

    monkeypatch.setattr(world, "torque_in_direction", weaker)


def a_deaf_detector(monkeypatch):
    class Deaf(loop.WholeBodyController):
        def __init__(self, *arguments):
            super().__init__(*arguments)
            self.detector.threshold = 1e9

    monkeypatch.setattr(loop, "WholeBodyController", Deaf)


@pytest.mark.parametrize(
    ("cause", "what"),
    [
        (ice, "slip"),
        (weak_drives, "torque limit"),
        (a_deaf_detector, "detection"),
    ],
)
def test_the_first_event_is_the_cause(cause, what, monkeypatch):
    cause(monkeypatch)
    rollout = follow()
    assert not rollout.landed, rollout.outcome
    events = diagnose(rollout)
    assert events[0].what == what, events
    assert events[0].words in fall_in_words(rollout)


def test_a_landing_with_everything_disturbed_has_none():
    rollout = follow(Scenario(seed=3))
    assert rollout.landed, rollout.outcome
    assert diagnose(rollout) == ()
