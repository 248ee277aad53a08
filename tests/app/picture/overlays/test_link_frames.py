from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from tests.app.picture.overlays.drawn import DrawnOverlay
from tests.app.picture.pictures import picture


@pytest.mark.parametrize("robot", ["anymal", "slider"])
def test_every_link_has_its_axes(robot):
    shown = picture(robot, {"frames"})
    drawn, motion, frame = DrawnOverlay(shown, "/axes"), shown.planned.motion, 40
    model = motion.robot.model
    data = model.createData()
    qpos = motion.qpos[frame]
    q = np.concatenate([qpos[:3], qpos[[4, 5, 6, 3]], qpos[7:]])
    pin.forwardKinematics(model, data, q)
    assert len(drawn.nodes) == model.njoints - 1
    by_number = sorted(drawn.nodes, key=lambda node: int(node.rsplit("/", 1)[1]))
    colours = drawn.mesh(by_number[0]).visual.vertex_colors[:, :3].astype(int)
    for joint, node in enumerate(by_number, start=1):
        points = drawn.vertices(node, frame)
        for axis in range(3):
            of_axis = points[colours.argmax(axis=1) == axis]
            tip = of_axis[
                ((of_axis - data.oMi[joint].translation) @ data.oMi[joint].rotation)[:, axis] > 0.09
            ]
            along = tip.mean(axis=0) - data.oMi[joint].translation
            assert along == pytest.approx(0.1 * data.oMi[joint].rotation[:, axis], abs=1e-3)
