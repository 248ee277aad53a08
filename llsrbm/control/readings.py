"""`Readings`: everything that a robot's own sensors say at one instant."""

from dataclasses import dataclass

from llsrbm.arrays import Array


@dataclass(frozen=True, eq=False)
class Readings:
    """Sensor values of a robot with J joints and L feet, as they are on its wire.

    Neither the base's position nor its velocity is among them. The inertial unit is taken to sit in
    the base's origin, with the base's axes.
    """

    time: float  # s by the robot's clock
    quat: Array  # (4,) w, x, y, z: the base's attitude by the unit's own filter; its yaw drifts
    gyro: Array  # (3,) rad/s, base frame
    acceleration: Array  # (3,) m/s2, base frame: specific force, +9.81 along z of a base at rest
    q: Array  # (J,) rad, in `Robot.joint_names`' order
    dq: Array  # (J,) rad/s
    torque: Array  # (J,) Nm, as the drives estimate them
    foot_force: Array | None  # (L,) N; None: the robot's feet feel nothing
