"""Motions in MuJoCo's coordinates that come from elsewhere: read, or refused in one line."""

import zipfile

import numpy as np
import pytest

from llsrbm.errors import FileFormatError
from llsrbm.formats import FORMATS, export
from llsrbm.formats.mujoco.motion import recognises
from llsrbm.motion.whole_body import whole_body_motion
from llsrbm.robots import load_robot
from llsrbm.simulation.scene import joints_in_model_order
from tests.llsrbm.formats.jumps import ROBOTS, planned

read = FORMATS["mujoco"].read
FPS = 100.0


@pytest.fixture(scope="module", params=ROBOTS)
def robot(request):
    return load_robot(request.param)


@pytest.fixture(scope="module")
def anymal():
    return load_robot("anymal")


def motion_of(robot, count=41):
    """A half turn in the air with every joint moving its own way; joints in MuJoCo's order."""
    time = np.arange(count) / FPS
    yaw = np.pi * time / time[-1]
    names = joints_in_model_order(robot)
    rest = dict(zip(robot.joint_names, robot.posture[7:], strict=True))
    own = np.arange(1, len(names) + 1)
    joints = np.array([rest[name] for name in names]) + 0.1 * np.sin(own * time[:, None])
    zero = np.zeros(count)
    qpos = np.column_stack(
        [time, 0.5 * time**2, 0.5 + zero, np.cos(yaw / 2), zero, zero, np.sin(yaw / 2), joints]
    )
    rates = 0.1 * own * np.cos(own * time[:, None])
    turn = np.pi / time[-1] + zero
    qvel = np.column_stack([1 + zero, time, zero, zero, zero, turn, rates])
    return names, time, qpos, qvel


def write(path, **arrays):
    np.savez(path, **arrays)
    return path


def in_robots_order(robot, names, values, before):
    return values[:, before:][:, [list(names).index(name) for name in robot.joint_names]]


def check(motion, robot, names, qpos, qvel, tolerance=1e-12):
    assert motion.origin == "mujoco"
    np.testing.assert_allclose(motion.base_position, qpos[:, :3], atol=tolerance)
    np.testing.assert_allclose(
        np.abs(np.sum(motion.base_quat * qpos[:, 3:7], axis=1)), 1, atol=tolerance
    )
    expected = in_robots_order(robot, names, qpos, 7)
    np.testing.assert_allclose(motion.joint_position, expected, atol=tolerance)
    np.testing.assert_allclose(motion.qvel[:, :6], qvel[:, :6], atol=10 * tolerance)
    np.testing.assert_allclose(
        motion.joint_velocity, in_robots_order(robot, names, qvel, 6), atol=10 * tolerance
    )


def test_without_names_joints_are_depth_first(robot, tmp_path):
    names, time, qpos, qvel = motion_of(robot)
    path = write(tmp_path / "x.npz", qpos=qpos, qvel=qvel, time=time + 7.0)
    assert recognises(path)
    motion = read(path, robot, None)
    check(motion, robot, names, qpos, qvel)
    assert motion.fps == pytest.approx(FPS)
    np.testing.assert_allclose(motion.time, time, atol=1e-9)


def test_joints_go_by_their_names(robot, tmp_path):
    names, _, qpos, qvel = motion_of(robot)
    shuffled = np.random.default_rng(1).permutation(len(names))
    path = write(
        tmp_path / "x.npz",
        qpos=np.hstack([qpos[:, :7], qpos[:, 7:][:, shuffled]]),
        qvel=np.hstack([qvel[:, :6], qvel[:, 6:][:, shuffled]]),
        joint_names=np.array(names)[shuffled],
        fps=np.array([FPS]),
    )
    check(read(path, robot, None), robot, names, qpos, qvel)


@pytest.mark.parametrize("types", [True, False])
def test_locomujocos_layout(robot, tmp_path, types):
    """With the free joint's name, in single precision, and a pickled None that is left alone."""
    names, _, qpos, qvel = motion_of(robot)
    extra = {"jnt_type": np.array([0, *[3] * len(names)])} if types else {}
    path = write(
        tmp_path / "x.npz",
        qpos=qpos.astype(np.float32),
        qvel=qvel.astype(np.float32),
        split_points=np.array([0, len(qpos)]),
        joint_names=np.array(["root", *names]),
        frequency=FPS,
        njnt=len(names) + 1,
        metadata=np.array(None, dtype=object),
        **extra,
    )
    check(read(path, robot, None), robot, names, qpos, qvel, tolerance=1e-5)


def test_without_velocities_they_are_differences(robot, tmp_path):
    names, _, qpos, qvel = motion_of(robot)
    motion = read(write(tmp_path / "x.npz", qpos=qpos), robot, FPS)
    check(motion, robot, names, qpos, motion_qvel(robot, names, motion), tolerance=1e-12)
    np.testing.assert_allclose(motion.qvel[:, :6], qvel[:, :6], atol=1e-3)
    np.testing.assert_allclose(
        motion.joint_velocity, in_robots_order(robot, names, qvel, 6), atol=0.02
    )


