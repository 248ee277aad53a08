"""Logs for Foxglove, read back with the MCAP project's own reader and the schemas in the file."""

import json
from collections import defaultdict

import numpy as np
import pinocchio as pin
import pytest
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory
from scipy.spatial.transform import Rotation

from llsrbm.errors import InputError
from llsrbm.formats import FORMATS, export
from llsrbm.look.visuals import link_visuals
from llsrbm.motion.sampling import events
from llsrbm.robots import load_robot
from tests.llsrbm.formats.jumps import planned
from tests.llsrbm.formats.logs.logs import (
    BOARD,
    body_frames,
    link_poses,
    rollout,
    sampled,
    written,
)
from tests.llsrbm.synthetic import FLIGHT


class Log:
    """What is in a file: topic -> times (ns) and messages."""

    def __init__(self, path):
        self.times, self.messages, self.schemas = defaultdict(list), defaultdict(list), {}
        with path.open("rb") as file:
            reader = make_reader(file, decoder_factories=[DecoderFactory(), Json()])
            for schema, channel, message, decoded in reader.iter_decoded_messages():
                assert message.log_time == message.publish_time
                self.times[channel.topic].append(message.log_time)
                self.messages[channel.topic].append(decoded)
                self.schemas[channel.topic] = schema
            self.metadata = {each.name: each.metadata for each in reader.iter_metadata()}
            self.attachments = {each.name: each for each in reader.iter_attachments()}

    def seconds(self, topic):
        return np.array(self.times[topic]) * 1e-9

    def numbers(self, topic, name, parts="xyz"):
        rows = []
        for message in self.messages[topic]:
            for key in name.split("/"):
                message = message[key]
            rows.append([message[part] for part in parts])
        return np.array(rows)


class Json:
    def decoder_for(self, encoding, schema):
        return json.loads if encoding == "json" else None


@pytest.fixture(scope="module")
def log(plan, tmp_path_factory):
    return Log(written(plan, tmp_path_factory.mktemp("plan"), "mcap"))


@pytest.fixture(scope="module")
def simulated(tmp_path_factory):
    return Log(written(rollout(), tmp_path_factory.mktemp("rollout"), "mcap"))


def xyz(vector):
    return np.array([vector.x, vector.y, vector.z])


def turn(quat):
    return Rotation.from_quat([quat.x, quat.y, quat.z, quat.w])


def tree(messages):
    """child -> (parent, SE3), of one FrameTransforms or several."""
    found = {}
    for message in messages:
        for each in message.transforms:
            assert each.child_frame_id not in found, "a frame has one parent"
            placement = pin.SE3(turn(each.rotation).as_matrix(), xyz(each.translation))
            found[each.child_frame_id] = (each.parent_frame_id, placement)
    return found


def in_world(frames, name):
    placement = pin.SE3.Identity()
    while name != "world":
        name, step = frames[name]
        placement = step * placement
    return placement


def check_links(log, top, prefix, trajectory):
    robot = trajectory.jump.robot
    at, joints = sampled(trajectory, log.seconds(f"{top}/tf") + trajectory.time[0])
    (still,) = log.messages[f"{top}/tf_static"]
    for k in np.linspace(0, len(at.time) - 1, 12).astype(int):
        frames = tree([still, log.messages[f"{top}/tf"][k]])
        poses = link_poses(robot, at, joints, k)
        assert set(frames) == {prefix + link for link in poses}
        for link, expected in poses.items():
            got = in_world(frames, prefix + link)
            np.testing.assert_allclose(got.homogeneous, expected.homogeneous, atol=1e-6)


def test_every_link_is_where_pinocchio_puts_it(plan, log):
    check_links(log, "", "", plan)


def test_the_tree_is_the_urdfs(plan, log):
    """Or a URDF layer would be torn between two parents."""
    model = load_robot(plan.jump.robot).model
    frames = tree([*log.messages["/tf_static"], log.messages["/tf"][0]])
    for link, index in body_frames(plan.jump.robot).items():
        joint = model.frames[index].parentFrame
        parent = model.frames[model.frames[joint].parentFrame]
        expected = parent.name if parent.type == pin.FrameType.BODY else "world"
        assert frames[link][0] == expected


