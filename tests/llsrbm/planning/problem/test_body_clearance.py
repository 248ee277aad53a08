"""Trunk, knees and feet over hurdles and gaps, against differences and Pinocchio."""

from dataclasses import replace
from functools import cache

import casadi as ca
import numpy as np
import pinocchio as pin
import pytest

from llsrbm.body.trunk_and_knees import trunk_box
from llsrbm.errors import InputError
from llsrbm.models import make_model
from llsrbm.ocp.derivatives import Derivatives
from llsrbm.planning.problem.clearance_profile import (
    RAMP,
    clearance_parameters,
    foot_reach,
    profile,
)
from llsrbm.planning.problem.constraints.body_clearance import BodyClearance, body_points
from llsrbm.planning.problem.knots import unpack
from llsrbm.planning.problem.parameters import parameter_symbols, parameters
from llsrbm.planning.problem.placement import make_task
from llsrbm.planning.problem.stage import Stage
from llsrbm.planning.solve.guess import analytic_guess
from llsrbm.planning.solve.jump_layout import layout_of
from llsrbm.request.jump import Jump
from llsrbm.request.obstacle import Obstacle
from llsrbm.robots import load_robot
from tests.llsrbm.planning.solved import changed, solved, variable

ROBOTS = ("anymal", "go2")
HURDLE = {"type": "hurdle", "forward": 0.38}


@cache
def case(name, **jump):
    """Task, layout, model and the analytic guess as knots."""
    robot = load_robot(name)
    jump = Jump(robot=name, **(jump or HURDLE))
    task, layout = make_task(jump, robot), layout_of(jump, robot, 12)
    model = make_model("llsrbm-plus", robot)
    w = analytic_guess(task, layout, model)
    return task, layout, model, w, unpack(w, layout, task, model)


def rows_at(name, knot):
    """The rows and their slope as functions of a stage's variables, with the task's numbers."""
    task, layout, model, w, _ = case(name)
    symbols = parameter_symbols(layout)
    stage = Stage(layout.roles[knot], layout, model, symbols)
    rows = BodyClearance().rows(stage)
    numbers = [stage.local, *symbols.values()]
    slopes = Derivatives("rows", stage.lift, numbers, rows)
    _, slope = slopes.jacobian(stage.variables, *numbers)
    inputs = [stage.variables, *numbers]
    evaluate = ca.Function("rows", inputs, [stage.lift.resolve(rows), slope])
    values = parameters(layout, task)
    phase = int(layout.phase[knot])
    names = [f"phase{phase}_{n}" for n in ("feet", "contacts", "yaw", "towards", "tilt")]
    local = np.concatenate([values[n] for n in names])
    here = np.concatenate([w[place] for place in layout.variables(knot).values()])

    def at(variables):
        found = evaluate(variables, local, *values.values())
        return [np.array(part) for part in found]

    return here, at


def over(point, of, room, heights=None):
    heights = of["obstacle_heights"] if heights is None else heights
    return point[2] - float(profile(point[0], of["obstacle"], heights, room))


@pytest.mark.parametrize("name", ROBOTS)
def test_rows_are_heights_over_the_profile(name):
    """Against the whole body by Pinocchio: the model puts it half a centimetre off at most."""
    task, layout, _, _, knots = case(name)
    trunk, knees, shins = body_points(knots)
    of = clearance_parameters(task)
    trunk = trunk[:, [s * 4 + c for s in (0, 6, 12) for c in range(4)]]
    for knot in (3, 5, 6, 9):
        variables, rows = rows_at(name, knot)
        found = rows(variables)[0][:, 0]
        low, top, beyond = of["obstacle_heights"]
        margin, (trunk_room, leg_room, _) = task.body_margin, of["obstacle_room"]
        raised = (low, top + margin, beyond)
        # Of each leg two points of those at 0.2, 0.4, 0.6 and 0.8 of the way, and between them.
        at = shins[knot].reshape(4, -1, 3)
        thirds = (at[0] / 3 + at[1] * 2 / 3, at[2] * 2 / 3 + at[3] / 3)
        expected = [over(p, of, trunk_room) - margin for p in trunk[knot]]
        for knee, *points in zip(knees[knot], *thirds, strict=True):
            expected.append(over(knee, of, leg_room) - margin)
            expected += [over(p, of, leg_room, raised) for p in points]
        count = len(expected)
        np.testing.assert_allclose(found[:count], expected, atol=0.006)
        role = layout.roles[knot]
        feet = len(role.flying) + len(role.swinging)
        assert len(found) == count + feet == len(BodyClearance().bounds(task, layout, knot)[0])


def test_the_profile_covers_the_obstacle():
    for low, top, beyond in ((0, 0.12, 0), (0, 0.2, 0.1), (0, 0, -0.2)):
        x = np.linspace(-0.5, 1, 301)
        z = np.array([float(profile(a, (0.2, 0.3), (low, top, beyond), 0.03)) for a in x])
        over = (x > 0.17) & (x < 0.33)
        np.testing.assert_allclose(z[over], top)
        np.testing.assert_allclose(z[x < 0.17 - RAMP], low)
        np.testing.assert_allclose(z[x > 0.33 + RAMP], beyond)


