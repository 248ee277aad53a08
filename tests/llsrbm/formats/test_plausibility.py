"""Foreign motions in another convention are opened with one remark that names it."""

import json
import re
from typing import ClassVar

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import llsrbm
from llsrbm import library
from llsrbm.certificate import certify
from llsrbm.cli import main
from llsrbm.formats import export
from llsrbm.motion.bodies import urdf_joints
from llsrbm.motion.whole_body import whole_body_motion
from llsrbm.robots import load_robot
from tests.llsrbm.formats.jumps import shipped

FPS = 60
W_FIRST = [6, 3, 4, 5]  # columns of the table, whose quaternions have w last
LEGS_29 = 12


@pytest.fixture(scope="module", params=["anymal", "go2", "g1", "slider"])
def clip(request, tmp_path_factory):
    """A robot, its table's rows and its joints: a jump that was planned."""
    path = tmp_path_factory.mktemp("clip") / "jump.csv"
    export(shipped(request.param), path, format="unitree-csv", fps=FPS)
    joints = json.loads(path.with_name("jump.csv.meta.json").read_text())["joint_order"]
    return request.param, np.loadtxt(path, delimiter=","), joints


def opened(clip, folder, rows, fps=FPS, **beside):
    np.savetxt(folder / "x.csv", rows, delimiter=",")
    if beside:
        (folder / "x.csv.meta.json").write_text(json.dumps(beside))
    return llsrbm.load_motion(folder / "x.csv", robot=clip[0], fps=fps)


def w_first(rows, robot):
    rows[:, 3:7] = rows[:, W_FIRST]


def degrees(rows, robot):
    turning = [name not in robot.sliding_joints for name in urdf_joints(robot).joints]
    rows[:, 7:] = np.where(turning, np.degrees(rows[:, 7:]), rows[:, 7:])


def centimetres(rows, robot):
    rows[:, :3] *= 100


def millimetres(rows, robot):
    rows[:, :3] *= 1000


def y_up(rows, robot):
    turn = Rotation.from_euler("x", -90, degrees=True)
    rows[:, :3] = turn.apply(rows[:, :3])
    rows[:, 3:7] = (turn * Rotation.from_quat(rows[:, 3:7])).as_quat()


def upside_down(rows, robot):
    rows[:, 3:7] = (Rotation.from_quat(rows[:, 3:7]) * Rotation.from_euler("x", np.pi)).as_quat()


def under_the_ground(rows, robot):
    rows[:, 2] -= robot.posture[2]


def not_normalised(rows, robot):
    rows[:, 3:7] *= 1.004


def sign_flips(rows, robot):
    rows[20:40, 3:7] *= -1


MISTAKES = {
    w_first: r"^The robot is (upside down in every frame|not upright): is w first in",
    degrees: r"^Joints are at up to \d+(\.\d+)? rad: are they in degrees\?",
    centimetres: r"^The root is \d+\.?\d* m high, .* is it in centimetres\?",
    millimetres: r"^The root is [\d.e+]+ m high, .* is it in millimetres\?",
    y_up: "^The robot's vertical is along y in every frame: is y up in the file?",
    upside_down: "^The robot is upside down in every frame",
    under_the_ground: r"^The feet are \d\.?\d* m under the ground",
    not_normalised: r"^Its quaternions have norms up to 1\.004",
    sign_flips: r"^Its quaternions change sign 2 times, first after frame 19",
}


def test_a_sound_motion_has_no_remark(clip, tmp_path):
    assert opened(clip, tmp_path, clip[1]).remarks == ()


@pytest.mark.parametrize("mistake", MISTAKES, ids=lambda each: each.__name__)
def test_one_remark_names_the_mistake(clip, tmp_path, mistake):
    rows = clip[1].copy()
    mistake(rows, load_robot(clip[0]))
    (said,) = opened(clip, tmp_path, rows).remarks
    assert re.match(MISTAKES[mistake], said), said
    assert said.isprintable()


def test_joints_in_another_order(clip, tmp_path):
    rows = clip[1].copy()
    rows[:, 7:] = np.roll(rows[:, 7:], 1, axis=1)
    said = opened(clip, tmp_path, rows).remarks
    if clip[0] == "go2":  # the stops of others are wide, or their joints near zero
        assert any("are the joints in another order?" in each for each in said)


@pytest.mark.parametrize(("fps", "said"), [(1.5, "is its time in ms"), (9000, "rate wrong")])
def test_a_rate_that_is_absurd(clip, tmp_path, fps, said):
    assert said in opened(clip, tmp_path, clip[1], fps).remarks[0]


def test_a_time_in_ms_is_refused_as_its_check_would_take_an_hour(tmp_path):
    states = whole_body_motion(shipped("go2"), FPS)
    np.savez(tmp_path / "x.npz", qpos=states.qpos, time=1000 * states.time + 1.7e12)
    with pytest.raises(llsrbm.InputError, match=r"with 0.06 frames per second; .* time in ms"):
        llsrbm.load_motion(tmp_path / "x.npz", "go2")


def test_a_motion_of_half_an_hour_is_refused(tmp_path):
    states = whole_body_motion(shipped("go2"), FPS).qpos[:1].repeat(2400, axis=0)
    np.savez(tmp_path / "x.npz", qpos=states, fps=1.2)
    with pytest.raises(llsrbm.InputError, match=r"lasts 1999 s .* at most 1000 s"):
        llsrbm.load_motion(tmp_path / "x.npz", "go2")


