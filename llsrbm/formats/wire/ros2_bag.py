"""Messages of the bag: `llsrbm.formats.wire.ros2.ROS2_BAG` says which."""

import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Literal

import numpy as np
from rosbags.interfaces import (
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from llsrbm.arrays import Array
from llsrbm.formats.base import ORDERS
from llsrbm.look.visuals import forward_kinematics
from llsrbm.mechanics import rotation_matrices
from llsrbm.motion.bodies import body_order, link_paths, urdf_joints
from llsrbm.motion.trajectory import Trajectory
from llsrbm.motion.whole_body import WholeBodyMotion, whole_body_motion

_Message = tuple[str, str, int, Any]  # topic, type, ns, message

_NAME = "jump"  # of the bag's file
_VERSION: Literal[8] = 8
_START = 1_000_000_000  # ns
_SECOND = 1_000_000_000
_WORLD, _TRAJECTORY = "world", "/joint_trajectory_controller/joint_trajectory"
_UNKNOWN = QosTime(0, 0)
# A subscriber that comes later gets the last message, too.
_LATCHED = Qos(
    history=QosHistory.KEEP_LAST,
    depth=1,
    reliability=QosReliability.RELIABLE,
    durability=QosDurability.TRANSIENT_LOCAL,
    deadline=_UNKNOWN,
    lifespan=_UNKNOWN,
    liveliness=QosLiveliness.SYSTEM_DEFAULT,
    liveliness_lease_duration=_UNKNOWN,
    avoid_ros_namespace_conventions=False,
)

_STORE = get_typestore(Stores.ROS2_HUMBLE)


def write(trajectory: Trajectory, path: Path, fps: float) -> None:
    """Write the folder at `path`, where nothing is yet."""
    motion = whole_body_motion(trajectory, fps, events=True)
    messages = sorted(_messages(motion), key=lambda message: message[2])
    # SQLite is told a URI, in which not every path can stand, and the file is called as the folder.
    with tempfile.TemporaryDirectory() as folder:
        bag = Path(folder) / _NAME
        with Writer(bag, version=_VERSION, storage_plugin=StoragePlugin.SQLITE3) as writer:
            connections: dict[str, Any] = {}
            for topic, kind, time, message in messages:
                if topic not in connections:
                    qos = [_LATCHED] if topic == "/tf_static" else []
                    connections[topic] = writer.add_connection(
                        topic, kind, typestore=_STORE, offered_qos_profiles=qos
                    )
                writer.write(connections[topic], time, _STORE.serialize_cdr(message, kind))
        shutil.copytree(bag, path)


def _messages(motion: WholeBodyMotion) -> Iterator[_Message]:
    times = [_START + round(seconds * _SECOND) for seconds in motion.time]
    yield _trajectory(motion)
    yield from _joint_states(motion, times)
    yield from _transforms(motion, times)
    yield from _odometry(motion, times)
    yield from _contacts(motion, times)


def _trajectory(motion: WholeBodyMotion) -> _Message:
    order = urdf_joints(motion.robot)
    points = [
        _made(
            "trajectory_msgs/msg/JointTrajectoryPoint",
            positions=q,
            velocities=dq,
            accelerations=np.zeros(0),
            effort=np.zeros(0),
            time_from_start=_time(round(seconds * _SECOND), "Duration"),
        )
        for seconds, q, dq in zip(
            motion.time, order.position(motion), order.velocity(motion), strict=True
        )
    ]
    kind = "trajectory_msgs/msg/JointTrajectory"
    message = _made(kind, header=_header(0, ""), joint_names=list(order.joints), points=points)
    return _TRAJECTORY, kind, _START, message


def _joint_states(motion: WholeBodyMotion, times: list[int]) -> Iterator[_Message]:
    kind, order = "sensor_msgs/msg/JointState", urdf_joints(motion.robot)
    position, velocity = order.position(motion), order.velocity(motion)
    index, torque = np.array(order.index), motion.joint_torque
    if torque is None:
        effort = np.zeros((len(times), 0))
    else:
        effort = np.where(index < 0, 0.0, torque[:, index])
    for k, time in enumerate(times):
        message = _made(
            kind,
            header=_header(time, ""),
            name=list(order.joints),
            position=position[k],
            velocity=velocity[k],
            effort=effort[k],
        )
        yield "/joint_states", kind, time, message


def _transforms(motion: WholeBodyMotion, times: list[int]) -> Iterator[_Message]:
    kind = "tf2_msgs/msg/TFMessage"
    state = motion.base_position, motion.base_quat, motion.joint_position
    paths = list(link_paths(motion.robot, *forward_kinematics(motion.robot, *state)))
    still = [
        _transform(times[0], path.parent, path.link, path.position[0], path.quat[0])
        for path in paths
        if not path.moves
    ]
    yield "/tf_static", kind, times[0], _made(kind, transforms=still)
    assert motion.pressed_at is not None  # plans and rollouts have it
    for k, time in enumerate(times):
        moved = [
            _transform(time, path.parent, path.link, path.position[k], path.quat[k])
            for path in paths
            if path.moves
        ]
        moved += [
            _transform(time, _WORLD, f"contact/{leg}", motion.pressed_at[k, i], np.eye(4)[0])
            for i, leg in enumerate(motion.robot.leg_names)
        ]
        yield "/tf", kind, time, _made(kind, transforms=moved)


def _odometry(motion: WholeBodyMotion, times: list[int]) -> Iterator[_Message]:
    kind, root = "nav_msgs/msg/Odometry", body_order(motion.robot, ORDERS[0]).bodies[0]
    R_base_world = np.swapaxes(rotation_matrices(motion.base_quat), -1, -2)
    linear = np.einsum("kij,kj->ki", R_base_world, motion.base_velocity)
    angular = np.einsum("kij,kj->ki", R_base_world, motion.angular_velocity)
    for k, time in enumerate(times):
        place = _made(
            "geometry_msgs/msg/Pose",
            position=_xyz("Point", motion.base_position[k]),
            orientation=_quaternion(motion.base_quat[k]),
        )
        twist = _made(
            "geometry_msgs/msg/Twist",
            linear=_xyz("Vector3", linear[k]),
            angular=_xyz("Vector3", angular[k]),
        )
        none = np.zeros(36)
        message = _made(
            kind,
            header=_header(time, _WORLD),
            child_frame_id=root,
            pose=_made("geometry_msgs/msg/PoseWithCovariance", pose=place, covariance=none),
            twist=_made("geometry_msgs/msg/TwistWithCovariance", twist=twist, covariance=none),
        )
        yield "/odom", kind, time, message


def _contacts(motion: WholeBodyMotion, times: list[int]) -> Iterator[_Message]:
    kind = "geometry_msgs/msg/WrenchStamped"
    assert motion.foot_force is not None  # plans and rollouts have it
    for i, leg in enumerate(motion.robot.leg_names):
        for k, time in enumerate(times):
            stands = _made("std_msgs/msg/Bool", data=bool(motion.contact[k, i]))
            yield f"/contact/{leg}", "std_msgs/msg/Bool", time, stands
            wrench = _made(
                "geometry_msgs/msg/Wrench",
                force=_xyz("Vector3", motion.foot_force[k, i]),
                torque=_xyz("Vector3", np.zeros(3)),
            )
            message = _made(kind, header=_header(time, f"contact/{leg}"), wrench=wrench)
            yield f"/contact_force/{leg}", kind, time, message


# ---- parts of messages


def _made(kind: str, **fields: Any) -> Any:
    """A message; arrays (n,) are copied, as rows of others may have gaps in memory."""
    arrays = {name: np.array(v) for name, v in fields.items() if isinstance(v, np.ndarray)}
    return _STORE.types[kind](**(fields | arrays))


def _time(nanoseconds: int, kind: str = "Time") -> Any:
    sec, nanosec = divmod(nanoseconds, _SECOND)
    return _made(f"builtin_interfaces/msg/{kind}", sec=sec, nanosec=nanosec)


def _header(nanoseconds: int, frame: str) -> Any:
    return _made("std_msgs/msg/Header", stamp=_time(nanoseconds), frame_id=frame)


def _xyz(kind: str, values: Array) -> Any:
    x, y, z = values.tolist()
    return _made(f"geometry_msgs/msg/{kind}", x=x, y=y, z=z)


def _quaternion(quat: Array) -> Any:
    w, x, y, z = quat.tolist()
    return _made("geometry_msgs/msg/Quaternion", x=x, y=y, z=z, w=w)


def _transform(time: int, parent: str, child: str, position: Array, quat: Array) -> Any:
    return _made(
        "geometry_msgs/msg/TransformStamped",
        header=_header(time, parent),
        child_frame_id=child,
        transform=_made(
            "geometry_msgs/msg/Transform",
            translation=_xyz("Vector3", position),
            rotation=_quaternion(quat),
        ),
    )
