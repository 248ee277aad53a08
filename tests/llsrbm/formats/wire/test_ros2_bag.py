"""Bags, read by rosbags with the definitions that stand in them."""

import json
import shutil

import numpy as np
import pytest
import yaml
from scipy.spatial.transform import Rotation

from llsrbm.formats import FORMATS, export
from llsrbm.robots import load_robot
from tests.llsrbm.formats.jumps import same_attitude, shipped, simulated
from tests.llsrbm.formats.wire.jumps import jump, rate_of, torques_of

highlevel = pytest.importorskip("rosbags.highlevel")

START = 1.0  # s
TYPES = {
    "/joint_states": "sensor_msgs/msg/JointState",
    "/joint_trajectory_controller/joint_trajectory": "trajectory_msgs/msg/JointTrajectory",
    "/tf": "tf2_msgs/msg/TFMessage",
    "/tf_static": "tf2_msgs/msg/TFMessage",
    "/odom": "nav_msgs/msg/Odometry",
    **{f"/contact/{leg}": "std_msgs/msg/Bool" for leg in ("FL", "FR", "RL", "RR")},
    **{
        f"/contact_force/{leg}": "geometry_msgs/msg/WrenchStamped"
        for leg in ("FL", "FR", "RL", "RR")
    },
}


@pytest.fixture(scope="module")
def folder(kind, tmp_path_factory):
    path = tmp_path_factory.mktemp("ros2") / "bag"
    export(jump("go2", kind), path, format="ros2-bag", fps=rate_of("go2"))
    return path


@pytest.fixture(scope="module")
def topics(folder):
    return read(folder)


def read(folder):
    """topic -> [(s, message)], in the order of the bag."""
    found = {}
    with highlevel.AnyReader([folder]) as reader:
        for connection, time, data in reader.messages():
            message = reader.deserialize(data, connection.msgtype)
            found.setdefault(connection.topic, []).append((time / 1e9, message))
    return found


def seconds(stamp):
    return stamp.sec + stamp.nanosec / 1e9


def xyz(vector):
    return np.array([vector.x, vector.y, vector.z])


