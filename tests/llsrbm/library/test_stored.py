"""A plan in float32 and back: the same motion, and its certificate with it."""

from dataclasses import replace

import numpy as np
import pytest

import llsrbm
from llsrbm.errors import FileFormatError, InputError
from llsrbm.library.stored import reopened, stored
from llsrbm.motion.robot import robot_of
from tests.llsrbm.library.shipped_motions import card, first_of_each_robot, library, plan

# Of float32: a few units of its last place, of what is of about 1 (m, rad), 10 and 100 (N, Nm).
SAME = {"com": 1e-6, "base_quat": 1e-6, "joint_position": 1e-5, "joint_velocity": 1e-4}
SAME |= {"contact_force": 1e-3, "joint_torque": 1e-2, "foot_position": 1e-6, "time": 1e-6}


@pytest.mark.parametrize("name", first_of_each_robot())
def test_kept_and_opened_twice_it_is_the_same_motion(name):
    once, of = plan(name), card(name)
    grid, numbers = stored(once)
    assert tuple(count for _, count in grid.phases) == of.intervals
    assert grid.denser_in_flight == pytest.approx(of.denser_in_flight, abs=1e-6)
    again = reopened(of, numbers, robot_of(once), name)
    for key, most in SAME.items():
        assert np.abs(getattr(again, key) - getattr(once, key)).max() < most, key
    assert again.schedule == once.schedule
    assert again.limits == once.limits
    assert again.tuning == once.tuning
    assert again.robot_parameters == once.robot_parameters


def test_float32_loses_nothing_that_counts():
    """A float64 plan beside what is kept of it, by the equations of motion."""
    of = plan()
    torque = of.joint_torque.copy()
    _, numbers = stored(replace(of, base_position=of.base_position + 0.0))
    again = reopened(card(), numbers, robot_of(of), "x")
    assert np.abs(again.joint_torque - torque).max() < 1e-2


def test_its_feet_stand_where_forward_kinematics_puts_them():
    of = plan()
    again = llsrbm.certify(of)
    assert again["slip"].holds
    assert again["dynamics"].worst < 0.1


@pytest.mark.parametrize("change", [lambda row: row[:-1], lambda row: np.append(row, row[:3])])
def test_numbers_of_another_robot_are_refused(change):
    numbers = change(library().stored(card().name).numbers)
    with pytest.raises(FileFormatError, match=r"^x: .*expected the motion of this robot"):
        reopened(card(), numbers, robot_of(plan()), "x")


def test_other_phases_are_refused():
    other = card().model_copy(update={"intervals": (*card().intervals, 3)})
    numbers = library().stored(card().name).numbers
    with pytest.raises(FileFormatError, match="4 phases, the schedule 3"):
        reopened(other, numbers, robot_of(plan()), "x")


def test_a_draft_is_refused():
    draft = replace(plan(), refinement=None)
    with pytest.raises(InputError, match="draft; expected one of the whole body"):
        stored(draft)
