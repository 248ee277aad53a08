"""A plan from check to damp, in lock-step."""

import numpy as np
import pytest

from llsrbm.motion.block import Block
from llsrbm.motion.surroundings import Surroundings
from llsrbm.player import played as played_module
from llsrbm.player.played import play
from llsrbm.player.posture import FirstPosture, gains
from llsrbm.player.states import LEAST_RAMP, Check, Stand
from tests.llsrbm.player.stages import GO2, Stage, is_brake, stored_plan


def test_a_plan_is_played_to_its_end():
    """In closed loop; below from the table."""
    played = play(stored_plan(), GO2, "closed-loop", seed=4)
    assert played.ended.reason == ""
    assert played.ended.line == "played to the end, then damped"
    outcome = played.rollout.outcome
    assert outcome.strict, outcome
    assert abs(np.degrees(outcome.final_yaw_error)) < 5
    assert played.rollout.time[-1] == pytest.approx(stored_plan().duration + 1.0, abs=0.01)


def test_the_same_seed_gives_the_same_play():
    stages = Stage(seed=7), Stage(seed=7)
    for stage in stages:
        stage.at = [(2.5, lambda stage=stage: stage.player.stop("enough"))]
        stage.run()
    one, other = (stage.player.log.arrays() for stage in stages)
    for name in ("readings/q", "readings/gyro", "command/tau"):
        assert np.array_equal(one[name], other[name], equal_nan=True)


def test_states_follow_each_other():
    stage = Stage()
    stage.run()
    assert stage.names == ["check", "ramp", "stand", "jump", "damp"]
    times = np.array([time for time, _ in stage.wire.sent])
    commands = [command for _, command in stage.wire.sent]
    assert times[0] == pytest.approx(0.5)  # it listens before it sends anything
    assert np.diff(times) == pytest.approx(0.002)
    # The first command changes nothing: posture and torque are those that are there.
    true = stage.player.log.arrays()
    k = int(np.argmax(np.isfinite(true["command/q"][:, 0])))
    assert true["command/q"][k] == pytest.approx(true["readings/q"][k])
    assert true["command/tau"][k] == pytest.approx(true["readings/torque"][k])
    kp, kd = gains(GO2)
    standing = commands[round((LEAST_RAMP + 0.5) / 0.002)]
    first = FirstPosture.of(stored_plan(), GO2)
    assert standing.q == pytest.approx(first.joints)
    assert (standing.kp == kp).all()
    assert (standing.kd == kd).all()
    assert standing.tau == pytest.approx(first.torque)
    last = times >= stage.jump + stored_plan().duration + 1.0
    assert all(is_brake(command) for command, damps in zip(commands, last, strict=True) if damps)
    assert not any(
        is_brake(command) for command, damps in zip(commands, last, strict=True) if not damps
    )
    assert times[-1] - times[last][0] == pytest.approx(2.0, abs=0.01)
    position, velocity = stage.simulated.world.state()
    assert position[2] < 0.12  # it lies, a leg may still be sinking
    assert np.abs(velocity[:6]).max() < 0.15


def test_a_robot_that_lies_is_brought_up():
    lying = GO2.posture.copy()
    lying[2] = 0.16
    lying[7:] = np.tile([0.0, 1.25, -2.6], 4)
    stage = Stage(posture=lying)
    stage.simulated.advance(1.0)
    ended = stage.run()
    assert ended.reason == ""
    ramp = stage.states[1]
    assert ramp.duration > 1.0
    log = stage.player.log.arrays()
    ramping = log["state"] == 1
    assert np.abs(log["readings/dq"][ramping]).max() < 1.6


def test_the_log_has_all_that_was_read_and_sent():
    stage = Stage("closed-loop")
    stage.at = [(0.9, lambda: stage.player.stop("enough"))]
    stage.run()
    log = stage.player.log.arrays()
    assert set(log["state"]) == {0.0, 1.0, 4.0}
    assert np.isnan(log["command/q"][log["state"] == 0]).all()
    sent = np.array([command.q for _, command in stage.wire.sent])
    logged = log["command/q"][log["state"] == 1]
    assert np.isnan(logged[-1]).all()  # of the tick in which it was stopped
    assert np.array_equal(logged[:-1], sent[: len(logged) - 1])
    assert np.diff(log["robot_time"]) == pytest.approx(0.002)
    assert log["estimate/q"].shape == (len(log["time"]), GO2.model.nq)


def test_boxes_come_and_go_by_the_plans_own_time(monkeypatch):
    class BuiltError(Exception):
        pass

    def built(*_, surroundings, **__):
        raise BuiltError(surroundings)

    monkeypatch.setattr(played_module, "SimulatedRobot", built)
    place = np.zeros(3), np.ones(3), 0.0
    goes, comes = Block("block", *place, until_s=0.5), Block("box", *place, from_s=0.7)
    with pytest.raises(BuiltError) as made:
        play(stored_plan(), GO2, "closed-loop", around=Surroundings(0.0, (goes, comes)))
    begins = Check.duration + LEAST_RAMP + Stand.duration
    gone, come = made.value.args[0].blocks
    assert (gone.from_s, gone.until_s) == (0.0, pytest.approx(begins + 0.5))
    assert (come.from_s, come.until_s) == (pytest.approx(begins + 0.7), np.inf)