def lowest(knots, near, far):
    """m: of trunk, knees and shins over a stretch of the ground, at inner knots, by Pinocchio."""
    robot, postures = knots.task.robot, knots.postures
    data, (low, high) = robot.model.createData(), trunk_box(robot)
    found = np.inf
    for k in range(1, len(knots.time) - 1):
        base = np.concatenate([postures.base_position[k], np.roll(knots.quat[k], -1)])
        q = np.concatenate([base, postures.joint_position[k]])
        pin.framesForwardKinematics(robot.model, data, q)
        points = [
            data.oMi[1].act(np.array([x, y, z]))
            for x in np.linspace(low[0], high[0], 60)
            for y in (low[1], high[1])
            for z in (low[2], high[2])
        ]
        for leg in robot.legs:
            knee, foot = data.oMi[leg.joint_ids[2]], data.oMf[leg.foot_frame_id]
            points += [
                knee.translation + share * (foot.translation - knee.translation)
                for share in (0, 0.2, 0.4, 0.6, 0.8)
            ]
        found = min([found, *(z for x, _, z in points if near < x < far)])
    return found


@pytest.mark.parametrize("name", ROBOTS)
def test_the_check_is_about_the_whole_body(name):
    """A hurdle below the trunk, where no foot passes, is raised until something touches it."""
    task, _, _, _, knots = case(name, type="hurdle")
    near, far = task.robot.feet[:, 0].min() + 0.1, task.robot.feet[:, 0].max() - 0.1
    clear = lowest(knots, near, far)
    assert clear > 0.1

    def violation(height):
        over = replace(task, obstacle=Obstacle(near, far, height), body_margin=0.0)
        return BodyClearance().violation(knots.under(over)).max()

    assert violation(clear - 0.01) == 0
    assert violation(clear + 0.02) > 0.005


def test_the_ground_is_something_to_clear():
    task, _, _, _, knots = case("anymal")
    low = lowest(knots, -9, 9)  # of a knee's shin, near the foot
    body = np.concatenate(body_points(knots)[:2], axis=1)[1:-1]
    assert low < body[..., 2].min() < 0.3
    # Of the margin 3 cm are allowed to be missing, for comparison 5.
    for name, allowance in (("llsrbm-plus", 0.03), ("llsrbm", 0.05)):
        judged = replace(knots, model=make_model(name, task.robot))
        for beyond in (-0.005, 0.005):
            margin = body[..., 2].min() + allowance + beyond
            on_the_ground = replace(task, obstacle=None, body_margin=margin)
            found = BodyClearance().violation(judged.under(on_the_ground))
            assert found.max() == pytest.approx(max(beyond, 0.0))


class TestFooting:
    def test_on_a_hurdle(self):
        with pytest.raises(InputError, match=r"obstacle: after jump 1 the LF foot would stand at"):
            make_task(Jump(type="hurdle", forward=0.15), load_robot("anymal"))

    def test_two_heights_on_one_side(self):
        with pytest.raises(InputError, match=r"height of 0.1 m, before the hurdle, .* at 0 m; exp"):
            make_task(Jump(type="hurdle", forward=0.45, height=0.1), load_robot("anymal"))

    def test_beside_it(self):
        task = make_task(Jump(type="gap", forward=0.45), load_robot("go2"))
        front = task.places[0].contacts[:, 0].max()
        assert task.obstacle.near == pytest.approx(front + 0.15)
        assert task.obstacle.near - front > foot_reach(task.robot) + RAMP


def test_soles_are_longer_than_points():
    jump = Jump("slider", type="hurdle", forward=0.46)
    task = make_task(jump, load_robot("slider"))
    assert foot_reach(task.robot) == pytest.approx(np.hypot(0.072, 0.039) + 0.01)
    heel = task.places[-1].contacts[:, 0].min()
    assert heel > task.obstacle.far + 0.01 + RAMP
    with pytest.raises(InputError, match=r"would stand at 0.430 m, but the hurdle goes from"):
        make_task(replace(jump, forward=0.43), load_robot("slider"))


@pytest.mark.nightly
@pytest.mark.parametrize("height", [0.0, -0.4])
def test_a_body_that_turns_over_keeps_off_what_it_stands_on(height):
    """On a block its nose is above the block, not just above the floor."""
    knots = solved("llsrbm-plus", "flip", "go2").knots
    jump = replace(knots.task.jump, height=height)
    knots = replace(knots, task=make_task(jump, knots.task.robot))
    taking_off = np.flatnonzero(knots.phase == 0)
    assert BodyClearance().violation(knots)[taking_off].max() == 0.0
    knot = 3
    lower = variable(knots, "position", knot) - [0.0, 0.0, 0.35]
    low = BodyClearance().violation(changed(knots, ("position", knot, lower)))[taking_off]
    assert np.flatnonzero(low).tolist() == [knot]
    assert 0.0 < low[knot] < 0.35
