"""Parts that can be pointed at lie on the drawn robot."""

from itertools import pairwise

import numpy as np
import pytest

from app.picture.parts import TRUNK, foot_name, parts_of
from llsrbm.look.visuals import default_pose
from llsrbm.mechanics import rotation_matrices
from llsrbm.robots import load_robot


@pytest.mark.parametrize("name", ["anymal", "slider"])
def test_feet_joints_and_the_trunk_are_parts(name):
    robot = load_robot(name)
    bodies = {f"/links/{body}": body for body in range(robot.model.njoints - 1)}
    parts = {part.name: part for part in parts_of(robot, bodies)}
    legs = {foot_name(leg.name) for leg in robot.legs}
    assert set(parts) == {TRUNK, *legs, *(joint for leg in robot.legs for joint in leg.joints)}
    position, wxyz = default_pose(robot)
    turn = rotation_matrices(wxyz)

    def place(part, end):
        body = bodies[part.node]
        return position[body] + turn[body] @ np.array(end)

    for leg, foot in zip(robot.legs, robot.feet, strict=True):
        assert place(parts[foot_name(leg.name)], parts[foot_name(leg.name)].end) == pytest.approx(
            foot, abs=0.03
        )
        # Each link ends where the next one begins, unless that one slides.
        chain = [
            (parts[inner], parts[outer])
            for inner, outer in pairwise(leg.joints)
            if outer not in robot.sliding_joints
        ]
        for inner, outer in chain:
            assert place(inner, inner.end) == pytest.approx(place(outer, outer.start), abs=1e-3)


def test_what_is_not_drawn_cannot_be_pointed_at():
    assert [part.name for part in parts_of(load_robot("anymal"), {"/links/base": 0})] == [TRUNK]