def test_the_folder(folder, kind):
    assert sorted(file.name for file in folder.iterdir()) == [
        "jump.db3",
        "meta.json",
        "metadata.yaml",
    ]
    told = yaml.safe_load((folder / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert (told["version"], told["storage_identifier"]) == (8, "sqlite3")
    assert told["relative_file_paths"] == ["jump.db3"]
    there = {
        each["topic_metadata"]["name"]: each["topic_metadata"]
        for each in told["topics_with_message_count"]
    }
    assert {name: each["type"] for name, each in there.items()} == TYPES
    latched = yaml.safe_load(there["/tf_static"]["offered_qos_profiles"])
    assert latched[0]["durability"] == 1  # transient local
    assert json.loads((folder / "meta.json").read_text())["kind"] == kind


def test_joint_states(kind, topics):
    trajectory = jump("go2", kind)
    times = np.array([time for time, _ in topics["/joint_states"]]) - START
    assert times[0] == 0
    assert times[-1] == pytest.approx(trajectory.time[-1] - trajectory.time[0], abs=1e-6)
    ticks = np.searchsorted(trajectory.time - trajectory.time[0], times + 1e-7) - 1
    for k, (time, message) in enumerate(topics["/joint_states"]):
        assert seconds(message.header.stamp) == pytest.approx(time, abs=1e-9)
        assert sorted(message.name) == sorted(trajectory.joint_names)
        if kind == "rollout":  # all instants are ticks
            order = [trajectory.joint_names.index(name) for name in message.name]
            q, dq = trajectory.joint_position, trajectory.joint_velocity
            np.testing.assert_allclose(message.position, q[ticks[k], order], atol=1e-9)
            np.testing.assert_allclose(message.velocity, dq[ticks[k], order], atol=1e-9)
    effort = np.array([message.effort for _, message in topics["/joint_states"]])
    for j, joint in enumerate(topics["/joint_states"][0][1].name):
        wanted = torques_of(trajectory, joint, times[:-1] + 1e-8)
        np.testing.assert_allclose(effort[:-1, j], wanted, atol=1e-9)


def test_the_trajectory_is_the_joint_states(topics):
    [(time, message)] = topics["/joint_trajectory_controller/joint_trajectory"]
    states = topics["/joint_states"]
    assert time == START
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (0, 0)
    assert message.joint_names == states[0][1].name
    assert len(message.points) == len(states)
    since = np.array([seconds(point.time_from_start) for point in message.points])
    assert (np.diff(since) > 0).all()
    np.testing.assert_allclose(since, [time - START for time, _ in states], atol=1e-8)
    for point, (_, state) in zip(message.points, states, strict=True):
        np.testing.assert_array_equal(point.positions, state.position)
        np.testing.assert_array_equal(point.velocities, state.velocity)
        assert not len(point.effort)


def transforms(messages):
    """child -> (parent, position, rotation) of one message."""
    return {
        each.child_frame_id: (
            each.header.frame_id,
            xyz(each.transform.translation),
            Rotation.from_quat([getattr(each.transform.rotation, axis) for axis in "xyzw"]),
        )
        for each in messages.transforms
    }


def in_world(tree, frame):
    position, rotation = np.zeros(3), Rotation.identity()
    while frame != "world":
        frame, step, turn = tree[frame]
        position, rotation = step + turn.apply(position), turn * rotation
    return position, rotation


def test_the_feet_are_at_the_end_of_the_transforms(kind, topics):
    trajectory = jump("go2", kind)
    [(_, static)] = topics["/tf_static"]
    for time, message in topics["/tf"][::20]:
        tree = transforms(static) | transforms(message)
        at = np.searchsorted(trajectory.time, time - START + trajectory.time[0] + 1e-7) - 1
        base, attitude = in_world(tree, "base")
        exact = abs(trajectory.time[at] - trajectory.time[0] + START - time) < 1e-7
        for i, leg in enumerate(trajectory.leg_names):
            foot, _ = in_world(tree, f"{leg}_foot")
            if exact:
                wanted = trajectory.foot_position[at, i] + [0, 0, 0.022]
                np.testing.assert_allclose(foot, wanted, atol=0.006)
            pressed, level = in_world(tree, f"contact/{leg}")
            assert level.magnitude() == 0
            np.testing.assert_allclose(pressed, foot - [0, 0, 0.022], atol=0.006)
        if exact:
            np.testing.assert_allclose(base, trajectory.base_position[at], atol=1e-9)
            quat = attitude.as_quat(scalar_first=True)
            same_attitude(quat, trajectory.base_quat[at], atol=1e-9)


def test_odometry_is_the_simulators_state(tmp_path):
    rollout = simulated("go2")
    export(rollout, tmp_path / "bag", format="ros2-bag", fps=rate_of("go2"))
    messages = read(tmp_path / "bag")["/odom"]
    for time, message in messages[::20]:
        at = int(np.argmin(np.abs(rollout.time - rollout.time[0] + START - time)))
        assert (message.header.frame_id, message.child_frame_id) == ("world", "base")
        R = Rotation.from_quat([getattr(message.pose.pose.orientation, axis) for axis in "xyzw"])
        np.testing.assert_allclose(xyz(message.pose.pose.position), rollout.qpos[at, :3], atol=1e-9)
        linear, angular = xyz(message.twist.twist.linear), xyz(message.twist.twist.angular)
        np.testing.assert_allclose(R.apply(linear), rollout.qvel[at, :3], atol=1e-9)
        np.testing.assert_allclose(angular, rollout.qvel[at, 3:6], atol=1e-9)


def test_contacts_change_where_the_plan_says(kind, topics):
    trajectory = jump("go2", kind)
    for i, leg in enumerate(trajectory.leg_names):
        times = np.array([time for time, _ in topics[f"/contact/{leg}"]]) - START
        stands = np.array([message.data for _, message in topics[f"/contact/{leg}"]])
        changed = times[1:][np.diff(stands.astype(int)) != 0]
        true = np.asarray(trajectory.contact)[:, i].astype(int)
        edges = trajectory.time[1:][np.diff(true) != 0] - trajectory.time[0]
        np.testing.assert_allclose(changed, edges, atol=1e-6)
        force = np.array([xyz(m.wrench.force) for _, m in topics[f"/contact_force/{leg}"]])
        if kind == "plan":
            assert not force[~stands].any()
        assert force[stands, 2].mean() > 20  # of 160 N on four feet


def test_held_joints_stand_among_the_others(tmp_path):
    export(shipped("g1"), tmp_path / "g1", format="ros2-bag", fps=20)
    topics = read(tmp_path / "g1")
    held = load_robot("g1").file.urdf.held
    for _, message in topics["/joint_states"]:
        states = dict(
            zip(message.name, zip(message.position, message.effort, strict=True), strict=True)
        )
        assert len(states) == 29
        assert all(states[joint] == (angle, 0) for joint, angle in held.items())
    assert len(topics["/joint_trajectory_controller/joint_trajectory"][0][1].joint_names) == 29


def test_a_folder_of_any_name(folder, tmp_path):
    """SQLite, and so rosbags, opens no file in it; that is why the bag's own has a name of ours."""
    odd = tmp_path / "50 % of a jump?"
    export(shipped("go2"), odd, format="ros2-bag", fps=20)
    shutil.copytree(odd, tmp_path / "plain")
    assert set(read(tmp_path / "plain")) == set(TYPES)


def test_the_extra():
    assert FORMATS["ros2-bag"].extra.modules == ("rosbags",)
