"""Arms in the certificate: their stops, speeds and torques, and what they come near to."""

import re
from dataclasses import replace

import numpy as np
import pytest

from llsrbm.certificate import certify
from llsrbm.motion.whole_body import motion_of_states
from llsrbm.robots import load_robot

ROBOT = load_robot("g1")
TIME = np.linspace(0.0, 0.05, 6)


def at_rest(**angles):
    """G1 in its default posture but for some joints, without contacts or forces."""
    q = ROBOT.posture
    joints = q[7:].copy()
    for name, angle in angles.items():
        joints[ROBOT.joint_names.index(f"{name}_joint")] = angle
    qpos = np.concatenate([q[:3], q[[6, 3, 4, 5]], joints])
    still = np.zeros((len(TIME), len(q) - 1))
    return motion_of_states(ROBOT, "hand", TIME, np.tile(qpos, (len(TIME), 1)), still)


def test_as_they_hang_they_touch_nothing():
    found = certify(at_rest())
    assert found["joint_position"].holds
    assert found["self_distance"].holds


def test_the_stops_of_an_elbow():
    low, high = ROBOT.joint_stops[:, ROBOT.joint_names.index("right_elbow_joint")]
    found = certify(at_rest(right_elbow=high + 0.02 * (high - low)))["joint_position"]
    assert (found.where, found.holds) == ("right_elbow_joint", False)
    assert found.worst == pytest.approx(1.02)


def test_the_speed_and_torque_of_a_shoulder():
    motion = at_rest()
    shoulder = ROBOT.joint_names.index("left_shoulder_roll_joint")
    speeds, torques = np.zeros((2, len(TIME), len(ROBOT.joint_names)))
    speeds[:, shoulder], torques[:, shoulder] = -1.1 * 37.0, 1.2 * 25.0
    found = certify(replace(motion, joint_velocity=speeds, joint_torque=torques))
    for name, share in {"joint_speed": 1.1, "joint_torque": 1.2}.items():
        assert (found[name].where, found[name].holds) == ("left_shoulder_roll_joint", False)
        assert found[name].worst == pytest.approx(share)


@pytest.mark.parametrize(
    ("angles", "parts"),
    [
        ({"left_shoulder_roll": -0.4}, ("left_(shoulder|elbow|wrist)", "torso|pelvis|hip")),
        (
            {"right_hip_pitch": -1.8, "right_shoulder_roll": 0.0, "right_elbow": 0.9},
            ("right_(elbow|wrist)", "right_(hip|knee)"),
        ),
        (
            {
                **{f"{side}_shoulder_pitch": -0.5 for side in ("left", "right")},
                **{f"{side}_elbow": 0.0 for side in ("left", "right")},
                "left_shoulder_yaw": -0.9,
                "right_shoulder_yaw": 0.9,
            },
            ("left_(elbow|wrist)", "right_(elbow|wrist)"),
        ),
    ],
)
def test_arms_against_trunk_thighs_and_each_other(angles, parts):
    found = certify(at_rest(**angles))["self_distance"]
    assert found.holds is False
    assert all(re.search(part, found.where) for part in parts), found.where
