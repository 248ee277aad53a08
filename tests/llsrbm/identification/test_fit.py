"""Drives of logs that are known exactly, of simulated robots, and of logs that do not tell."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.identify import GOALS, errors, hidden, recorded
from llsrbm.errors import InputError
from llsrbm.identification import identify
from tests.llsrbm.identification.synthetic import (
    ARMATURE,
    DAMPING,
    DELAY,
    FRICTION,
    GO2,
    synthetic_log,
)


@pytest.fixture(scope="module")
def log():
    return synthetic_log()


@pytest.fixture(scope="module")
def found(log):
    return identify(GO2, log)


def numbers(found):
    return np.array([[getattr(drive, name) for name in GOALS] for drive in found.joints.values()])


def test_an_exact_log_gives_its_numbers(found):
    assert list(found.joints) == list(GO2.joint_names)
    assert not found.undetermined
    truth = np.column_stack([ARMATURE, FRICTION, DAMPING])
    assert numbers(found) == pytest.approx(truth, rel=0.02)
    assert found.delay == pytest.approx(DELAY, abs=2e-5)
    assert abs(found.speed_lag) < 1e-5


@pytest.mark.parametrize("period", [0.004, 0.01])
def test_slow_logs_give_them_too(period):
    """Rows may be 10 ms apart; a filter shorter than a row would make no accelerations of them."""
    found = identify(GO2, synthetic_log(24.0, period=period))
    assert not found.undetermined
    truth = np.column_stack([ARMATURE, FRICTION, DAMPING])
    assert numbers(found) == pytest.approx(truth, rel=0.1)
    assert found.delay == pytest.approx(DELAY, abs=1e-4)


def test_modelled_torques_are_those_measured(found):
    inside = slice(1000, -1000)
    off = (found.measured - found.modelled)[inside]
    assert np.sqrt(np.mean(off**2)) < 0.1 * np.std(found.measured[inside])


def test_all_numbers_scale_with_the_torque(log, found):
    """Twice the torque on links twice as heavy: the same motion, twice of everything."""
    model = GO2.model.copy()
    for body in model.inertias:
        body.mass *= 2
        body.inertia = 2 * body.inertia
    double = identify(replace(GO2, model=model), replace(log, sent=2 * log.sent))
    assert numbers(double) == pytest.approx(2 * numbers(found), rel=1e-3)
    assert double.delay == pytest.approx(found.delay, abs=1e-7)


def test_encoders_zeros_are_told_and_make_up_for(log, found):
    """The same motion, read by encoders whose zeros are off."""
    zeros = 0.004 * np.random.default_rng(2).standard_normal(len(GO2.joint_names))
    off = identify(GO2, replace(log, q=log.q + zeros))
    assert np.abs(off.zeros - found.zeros - zeros).max() < 4e-4  # of up to 10 mrad
    assert (np.abs(off.zeros - zeros) < 2 * off.zero_errors).all()
    assert (off.zero_errors < 1e-3).all()  # of 5 mrad before anything is measured
    assert numbers(off) == pytest.approx(numbers(found), rel=5e-3)


def test_what_motors_take_by_their_own_gains_is_not_delayed(log, found):
    taken = 2.0 * log.q + 0.1 * log.dq
    sent = log.sent + ahead(taken, DELAY + log.period / 2, log.period)
    again = identify(GO2, replace(log, sent=sent, feedback=taken))
    assert numbers(again) == pytest.approx(numbers(found), rel=0.02)


def ahead(values, by, period):
    """Values (K, J) as they are `by` s later."""
    times = period * np.arange(len(values))
    return np.column_stack([np.interp(times + by, times, each) for each in values.T])


def test_joints_that_rest_are_not_told(log):
    still = synthetic_log(moving=slice(0, 6))
    found = identify(GO2, still)
    assert list(found.joints) == list(GO2.joint_names[:6])
    assert set(found.undetermined) == set(GO2.joint_names[6:])
    assert set(found.undetermined.values()) == {"it does not move"}
    with pytest.raises(
        InputError, match=r"synthetic.csv: no joint's drive .*FL_hip_joint: it does"
    ):
        identify(GO2, synthetic_log(moving=slice(0, 0)))


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"dq": np.degrees}, r"dq:\w+ is 57.3 times the change of q:\w+ with time; expected rad/s"),
        ({"dq": np.negative}, r"dq:\w+ is -1 times the change of q:\w+ with time"),
        (
            {"q": np.degrees, "dq": np.degrees},
            r"q:\w+ is at -?\d+ in most rows, beyond its stops .*; expected rad, with the zero",
        ),
        ({"q": np.negative, "dq": np.negative}, r"q:\w+_calf_joint is at .* beyond its stops"),
        ({"sent": lambda torque: 1e3 * torque}, r"tau:\w+ is .* gives 23.7 at most; expected Nm"),
    ],
)
def test_other_units_and_signs_are_told(log, changed, message):
    other = replace(log, **{name: change(getattr(log, name)) for name, change in changed.items()})
    with pytest.raises(InputError, match=f"synthetic.csv: {message}"):
        identify(GO2, other)


def test_torques_that_no_drive_has_are_told(log, found):
    pulled = log.sent.copy()
    pulled[:, 0] += 0.3 * np.sin(3.0 * log.period * np.arange(len(pulled)))  # a rope, say
    again = identify(GO2, replace(log, sent=pulled))
    assert set(again.undetermined) == {"FL_hip_joint"}
    assert "Nm are not explained, as if links touched" in again.undetermined["FL_hip_joint"]
    assert numbers(again) == pytest.approx(numbers(found)[1:], rel=1e-3)


def test_speeds_that_a_filter_makes_late_do_not_make_the_delay_longer(log, found):
    differences = np.vstack([log.dq[:1], np.diff(log.q, axis=0) / log.period])
    again = identify(GO2, replace(log, dq=differences))
    assert again.speed_lag == pytest.approx(log.period / 2, abs=1e-5)
    assert again.delay == pytest.approx(found.delay, abs=1e-5)
    assert numbers(again) == pytest.approx(numbers(found), rel=0.05)


def test_hidden_drives_of_a_simulated_robot():
    drives = hidden(GO2, 40)
    found = identify(GO2, recorded(drives, 20.0, 500, 40))
    assert not found.undetermined
    off = errors(drives, found)
    assert all(off[name] < goal for name, goal in GOALS.items()), off
    assert abs(found.delay - drives.delay) < 1e-4
    drive = found.joints["FL_calf_joint"]
    assert 0 < drive.armature_error < 0.05 * drive.armature
