"""The stretch of a motion that was repaired, as it was, in the plan's frame and time."""

import numpy as np
import pytest

from llsrbm.certificate import Certificate
from llsrbm.mechanics import quaternion_product, quaternions_about_z, turns_about_z
from llsrbm.repairing.before import motion_before
from llsrbm.repairing.phases import ContactPhase
from llsrbm.repairing.result import Repair
from tests.llsrbm.repairing.foreign import jump, of_states

YAW, AWAY, SUNK, WAITS = 2.0, np.array([3.0, -1.0, 0.0]), -0.03, 40
LEGS = ("FL", "FR", "RL", "RR")


def elsewhere():
    """The jump with a second of standing before it, turned, far away and sunk."""
    qpos = jump(40.0).qpos.copy()
    qpos[:, :3] = qpos[:, :3] @ turns_about_z(YAW).T + AWAY + [0.0, 0.0, SUNK]
    turn = np.broadcast_to(quaternions_about_z(YAW), (len(qpos), 4))
    qpos[:, 3:7] = quaternion_product(turn, qpos[:, 3:7])
    qpos = np.concatenate([np.repeat(qpos[:1], WAITS, axis=0), qpos])
    return of_states(np.arange(len(qpos)) / 40.0, qpos)


def test_it_is_where_the_plan_is_but_as_high_as_in_its_file():
    motion, own = elsewhere(), jump(40.0)
    phases = ContactPhase("take-off", LEGS, 1.0, 1.5), ContactPhase("flight", (), 1.5, 2.0)
    found = motion_before(
        motion,
        Repair("repaired", Certificate(()), None, None, phases, None, YAW, (*AWAY[:2], SUNK)),
    )
    count = len(found.time)
    assert found.time[[0, -1]] == pytest.approx([0.0, 1.0])
    sunk = own.base_position[:count] + np.array([0.0, 0.0, SUNK])
    assert found.base_position == pytest.approx(sunk, abs=1e-9)
    assert found.joint_position == pytest.approx(own.joint_position[:count])
    assert np.abs(np.sum(found.base_quat * own.base_quat[:count], axis=1)) == pytest.approx(1.0)
    turned = motion.angular_velocity[WAITS:][:count] @ turns_about_z(YAW)
    assert found.angular_velocity == pytest.approx(turned, abs=1e-9)
    moved = motion.base_velocity[WAITS:][:count] @ turns_about_z(YAW)
    assert found.base_velocity == pytest.approx(moved, abs=1e-9)


def test_without_phases_there_is_none():
    with pytest.raises(ValueError, match="phases: expected those of the jump"):
        motion_before(jump(), Repair("failed", Certificate(())))
