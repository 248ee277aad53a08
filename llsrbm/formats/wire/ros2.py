"""A ROS 2 bag. The writer needs a package that a plain installation does not have."""

from pathlib import Path

from llsrbm.files.atomic import MARK
from llsrbm.formats.base import Extra, Format, Options, Purpose
from llsrbm.motion.trajectory import Trajectory


def _write(trajectory: Trajectory, path: Path, options: Options) -> None:
    from llsrbm.formats.wire.ros2_bag import write

    write(trajectory, path, options.fps)
    text = ROS2_BAG.described_json(trajectory, options, quaternion_order="xyzw")
    (path / MARK).write_text(text + "\n", encoding="utf-8")


ROS2_BAG = Format(
    name="ros2-bag",
    title="a bag for ROS 2: joint states and trajectory, transforms, contacts, odometry",
    purpose=Purpose.ROBOT,
    suffix="",
    write=_write,
    conventions="""\
A folder for `ros2 bag play`: messages in SQLite (storage sqlite3, CDR), and metadata.yaml of
version 8, the oldest that the package rosbags writes. No ROS is needed to write it.

Messages are 1/fps apart, and there are some exactly at each lift-off and touchdown (of a rollout:
at each change of contact, phase or mode). Stamps begin at 1 s: ROS takes 0 for no time.
  /joint_states     sensor_msgs/JointState: all joints of the robot's URDF by name, those that the
                    robot's file holds too; rad or m, per s, effort Nm or N (0 of held joints)
  /joint_trajectory_controller/joint_trajectory
                    trajectory_msgs/JointTrajectory, once at the start: the whole motion of these
                    joints, positions and velocities; its stamp is 0, which means now. Efforts are
                    left out: ros2_control's controller refused trajectories with any
  /tf, /tf_static   tf2_msgs/TFMessage: from link to link as in the URDF, "world" above the root
                    link, so no robot_state_publisher is needed beside it; and "contact/LEG" in
                    "world": where a foot is pushed (of a rollout's sole: its middle), world axes
  /odom             nav_msgs/Odometry of the root link in "world"; its twist is in the link's axes
  /contact/LEG      std_msgs/Bool: whether the foot stands
  /contact_force/LEG
                    geometry_msgs/WrenchStamped in the frame "contact/LEG": N on the foot
World frame, SI units; quaternions x, y, z, w by name, without jumps of sign. Between knots torques
and forces of a plan are held (of a refined plan they are straight lines), those of a rollout are
the tick's; at an edge they are of the phase that begins. `meta.json`: request, robot, solver.
""",
    options=("fps",),
    defaults=Options(fps=200.0),
    extra=Extra("ros2", ("rosbags",)),
)