@pytest.mark.parametrize("key", ["joint_vel", "body_lin_vel_w", "body_ang_vel_w"])
def test_velocities_that_are_no_derivative(tmp_path, key):
    export(shipped("go2"), tmp_path / "x.npz", format="motion-npz", fps=100)
    assert llsrbm.load_motion(tmp_path / "x.npz", "go2").remarks == ()
    arrays = dict(np.load(tmp_path / "x.npz"))
    arrays[key] = np.degrees(arrays[key])
    np.savez(tmp_path / "x.npz", **arrays)
    (said,) = llsrbm.load_motion(tmp_path / "x.npz", "go2").remarks
    assert "velocities are no derivatives of the positions" in said


def test_w_last_where_w_comes_first(tmp_path):
    export(shipped("go2"), tmp_path / "x.npz", format="motion-npz")
    arrays = dict(np.load(tmp_path / "x.npz"))
    arrays["body_quat_w"] = arrays["body_quat_w"][..., [1, 2, 3, 0]]
    np.savez(tmp_path / "x.npz", **arrays)
    first, *_ = llsrbm.load_motion(tmp_path / "x.npz", "go2").remarks
    assert "is w last in its quaternions?" in first


@pytest.mark.parametrize("yaw", [0.0, np.pi])
def test_w_last_of_a_robot_that_hardly_turns(tmp_path, yaw):
    states = whole_body_motion(library.shipped().open("go2-together-0001", check=False), FPS)
    heading = Rotation.from_euler("z", yaw)
    quat = heading * Rotation.from_quat(states.base_quat, scalar_first=True)
    place = heading.apply(states.base_position)
    for w_first in (True, False):
        rows = np.hstack([place, quat.as_quat(scalar_first=w_first), states.joint_position])
        np.savez(tmp_path / "x.npz", qpos=rows, fps=FPS)
        remarks = llsrbm.load_motion(tmp_path / "x.npz", "go2").remarks
        # One that looks backward is upside down then.
        assert any("is w last in its quaternions?" in each for each in remarks) != w_first


def test_commands_print_them(clip, tmp_path, capfd):
    if clip[0] != "go2":
        pytest.skip("one robot is enough")
    rows = clip[1].copy()
    centimetres(rows, None)
    np.savetxt(tmp_path / "x.csv", rows, delimiter=",")
    for command in ("check", "compare"):
        main([command, str(tmp_path / "x.csv"), "--robot", "go2", "--fps", "60", "--json"])
        out, err = capfd.readouterr()
        assert err.count("\n") == 1
        assert "is it in centimetres?" in err
        assert json.loads(out)


class TestG1:
    """Clips as Unitree's training code ships them: 23 and 27 of 29 joints, 60 frames/s."""

    @pytest.fixture
    def whole(self, tmp_path_factory):
        path = tmp_path_factory.mktemp("g1") / "jump.csv"
        export(shipped("g1"), path, format="unitree-csv", fps=60)
        return np.loadtxt(path, delimiter=",")

    # By the published lists: legs, waist yaw, then arms with or without two joints of the wrist.
    KEPT: ClassVar = {
        23: [*range(13), *range(15, 20), *range(22, 27)],
        27: [*range(13), *range(15, 29)],
        29: [*range(29)],
    }

    @pytest.mark.parametrize("count", KEPT)
    @pytest.mark.parametrize("robot", ["g1", "g1_legs"])
    def test_they_are_read(self, whole, tmp_path, count, robot):
        columns = [*range(7), *(7 + k for k in self.KEPT[count])]
        np.savetxt(tmp_path / "x.csv", whole[:, columns], delimiter=",")
        motion = llsrbm.load_motion(tmp_path / "x.csv", robot, fps=60)
        np.savetxt(tmp_path / "whole.csv", whole, delimiter=",")
        same = llsrbm.load_motion(tmp_path / "whole.csv", robot, fps=60)
        np.testing.assert_array_equal(motion.qpos, same.qpos)
        assert (motion.fps, motion.remarks) == (60, same.remarks)
        assert bool(motion.remarks) == (robot == "g1_legs")  # whose arms are held

    def test_a_waist_that_moves_is_left_out_and_named(self, whole, tmp_path):
        whole[5:9, 7 + LEGS_29] = 0.3
        np.savetxt(tmp_path / "x.csv", whole, delimiter=",")
        motion = llsrbm.load_motion(tmp_path / "x.csv", "g1", fps=60)
        assert motion.remarks == (
            "Robot g1 holds joints that move (waist_yaw_joint by up to 0.3): they are left out.",
        )
        assert certify(motion) is not None

    def test_other_widths_name_what_would_be_read(self, whole, tmp_path):
        np.savetxt(tmp_path / "x.csv", whole[:, :-1], delimiter=",")
        with pytest.raises(llsrbm.Error) as caught:
            llsrbm.load_motion(tmp_path / "x.csv", "g1", fps=60)
        assert "row 1 has 35 columns; expected 27 or 30 or 34 or 36: 7 of" in str(caught.value)
        assert "23 (left_hip_pitch_joint to right_wrist_roll_joint)" in str(caught.value)
