"""Jumps that cannot be meant are refused in a sentence, before any motion is sought."""

import numpy as np
import pytest

import llsrbm
from llsrbm.mechanics import quaternion_product, quaternions_about_z
from llsrbm.repairing import repair as repair_module
from tests.llsrbm.repairing.foreign import jump, of_states

LIFT, LAND = 0.7, 1.05  # s, about, of the jump that comes with the project


def _turned_twice(qpos, at):
    turn = quaternions_about_z(np.interp(at, [LIFT, LAND], [0.0, 4 * np.pi]))
    qpos[:, 3:7] = quaternion_product(turn, qpos[:, 3:7])


def _in_another_order(qpos, at):
    qpos[:, 7:] = qpos[:, 7:].reshape(-1, 4, 3)[..., [2, 0, 1]].reshape(-1, 12)


def _far_away(qpos, at):
    qpos[:, 0] += np.interp(at, [LIFT, LAND], [0.0, 5.0])


def _upside_down(qpos, at):
    qpos[:, 3:7] = qpos[:, [4, 3, 6, 5]] * [-1.0, 1.0, -1.0, 1.0]


@pytest.mark.parametrize(
    ("made", "why"),
    [
        (_turned_twice, "A flight turns the robot by 8"),
        (_in_another_order, "FR_calf_joint is at 0.8"),
        (_far_away, "A flight leads 4."),
        (_upside_down, "The body is upside down as the jump begins."),
    ],
)
def test_it_is_said_at_once_why_there_is_no_motion_near_it(made, why, monkeypatch):
    monkeypatch.setattr(repair_module, "nearest", lambda *_: pytest.fail("it was sought"))
    motion = jump()
    qpos = motion.qpos.copy()
    made(qpos, motion.time)
    found = llsrbm.repair(of_states(motion.time, qpos))
    assert found.status == "failed"
    assert found.why.startswith(why)
