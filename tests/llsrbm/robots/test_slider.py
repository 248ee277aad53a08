"""SLIDER's description against the figures that its makers published, written down here again."""

import itertools

import numpy as np
import pinocchio as pin
import pytest

from llsrbm.robots import load_robot
from llsrbm.robots.feet import foot_contacts

ROLL_AXIS = (-0.065, 0.100)  # x, y from the pelvis' origin
LEG_OUT_OF_ROLL = 0.115  # along y
ANKLE_BELOW_HIP, SOLE_BELOW_ANKLE = 0.6415, 0.045  # at the slide's zero
SOLE = (0.082, 0.049)  # half of its length and width
MASSES = {"roll": 2.367, "pitch": 1.145, "slide": 0.966, "ankle_pitch": 0.014, "ankle_roll": 0.465}
RANGES = {"roll": 0.785, "pitch": 1.57, "slide": 0.40, "ankle_pitch": 0.785, "ankle_roll": 0.785}
EFFORTS = {"roll": 700, "pitch": 300, "slide": 600, "yaw": 60, "ankle_pitch": 50, "ankle_roll": 50}
ORDER = ("roll", "pitch", "slide", "yaw", "ankle_pitch", "ankle_roll")
# Joints about x and z turn the other way on the other side.


@pytest.fixture(scope="module")
def slider():
    return load_robot("slider")


def placed(robot, q):
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, q)
    return data


def joint(robot, side, name):
    return robot.model.getJointId(f"{side}_{name}")


def test_it_weighs_what_the_paper_says(slider):
    assert slider.mass == pytest.approx(16.0, abs=1e-3)
    assert slider.model.inertias[1].mass == pytest.approx(6.08, abs=0.005)
    for side, (name, mass) in itertools.product(("left", "right"), MASSES.items()):
        assert slider.model.inertias[joint(slider, side, name)].mass == pytest.approx(mass)
    # The yaw joint that the paper adds brings next to no mass of its own.
    assert slider.model.inertias[joint(slider, "left", "yaw")].mass < 0.01


def test_links_have_the_published_inertia(slider):
    inertias = slider.model.inertias
    hip, leg, foot = (inertias[joint(slider, "left", n)] for n in ("roll", "slide", "ankle_roll"))
    assert hip.lever == pytest.approx([0.105, -0.021, 0])
    assert leg.lever == pytest.approx([0, 0, 0.405])
    assert foot.lever == pytest.approx([0, 0, -0.028])
    assert np.diag(hip.inertia) == pytest.approx([0.0162, 0.0294, 0.0362])
    assert np.diag(leg.inertia) == pytest.approx([0.0119, 0.0121, 0.0010])
    assert np.diag(foot.inertia)[:2] == pytest.approx([0.0065, 0.0137])
    depth, width, height = 0.16, 0.25, 0.20
    even = [width**2 + height**2, depth**2 + height**2, depth**2 + width**2]
    assert np.diag(inertias[1].inertia) == pytest.approx(6.08 / 12 * np.array(even), abs=1e-5)


def test_joints_are_where_they_were_published(slider):
    data = placed(slider, pin.neutral(slider.model))
    for side, sign in (("left", 1), ("right", -1)):
        leg = next(leg for leg in slider.legs if leg.name == side)
        assert leg.joints == tuple(f"{side}_{name}" for name in ORDER)
        at = {name: data.oMi[joint(slider, side, name)].translation for name in ORDER}
        assert at["roll"] == pytest.approx([ROLL_AXIS[0], sign * ROLL_AXIS[1], 0])
        assert at["pitch"][1] == pytest.approx(sign * (ROLL_AXIS[1] + LEG_OUT_OF_ROLL))
        assert at["pitch"][0] - at["roll"][0] == pytest.approx(0.065)
        for name in ORDER[2:]:
            assert at[name] - at["pitch"] == pytest.approx([0, 0, -ANKLE_BELOW_HIP])
        sole = data.oMf[leg.foot_frame_id].translation
        assert sole - at["ankle_roll"] == pytest.approx([0, 0, -SOLE_BELOW_ANKLE])


def test_positive_slide_draws_the_leg_up(slider):
    q = pin.neutral(slider.model)
    q[slider.legs[0].q_index[2]] = 0.1
    sole = placed(slider, q).oMf[slider.legs[0].foot_frame_id].translation
    assert sole[2] == pytest.approx(0.1 - ANKLE_BELOW_HIP - SOLE_BELOW_ANKLE)


def test_ranges_and_efforts(slider):
    model = slider.model
    for side, name in itertools.product(("left", "right"), ORDER):
        at = model.joints[joint(slider, side, name)]
        low, high = model.lowerPositionLimit[at.idx_q], model.upperPositionLimit[at.idx_q]
        assert low == -high
        assert high == RANGES[name] if name in RANGES else high >= 1.1
        assert model.upperEffortLimit[at.idx_v] == EFFORTS[name]
        assert slider.torque_limit[at.idx_v - 6] == EFFORTS[name]
        assert slider.speed_limit[at.idx_v - 6] == model.upperVelocityLimit[at.idx_v]


def test_it_stands_on_its_soles_below_its_com(slider):
    data = placed(slider, slider.posture)
    for leg, contact in zip(slider.legs, foot_contacts(slider), strict=True):
        frame = data.oMf[leg.foot_frame_id]
        assert frame.rotation == pytest.approx(np.eye(3), abs=1e-9)
        assert frame.translation[2] == pytest.approx(0, abs=1e-9)
        assert frame.translation[0] == pytest.approx(slider.com[0], abs=1e-3)
        lowest = np.array([frame.act(c) for c in contact.centres]) - [0, 0, contact.radius]
        assert lowest[:, 2] == pytest.approx(0, abs=1e-9)
        # Spheres stay within the sole, and hold what the file says.
        assert contact.centres[:, :2] == pytest.approx(slider.corners[:, :2])
        assert (np.abs(contact.centres[:, :2]) + contact.radius <= np.array(SOLE) + 1e-9).all()
        assert len(np.unique(np.sign(contact.centres[:, :2]), axis=0)) == 4
    assert slider.com[2] == pytest.approx(0.60, abs=1e-3)
    slide = slider.posture[[leg.q_index[2] for leg in slider.legs]]
    assert slide == pytest.approx(0, abs=0.05)  # mid-stroke