def test_time(plan, log):
    start = plan.time[0]
    exact = np.round((events(plan) - start) * 1e9).astype(int)
    for topic, times in log.times.items():
        assert times[0] == 0, topic
        assert (np.diff(times) > 0).all(), topic
        if topic not in ("/tf_static", "/robot", "/scene"):
            assert np.diff(times).max() <= 5_000_000 + 1, topic
            assert set(exact) <= set(times), topic
            assert times[-1] == round((plan.time[-1] - start) * 1e9)
    for message, time in zip(
        log.messages["/joint_states"], log.times["/joint_states"], strict=True
    ):
        assert message.timestamp.seconds * 10**9 + message.timestamp.nanos == time


def test_joint_states(plan, log):
    at, _ = sampled(plan, log.seconds("/joint_states"))
    names = load_robot(plan.jump.robot).joint_names
    order = [plan.joint_names.index(name) for name in names]
    messages = log.messages["/joint_states"]
    assert all(tuple(joint.name for joint in message.joints) == names for message in messages)
    for field, values in (
        ("position", at.joint_position),
        ("velocity", at.joint_velocity),
        ("effort", at.joint_torque),
    ):
        got = [[getattr(joint, field) for joint in message.joints] for message in messages]
        np.testing.assert_allclose(got, values[:, order], atol=1e-6)


def test_numbers_to_plot(plan, log):
    at, joints = sampled(plan, log.seconds("/state"))
    for name, values in (
        ("com", at.com),
        ("com_velocity", at.com_velocity),
        ("linear_momentum", at.linear_momentum),
        ("angular_momentum", at.angular_momentum),
        ("base_position", at.base_position),
        ("angular_velocity", at.angular_velocity),
    ):
        np.testing.assert_allclose(log.numbers("/state", name), values, atol=1e-6)
    np.testing.assert_allclose(
        log.numbers("/state", "principal_moments", ("smallest", "middle", "largest")),
        np.linalg.eigvalsh(at.inertia),
        atol=1e-6,
    )
    position = log.numbers("/state", "joint_position", joints)
    np.testing.assert_allclose(position, np.stack(list(joints.values()), axis=1), atol=1e-6)
    share = log.numbers("/state", "torque_share", at.joint_names)
    np.testing.assert_allclose(share, at.joint_torque / at.joint_torque_limit, atol=1e-6)
    assert [message["time"] for message in log.messages["/state"]] == pytest.approx(at.time)


def test_forces_and_contacts(plan, log):
    at, _ = sampled(plan, log.seconds("/state"))
    flight = at.phase == FLIGHT
    total = sum(log.numbers("/state", f"foot_force/{leg}") for leg in plan.leg_names)
    np.testing.assert_allclose(total[:-1], at.contact_force.sum(axis=1)[:-1], atol=1e-6)
    contact = log.numbers("/state", "contact", plan.leg_names)
    assert (contact[flight] == 0).all()
    assert (contact[~flight] == 1).all()


