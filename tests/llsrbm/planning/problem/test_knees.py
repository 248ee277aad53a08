"""Knees over what legs stand on, and legs side by side: by Pinocchio, and by the links' shapes."""

from dataclasses import replace
from functools import cache

import coal
import numpy as np
import pinocchio as pin
import pytest

from llsrbm.body.knee_room import knee_room, knee_width
from llsrbm.body.trunk_and_knees import knee_joint
from llsrbm.planning.answer.planner import planner_for
from llsrbm.planning.problem.constraints.knees import KneeHeight
from llsrbm.planning.solve.jump_layout import layout_of
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot
from llsrbm.robots.link_shapes import LinkShapes

# Without the rows the knee of ANYmal's left hind leg comes to 67 mm above the box.
JUMP = Jump(robot="anymal", twist=1.07, forward=-0.22, lateral=-0.07, height=0.27)


MARGIN = load_robot("anymal").file.limits.knee_margin


@cache
def planned(margin):
    planner = planner_for("anymal", "llsrbm-plus")
    return planner.plan(JUMP, limits={"knee_margin": margin}, patient=False)


def lowest_knee(plan, robot):
    """(m) above the landing surface from touchdown on."""
    data, landing = robot.model.createData(), np.flatnonzero(plan.phase == plan.phase[-1])[:-1]
    heights = []
    for k in landing:
        q = np.concatenate(
            [plan.base_position[k], np.roll(plan.base_quat[k], -1), plan.joint_position[k]]
        )
        pin.forwardKinematics(robot.model, data, q)
        ids = [leg.joint_ids[knee_joint(robot)] for leg in robot.legs]
        heights += [data.oMi[joint].translation[2] - JUMP.height for joint in ids]
    return min(heights)


def test_knees_keep_their_margin_over_a_box():
    robot = load_robot("anymal")
    room = knee_room(robot)
    assert lowest_knee(planned(0.0), robot) < room + MARGIN - 0.02  # the rows are needed
    # The model puts the base a few millimetres off.
    assert lowest_knee(planned(MARGIN), robot) > room + MARGIN - 5e-3


@pytest.mark.parametrize("name", ["anymal", "go2"])
def test_a_thigh_touches_what_is_as_far_below_its_knee_as_it_is_thick(name):
    """A level surface below the knees of the default posture, by the shapes of thighs alone."""
    robot = load_robot(name)
    data = robot.model.createData()
    pin.forwardKinematics(robot.model, data, robot.posture)
    joint = knee_joint(robot)
    knee = min(data.oMi[leg.joint_ids[joint]].translation[2] for leg in robot.legs)
    shapes = LinkShapes.of(robot)
    thighs = {leg.joint_ids[joint - 1] for leg in robot.legs}
    floor = coal.Halfspace(np.array([0.0, 0.0, 1.0]), knee - knee_room(robot))
    least = np.inf
    for shape in shapes.shapes:
        if shape.joint not in thighs:
            continue
        place = data.oMi[shape.joint] * pin.SE3(shape.rotation, shape.centre)
        here = coal.Transform3s(place.rotation, place.translation)
        request, result = coal.DistanceRequest(), coal.DistanceResult()
        least = min(
            least, coal.distance(shape.geometry(), here, floor, coal.Transform3s(), request, result)
        )
    assert -1e-3 < least < 0.02  # directions 10 degrees apart


@pytest.mark.parametrize(("kind", "pushes"), [("flip", True), ("rear-last", False)])
def test_legs_on_which_a_body_leans_keep_their_knees_up(kind, pushes):
    turn = {"pitch": -2 * np.pi} if kind == "flip" else {"forward": 0.3}
    roles = layout_of(Jump(robot="go2", type=kind, **turn), load_robot("go2")).roles
    push = [role for role in roles if role.phase == 1]
    assert all(len(role.standing) == 2 for role in push)
    assert [KneeHeight().applies(role) for role in push] == [pushes] * len(push)


def test_robots_without_knees_have_no_such_limit():
    assert knee_room(load_robot("slider")) == 0.0


def test_legs_side_by_side_do_not_meet_in_flight():
    """Without the rows the hind thighs of this jump were 32 mm inside each other."""
    robot = load_robot("go2")
    jump = Jump(robot="go2", twist=-1.59, forward=0.47, lateral=-0.29)
    plan = planner_for("go2", "llsrbm-plus").plan(jump, patient=False)
    q = np.hstack([plan.base_position, np.roll(plan.base_quat, -1, axis=1), plan.joint_position])
    legs, thighs_and_shanks = LinkShapes.of(robot), ("thigh", "calf", "foot")
    mine = [
        k
        for k, pair in enumerate(legs.pairs)
        if all(name.endswith(thighs_and_shanks) for name in pair)
        and {name[1] for name in pair} == {"L", "R"}
    ]
    assert mine
    nearest = min(legs.distances(posture)[mine].min() for posture in q)
    assert nearest > 0.005
    # Knees and feet by Pinocchio, base axes.
    data, joint, apart = robot.model.createData(), knee_joint(robot), []
    for posture in q[plan.phase == 1]:
        pin.framesForwardKinematics(robot.model, data, posture)
        to_base = data.oMi[1].inverse()
        for i, j in ((0, 1), (2, 3)):
            pair = robot.legs[i], robot.legs[j]
            knees = [to_base.act(data.oMi[leg.joint_ids[joint]].translation)[1] for leg in pair]
            feet = [to_base.act(data.oMf[leg.foot_frame_id].translation)[1] for leg in pair]
            apart += [knees[0] - knees[1], feet[0] - feet[1]]
    least = 2 * knee_width(robot) + robot.file.limits.legs_apart
    assert least - 5e-3 < min(apart) < least + 5e-3


def test_a_leg_in_the_middle_has_none_beside_it_to_keep_from():
    """A three-legged robot's rear leg: a direction of nothing made it 10 m wide."""
    robot = load_robot("anymal")
    three = replace(robot)
    three.__dict__["hips"] = robot.hips * np.array([[1, 1, 1], [1, 1, 1], [1, 0, 1], [1, 0, 1]])
    assert 0 < knee_width(three) < 0.2
