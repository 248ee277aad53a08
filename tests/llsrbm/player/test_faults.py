"""Whatever goes wrong, the robot is damped within 100 ms, and one line says why."""

import re
from dataclasses import replace

import numpy as np
import pytest

from llsrbm.errors import InputError
from llsrbm.player import TIERS, check_plan
from llsrbm.player.states import Check, Damp, Stand
from llsrbm.player.stops import HOTTEST, tilt_from
from llsrbm.robots import load_robot
from llsrbm.wire.channel import Faults
from llsrbm.wire.link import Health
from llsrbm.wire.simulated_robot import Conditions
from tests.llsrbm.player.stages import GO2, Stage, is_brake, stored_plan

SOON = 0.1  # s
PUSHING = 1.2  # s; at 1.0 the hind thighs' torques change their sign
BRIEF = {Check: 0.1, Stand: 0.2, Damp: 0.3}  # s; a fault does not wait for longer
RAMPING, STANDING = 0.3, 0.7  # s by the robot's clock
ON_THE_GROUND, IN_THE_AIR, LANDED = 1.0, 1.4, 2.0  # likewise; the plan begins at 0.8


@pytest.fixture(autouse=True)
def brief(monkeypatch):
    for state, duration in BRIEF.items():
        monkeypatch.setattr(state, "duration", duration)


def assert_damped(stage, ended, fault, state, words):
    assert re.fullmatch(rf"stopped in {state} and damped: {words}", ended.line), ended.line
    assert "\n" not in ended.line
    assert stage.names[-1] == "damp"
    assert 0 <= stage.damped_after(fault) <= SOON


@pytest.mark.parametrize("fault", [STANDING, IN_THE_AIR])
def test_a_lost_topic(fault):
    stage = Stage()
    stage.wire.silent_from = fault
    state = "stand" if fault < stage.jump else "jump"
    words = r"lost link: no reading for 2\d ms, at most 20 are allowed"
    assert_damped(stage, stage.run(), fault, state, words)


def test_a_robot_that_is_never_heard():
    stage = Stage()
    stage.wire.silent_from = 0.0
    ended = stage.run()
    assert re.search(r"in check and damped: lost link: nothing was heard of the robot", ended.line)
    assert ended.time == pytest.approx(2.0, abs=0.01)
    assert all(is_brake(command) for _, command in stage.wire.sent)


def test_another_program_that_commands_the_robot():
    """Two writers fight for the motors: this one stops at once and sends no brakes either."""
    fault = IN_THE_AIR
    stage = Stage()
    stage.wire.others = lambda: 3 * (stage.simulated.time >= fault)
    ended = stage.run()
    assert re.search(r"and left alone: commands: another program .* \(3 heard\)", ended.line)
    assert "damp" not in stage.names
    assert fault <= ended.time <= fault + 0.01
    assert all(time < ended.time for time, _ in stage.wire.sent)


def test_readings_that_come_late():
    stage = Stage()
    stage.wire.late_from, stage.wire.late_by = IN_THE_AIR, 0.012
    words = r"late: readings come 1\d ms late, at most 10 are allowed"
    assert_damped(stage, stage.run(), IN_THE_AIR, "jump", words)


def test_messages_late_by_20_ms():
    stage = Stage()
    stage.wire.late_from = ON_THE_GROUND
    words = r"(lost link: no reading for 2\d ms|late: readings come 20 ms late), .*"
    assert_damped(stage, stage.run(), ON_THE_GROUND, "jump", words)


def test_messages_that_were_late_from_the_start_show_in_the_drives():
    """Two clocks cannot tell how late: but torques come back late. Both ways take 20 ms."""
    always = Conditions(faults=Faults(late=1.0, late_by=0.02))
    stage = Stage(conditions=always)
    ended = stage.run()
    words = r"late: the drives follow commands after 4\d ms, at most 10 are allowed"
    assert_damped(stage, ended, ended.time, "ramp", words)


def test_the_delay_that_is_found_is_the_wire_s():
    for delay in (0.0, 0.008):
        stage = Stage(conditions=Conditions(delay=delay, delay_spread=0.0))
        stage.at = [(0.59, lambda stage=stage: stage.player.stop("enough"))]
        stage.run()
        assert stage.states[1]._round_trip.delay == pytest.approx(delay, abs=1e-9)


