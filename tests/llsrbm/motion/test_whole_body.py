"""Motions of the whole robot: from rollouts at their own ticks; forces on soles."""

from __future__ import annotations

import numpy as np
import pytest

from llsrbm.jump import Jump
from llsrbm.motion.whole_body import motion_at_ticks, resultants
from tests.app.synthetic_plan import synthetic_plan
from tests.llsrbm.synthetic_rollout import synthetic_rollout


def test_a_rollouts_own_ticks_are_taken_as_they_are():
    rollout = synthetic_rollout(synthetic_plan(Jump(twist=np.pi)))
    ticks = np.array([0, 3, 200, len(rollout.time) - 1])
    motion = motion_at_ticks(rollout, ticks)
    assert motion.fps is None
    assert motion.time.tolist() == rollout.time[ticks].tolist()
    assert motion.com.tolist() == rollout.com[ticks].tolist()
    assert motion.foot_force.tolist() == rollout.contact_force[ticks].tolist()
    order = [rollout.joint_names.index(name) for name in motion.robot.joint_names]
    assert order != sorted(order)
    assert motion.joint_position.tolist() == rollout.qpos[ticks][:, 7:][:, order].tolist()
    assert motion.qvel[:, 3:6] == pytest.approx(rollout.qvel[ticks][:, 3:6])


def test_the_force_on_a_sole_acts_at_its_centre_of_pressure():
    """It turns the sole about no horizontal axis there, as the corners' forces together do not."""
    corners = np.array([[0.07, 0.04, 0], [0.07, -0.04, 0], [-0.07, 0.04, 0], [-0.07, -0.04, 0.0]])
    points = (np.array([[0.0, 0.2, 0.3], [0.1, -0.2, 0.3]])[:, None] + corners).reshape(1, 8, 3)
    forces = np.random.default_rng(3).uniform([-9, -9, 1], [9, 9, 90], (1, 8, 3))
    total, at = resultants(points, forces, 2)
    for foot in range(2):
        own = slice(4 * foot, 4 * foot + 4)
        assert total[0, foot] == pytest.approx(forces[0, own].sum(axis=0))
        moment = np.cross(points[0, own] - at[0, foot], forces[0, own]).sum(axis=0)
        assert moment[:2] == pytest.approx([0, 0], abs=1e-9)
    total, at = resultants(points, np.zeros_like(forces), 2)
    assert total == pytest.approx(0)
    assert at[0] == pytest.approx(np.array([[0.0, 0.2, 0.3], [0.1, -0.2, 0.3]]))