def motion_qvel(robot, names, motion):
    order = [robot.joint_names.index(name) for name in names]
    return np.hstack([motion.qvel[:, :6], motion.joint_velocity[:, order]])


@pytest.mark.parametrize("name", ROBOTS)
def test_there_and_back(name, tmp_path):
    plan = planned(name)
    export(plan, tmp_path / "folder", "mujoco")
    export(plan, tmp_path / "one.zip", "mujoco")
    export(plan, tmp_path / "two.zip", ["mujoco", "csv"])
    expected = whole_body_motion(plan, 500)
    robot = load_robot(name)
    for path in ("folder", "folder/motion.npz", "one.zip", "two.zip"):
        assert recognises(tmp_path / path)
        motion = read(tmp_path / path, robot, None)
        assert motion.fps == 500
        for quantity in ("time", "qpos", "qvel"):
            got = getattr(motion, quantity)
            np.testing.assert_allclose(got, getattr(expected, quantity), atol=1e-9)
        np.testing.assert_allclose(motion.com[1:-1], expected.com[1:-1], atol=5e-3)


def test_frames_that_are_not_even(anymal, tmp_path):
    _, time, qpos, qvel = motion_of(anymal)
    time = time + 0.3 * time**2
    path = write(tmp_path / "x.npz", qpos=qpos, qvel=qvel, time=time)
    motion = read(path, anymal, None)
    assert motion.fps is None
    np.testing.assert_allclose(motion.time, time)
    with pytest.raises(FileFormatError, match="not even"):
        read(path, anymal, 50.0)


def test_a_rate_that_contradicts_the_file_is_remarked_on(anymal, tmp_path):
    _, _, qpos, qvel = motion_of(anymal)
    motion = read(write(tmp_path / "x.npz", qpos=qpos, qvel=qvel, fps=FPS), anymal, 50.0)
    assert motion.fps == FPS
    assert motion.remarks[0] == f"it says {FPS:g} frames/s: the 50 asked for do not count"


def test_what_is_refused(anymal, tmp_path):
    names, time, qpos, qvel = motion_of(anymal)
    zero = qpos.copy()
    zero[3, 3:7] = 0
    unnamed = np.array(names, dtype=object)
    full = {"qpos": qpos, "qvel": qvel, "fps": FPS}
    for arrays, fps, message in (
        ({"qpos": qpos}, None, "does not say its rate; expected a rate as"),
        ({"qvel": qvel}, None, '"qpos" is missing'),
        (full | {"time": time / 2}, None, "100 frames/s by one account, 200 by another"),
        (full | {"time": time[::-1]}, None, "increase"),
        (full | {"fps": -1.0}, None, "expected frames per second"),
        (full | {"fps": np.nan}, None, "expected frames per second"),
        (full | {"fps": np.inf}, None, "expected frames per second"),
        (full | {"qpos": zero}, None, "unit quaternions, got one of norm 0 in frame 3"),
        (full | {"qpos": qpos[:, :-1]}, None, "expected 19 columns, got 18"),
        (full | {"qvel": qvel[:-1]}, None, r"expected shape \(T, V\) with T = 41"),
        (full | {"qpos": qpos * np.nan}, None, "finite"),
        (full | {"qpos": qpos[:1], "qvel": qvel[:1]}, None, "expected 2 to 50000 frames"),
        (full | {"qpos": qpos.astype(str)}, None, "real numbers"),
        (full | {"joint_names": np.array(["a"] * 12)}, None, "but robot anymal has LF_HAA"),
        (full | {"joint_names": np.array(3)}, None, "a list of names"),
        (
            full | {"joint_names": unnamed},
            None,
            "a pickle of Python objects, which is never opened",
        ),
        (full | {"split_points": np.array([0, 20, 41])}, None, "2 motions one after the other"),
    ):
        path = write(tmp_path / "x.npz", **arrays)
        with pytest.raises(FileFormatError, match=message) as caught:
            read(path, anymal, fps)
        assert "\n" not in str(caught.value)
        assert str(path) in str(caught.value)


def test_what_is_not_of_this_kind_is_not_recognised(tmp_path):
    (tmp_path / "a.csv").write_text("1,2,3\n")
    write(tmp_path / "native.npz", qpos=np.zeros(3), schema="llsrbm.rollout/1")
    write(tmp_path / "tracking.npz", joint_pos=np.zeros(3))
    with zipfile.ZipFile(tmp_path / "other.zip", "w") as archive:
        archive.writestr("a/motion.npz", b"")
    for path in tmp_path.iterdir():
        assert not recognises(path)