def on_its_side():
    q = GO2.posture.copy()
    q[2], q[3:7] = 0.2, [np.sin(np.pi / 4), 0.0, 0.0, np.cos(np.pi / 4)]
    return q


def with_joint(joint, angle):
    q = GO2.posture.copy()
    q[7 + GO2.joint_names.index(joint)] = angle
    return q


@pytest.mark.parametrize(
    ("posture", "words"),
    [
        (on_its_side(), r"posture: the base is tilted by \d+ deg, expected at most 20"),
        (
            with_joint("FL_thigh_joint", 3.1),
            r"posture: FL_thigh_joint is 2\.\d+ rad from the plan's first posture, .*",
        ),
    ],
    ids=["on its side", "a leg turned up"],
)
def test_a_wrong_posture_at_first(posture, words):
    stage = Stage(posture=posture)
    ended = stage.run()
    assert_damped(stage, ended, ended.time, "check", words)
    assert ended.time < SOON
    assert all(is_brake(command) for _, command in stage.wire.sent)


def test_a_posture_that_is_not_reached():
    """Somebody holds a leg while the robot stands up."""
    stage = Stage()
    held = stage.simulated.world.drives.limited

    def weak(torque, speed):
        given, limit = held(torque, speed)
        return 0.02 * given, limit

    stage.at = [(0.2, lambda: setattr(stage.simulated.world.drives, "limited", weak))]
    ended = stage.run()
    assert ended.state in ("ramp", "stand")
    assert re.search(r"(posture|drive): ", ended.line)


@pytest.mark.parametrize(
    ("tier", "joint"), [("table", "FL_calf_joint"), ("closed-loop", "RL_thigh_joint")]
)
def test_a_drive_that_gives_nothing(tier, joint):
    stage = Stage(tier)
    limited = stage.simulated.world.drives.limited
    place = GO2.joint_names.index(joint)

    def without(torque, speed):
        given, limit = limited(torque, speed)
        given[place] = 0.0
        return given, limit

    fault = PUSHING
    stage.at = [(fault, lambda: setattr(stage.simulated.world.drives, "limited", without))]
    words = rf"drive: {joint} gives -?\d\.\d Nm, -?\d+\.\d Nm are commanded"
    assert_damped(stage, stage.run(), fault, "jump", words)


def test_a_plan_beyond_its_certificate():
    plan, robot = stored_plan("go2"), load_robot("go2")
    plan = replace(plan, contact_force=3 * plan.contact_force)
    for tier in TIERS.values():
        with pytest.raises(
            InputError, match=r"certificate does not hold: \w+ .* tier .*`llsrbm plan`"
        ):
            check_plan(plan, robot, tier)


def test_plans_that_are_refused_for_other_reasons():
    plan, robot = stored_plan("go1"), load_robot("go1")
    assert check_plan(plan, robot, TIERS["table"]).holds
    with pytest.raises(InputError, match=r"of robot go1, the robot to be played on is anymal"):
        check_plan(plan, load_robot("anymal"), TIERS["table"])
    failed = replace(plan, report=replace(plan.report, status="failed"))
    with pytest.raises(InputError, match=r"did not converge"):
        check_plan(failed, robot, TIERS["table"])
    moving = replace(plan, jump=replace(plan.jump, type="run-up", speed=0.5))
    with pytest.raises(InputError, match=r"begins or ends with a speed"):
        check_plan(moving, robot, TIERS["table"])


def test_a_player_that_is_killed():
    """The robot's own motors brake when nobody commands them: its side of the bargain."""
    stage = Stage()

    class Killed(BaseException):
        pass

    def kill():
        stage.wire.send = lambda command: None  # what a process that is gone sends
        raise Killed

    stage.at = [(IN_THE_AIR, kill)]
    braking = []
    stage.simulated.observers.append(
        lambda tick: braking.append(tick.time) if stage.simulated.braking else None
    )
    with pytest.raises(Killed):
        stage.run()
    assert 0 < braking[0] - IN_THE_AIR <= SOON


