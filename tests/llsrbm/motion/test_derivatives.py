"""Velocities out of positions, against motions whose velocities are known."""

import mujoco
import numpy as np
import pytest

from llsrbm.motion.derivatives import velocities


def turning(time):
    """qpos and qvel of a body that turns about all axes, in MuJoCo's convention."""
    model = mujoco.MjModel.from_xml_string(
        "<mujoco><worldbody><body><freejoint/><geom size='1'/></body></worldbody></mujoco>"
    )
    qvel = np.stack(
        [time, np.cos(time), 2 + 0 * time, np.sin(time), 3 * np.cos(2 * time), 1 - time], axis=1
    )
    fine = 400
    qpos, path = np.array([0, 0, 0, 1.0, 0, 0, 0]), []
    for k, t in enumerate(time):
        path.append(qpos.copy())
        if k + 1 < len(time):
            h = (time[k + 1] - t) / fine
            for i in range(fine):
                at = t + (i + 0.5) * h
                v = [at, np.cos(at), 2, np.sin(at), 3 * np.cos(2 * at), 1 - at]
                mujoco.mj_integratePos(model, qpos, np.array(v, dtype=float), h)
    return np.array(path), qvel


@pytest.mark.parametrize("even", [True, False])
def test_of_the_second_order(even):
    errors = []
    for count in (21, 41):
        time = np.linspace(0, 1, count)
        time = time if even else time + 0.05 * np.sin(2 * np.pi * time)
        qpos, qvel = turning(time)
        errors.append(np.abs(velocities(time, qpos) - qvel).max())
    assert errors[1] < errors[0] / 3.5
    assert errors[1] < 0.01


def test_signs_of_quaternions_do_not_matter():
    time = np.linspace(0, 1, 21)
    qpos, _ = turning(time)
    flipped = qpos.copy()
    flipped[::2, 3:7] *= -1
    np.testing.assert_allclose(velocities(time, flipped), velocities(time, qpos), atol=1e-12)


def test_two_instants():
    qpos = np.zeros((2, 8))
    qpos[:, 3] = 1
    qpos[1, [0, 7]] = 1, 2
    np.testing.assert_allclose(velocities(np.array([0, 0.5]), qpos)[:, [0, 6]], [[2, 4]] * 2)