def test_the_ellipsoid_has_the_inertia(plan, log):
    at, _ = sampled(plan, log.seconds("/inertia"))
    mass = load_robot(plan.jump.robot).mass
    for k in (0, len(at.time) // 2, -1):
        (solid,) = log.messages["/inertia"][k].entities[0].spheres
        a, b, c = (xyz(solid.size) / 2) ** 2
        R = turn(solid.pose.orientation).as_matrix()
        inertia = R @ np.diag([b + c, a + c, a + b]) @ R.T * mass / 5
        np.testing.assert_allclose(inertia, at.inertia[k], atol=1e-6)


def test_meshes_hang_on_links(plan, log):
    (message,) = log.messages["/robot"]
    visuals = {each.link: each for each in link_visuals(load_robot(plan.jump.robot), coarse=True)}
    assert {entity.frame_id for entity in message.entities} == set(visuals)
    for entity in message.entities:
        visual = visuals[entity.frame_id]
        assert entity.frame_id in body_frames(plan.jump.robot)
        assert entity.frame_locked
        (mesh,) = entity.triangles
        np.testing.assert_allclose([xyz(point) for point in mesh.points], visual.vertices)
        np.testing.assert_allclose([(c.r, c.g, c.b) for c in mesh.colors], visual.rgb / 255)
        assert mesh.indices == visual.faces.ravel().tolist()


def test_schemas_are_known_to_viewers(log):
    encodings = {topic: (s.name, s.encoding) for topic, s in log.schemas.items()}
    assert encodings["/tf"] == ("foxglove.FrameTransforms", "protobuf")
    assert encodings["/joint_states"] == ("foxglove.JointStates", "protobuf")
    assert encodings["/state"] == ("state", "jsonschema")
    schema = json.loads(log.schemas["/state"].data)
    assert set(schema["properties"]) == set(log.messages["/state"][0])
    assert schema["properties"]["com"]["properties"]["x"]["description"] == "m"


def test_what_stands_beside_the_numbers(plan, log):
    about = json.loads(log.attachments["llsrbm.json"].data)
    assert about["request"] == plan.jump.as_dict()
    assert about["solver"]["status"] == "solved"
    assert about["robot"]["mass"] == pytest.approx(load_robot(plan.jump.robot).mass)
    metadata = log.metadata["llsrbm"]
    assert metadata["kind"] == "plan"
    assert json.loads(metadata["request"]) == about["request"]
    assert set(metadata) == set(about)


def test_a_rollout_and_the_plan_that_it_followed(simulated):
    followed = rollout().plan
    check_links(simulated, "", "", rollout())
    check_links(simulated, "/plan", "plan/", followed)
    at, _ = sampled(followed, simulated.seconds("/plan/state"))
    np.testing.assert_allclose(simulated.numbers("/plan/state", "com"), at.com, atol=1e-6)
    (message,) = simulated.messages["/plan/robot"]
    assert {entity.frame_id for entity in message.entities} <= {
        f"plan/{link}" for link in body_frames("go2")
    }
    assert all(entity.triangles[0].color.a < 0.5 for entity in message.entities)


def test_what_the_controller_tracked(simulated):
    at, _ = sampled(rollout(), simulated.seconds("/reference"))
    got = simulated.numbers("/reference", "com")
    np.testing.assert_allclose(got, at.reference_com, atol=1e-6)
    got = simulated.numbers("/reference", "base_quat", "wxyz")
    np.testing.assert_allclose(got, at.reference_base_quat, atol=1e-6)


def test_the_coms_velocity_is_that_of_the_robot_that_was_simulated(simulated):
    """Whose trunk weighs a tenth more than the robot's."""
    time, com = simulated.seconds("/state"), simulated.numbers("/state", "com")
    velocity = simulated.numbers("/state", "com_velocity")
    moved = np.sum((velocity[1:] + velocity[:-1]) / 2 * np.diff(time)[:, None], axis=0)
    np.testing.assert_allclose(moved, com[-1] - com[0], atol=1e-3)
    flight = rollout().plan.phase_start[1:3].mean()
    rising = np.searchsorted(time, flight - 0.1)
    slope = (com[rising + 1] - com[rising]) / (time[rising + 1] - time[rising])
    np.testing.assert_allclose(velocity[rising : rising + 2].mean(axis=0), slope, atol=5e-3)


def test_the_board_comes_in_mid_flight(simulated):
    before, after = simulated.messages["/scene"]
    assert simulated.times["/scene"][1] == pytest.approx(
        1e9 * rollout().plan.phase_start[1:3].mean(), abs=1
    )
    assert [entity.id for entity in before.entities] == ["ground"]
    assert [gone.id for gone in before.deletions] == ["board"]
    assert [entity.id for entity in after.entities] == ["ground", "board"]
    board = after.entities[1].cubes[0]
    assert board.pose.position.z + board.size.z / 2 == pytest.approx(BOARD)


def test_without_its_packages(tmp_path, monkeypatch):
    monkeypatch.setattr("llsrbm.formats.base.find_spec", lambda name: None)
    with pytest.raises(InputError, match=r'pip install "llsrbm\[mcap\]"'):
        export(planned("go2"), tmp_path / "x.mcap", format="mcap")
    assert FORMATS["mcap"].extra.modules == ("foxglove",)
    assert not list(tmp_path.iterdir())