def test_a_player_that_fails_damps_before_it_says_so(monkeypatch):
    stage = Stage()
    command = stage.tier.command

    def failing(time, readings):
        if time > 0.2:
            raise np.linalg.LinAlgError("singular")
        return command(time, readings)

    monkeypatch.setattr(stage.tier, "command", failing)
    with pytest.raises(np.linalg.LinAlgError):
        stage.run()
    assert stage.names[-1] == "damp"
    assert stage.damped_after(stage.jump + 0.2) <= SOON


@pytest.mark.parametrize("moment", [0.05, RAMPING, IN_THE_AIR, LANDED])
def test_ctrl_c_damps(moment):
    stage = Stage()
    stage.at = [(moment, lambda: stage.player.stop("Ctrl-C"))]
    assert_damped(stage, stage.run(), moment, r"\w+", "Ctrl-C")
    assert stage.damped_after(moment) <= 0.004


def test_a_push_over_is_a_tilt():
    stage = Stage()
    push = lambda: stage.simulated.world.push(np.zeros(3), np.array([900.0, 0.0, 0.0]))  # noqa: E731
    stage.at = [(IN_THE_AIR + 0.002 * k, push) for k in range(4)]
    words = r"tilt: 4\d deg from the plan, at most 45 are allowed"
    ended = stage.run()
    assert re.fullmatch(rf"stopped in jump and damped: {words}", ended.line), ended.line
    assert stage.damped_after(ended.time) <= 0.004


class SlowClock:
    """A computer that takes a while for each command from a moment on, s."""

    def __init__(self, slow_from, takes):
        self.slow_from, self.takes, self.lost = slow_from, takes, 0.0
        self.simulated = None

    def __call__(self):
        return self.simulated.time + self.lost

    def command(self, command):
        def slow(time, readings):
            if self.simulated.time >= self.slow_from:
                self.lost += self.takes
            return command(time, readings)

        return slow


@pytest.mark.parametrize(
    ("takes", "words"),
    [
        (0.0045, r"(deadlines: 10 of the last \d+ commands|late: readings come) .*"),
        (0.05, r"deadlines: the player stood still for \d\d ms, at most 20 are allowed"),
    ],
)
def test_missed_deadlines(takes, words):
    clock = SlowClock(ON_THE_GROUND, takes)
    stage = Stage(clock=clock)
    clock.simulated = stage.simulated
    stage.tier.command = clock.command(stage.tier.command)
    assert_damped(stage, stage.run(), ON_THE_GROUND, "jump", words)


@pytest.mark.parametrize(
    ("health", "words"),
    [
        (Health(28.0, 0.9, HOTTEST + 5), r"temperature: a motor has 80 deg C, .*"),
        (Health(25.0, 0.1, 40.0), r"battery: 10 % are left, at least 25 are needed"),
        (Health(None, None, 40.0), None),
    ],
)
def test_hot_motors_and_an_empty_battery(health, words):
    stage = Stage()
    stage.wire.health = health
    if words is None:
        stage.at = [(0.05, lambda: stage.player.stop("Ctrl-C"))]
    fault = 0.05 if words is None else 0.0
    assert_damped(stage, stage.run(), fault, "check", words or "Ctrl-C")


def test_a_controller_without_solutions(monkeypatch):
    stage = Stage("closed-loop")
    step = stage.tier.controller.step

    def unsolved(measurement):
        tick = step(measurement)
        if measurement.time < 0.2:
            return tick
        return replace(tick, command=tick.command._replace(solved=False))

    monkeypatch.setattr(stage.tier.controller, "step", unsolved)
    words = r"the controller's program was not solved in 10 ticks in a row"
    assert_damped(stage, stage.run(), stage.jump + 0.2, "jump", words)


def test_flips_may_turn_over():
    """Tilt is from the plan, not from the vertical."""
    upside_down = np.array([0.0, 0.0, -1.0])
    assert tilt_from(upside_down, np.array([0.0, 1.0, 0.0, 0.0])) == pytest.approx(0.0)
    assert tilt_from(upside_down, np.array([1.0, 0.0, 0.0, 0.0])) == pytest.approx(np.pi)
