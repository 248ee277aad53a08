"""Images in a mirror: against Pinocchio's kinematics and dynamics, and twice is the same motion."""

import numpy as np
import pinocchio as pin
import pytest

from llsrbm.errors import InputError
from llsrbm.library.library import checked
from llsrbm.library.mirror import mirrored, mirrored_jump, sides_of
from llsrbm.library.stored import reopened
from llsrbm.motion.robot import robot_of
from llsrbm.request.jump import Jump
from llsrbm.request.route import Landing
from llsrbm.request.stones import Stone
from llsrbm.robots import load_robot
from tests.llsrbm.library.shipped_motions import card, library, plan

MIRROR = np.array([1.0, -1.0, 1.0])
ROBOTS = ("go2", "anymal", "slider", "g1")


@pytest.mark.parametrize("name", ROBOTS)
def test_feet_of_mirrored_joints_are_mirrored(name):
    robot = load_robot(name)
    sides, model = sides_of(robot), robot.model
    rng = np.random.default_rng(5)
    q = robot.posture.copy()
    q[:7] = pin.neutral(model)[:7]
    q[7:] += rng.uniform(-0.2, 0.2, len(q) - 7)
    image = q.copy()
    image[7:] = sides.signs * q[7:][sides.joints]
    feet = []
    for each in (q, image):
        data = model.createData()
        pin.framesForwardKinematics(model, data, each)
        feet.append(np.array([data.oMf[leg.foot_frame_id].translation for leg in robot.legs]))
    np.testing.assert_allclose(feet[1][sides.legs], feet[0] * MIRROR, atol=5e-3)


@pytest.mark.parametrize("name", ["go2-pirouette-0001", "go2-hops-0001"])
def test_the_image_holds_and_its_image_is_the_motion(name):
    once, of = plan(name), card(name)
    robot = robot_of(once)
    image = checked(mirrored(of, once, robot), robot)
    assert image.card.certified
    assert image.card.figures.turn == pytest.approx(-of.figures.turn, abs=1e-5)
    assert image.card.figures.lateral_m == pytest.approx(-of.figures.lateral_m, abs=1e-5)
    assert image.card.figures.peak_power_w == pytest.approx(of.figures.peak_power_w, rel=0.02)
    other = reopened(image.card, image.numbers, robot, name)
    np.testing.assert_allclose(other.base_position, once.base_position * MIRROR, atol=1e-6)
    np.testing.assert_allclose(other.com, once.com * MIRROR, atol=2e-3)  # links differ a little
    back = mirrored(image.card, other, robot)
    assert back.card.request == of.request
    np.testing.assert_allclose(back.numbers, library().stored(name).numbers, atol=1e-4)


def test_a_motion_that_is_its_own_image_is_refused():
    name = next(each.name for each in library().cards if each.kind == "rear-last")
    with pytest.raises(InputError, match="its own image"):
        mirrored(card(name), plan(name), robot_of(plan(name)))


def test_requests():
    robot = load_robot("go2")
    sides = sides_of(robot)
    jump = Jump(
        robot="go2",
        lateral=0.1,
        twist=-0.5,
        cross_slope=0.1,
        payload=(2.0, 0.1, 0.05, 0.0),
        stones=(Stone("FL", 0.01, 0.02, 0.03),),
    )
    image = mirrored_jump(jump, robot, sides)
    assert (image.lateral, image.twist, image.cross_slope) == (-0.1, 0.5, -0.1)
    assert image.payload == (2.0, 0.1, -0.05, 0.0)
    assert image.stones == (Stone("FR", 0.01, -0.02, 0.03),)
    assert mirrored_jump(image, robot, sides) == jump
    route = Jump(robot="go2", route=(Landing(0.1, 0.05, 0.0, 0.3), Landing(0.2)))
    landing = mirrored_jump(route, robot, sides).route[0]
    assert (landing.lateral, landing.twist) == (-0.05, -0.3)


def test_a_type_that_begins_with_one_side_has_no_image():
    robot = load_robot("slider")
    of = card(next(each.name for each in library().cards if each.robot == "go2"))
    changed = {"request": Jump(robot="slider", type="one-foot-first", twist=0.3)}
    with pytest.raises(InputError, match="no image in a mirror"):
        mirrored(of.model_copy(update=changed), plan(), robot)


def test_a_robot_without_sides_is_refused(monkeypatch):
    robot = load_robot("go2")
    monkeypatch.setattr("llsrbm.library.mirror._SAME_PLACE", -1.0)
    with pytest.raises(InputError, match="FL_hip_joint has no image in a mirror"):
        sides_of(robot)
