"""Layouts of the low-level messages of Unitree's robots, as its SDK publishes them.

`unitree_go`: Go2, B2, H1; `unitree_hg`: G1, H1-2. Field names and their order are part
of the types that DDS compares.
"""

from typing import NamedTuple

import numpy as np

from llsrbm.wire.layout import Layout

COMMAND_TOPIC, STATE_TOPIC = "rt/lowcmd", "rt/lowstate"
# Types of the structures within messages, by the names of their fields.
STRUCTURES = {
    "motor_cmd": "MotorCmd_",
    "motor_state": "MotorState_",
    "imu_state": "IMUState_",
    "bms_cmd": "BmsCmd_",
    "bms_state": "BmsState_",
}


class Family(NamedTuple):
    """The two messages of a family."""

    command: Layout
    state: Layout


_FRAME = [
    ("head", "u1", 2),
    ("level_flag", "u1"),
    ("frame_reserve", "u1"),
    ("sn", "<u4", 2),
    ("version", "<u4", 2),
    ("bandwidth", "<u2"),
]
_PD = [("mode", "u1"), *((name, "<f4") for name in ("q", "dq", "tau", "kp", "kd"))]
_MOVING = [("mode", "u1"), *((name, "<f4") for name in ("q", "dq", "ddq", "tau_est"))]
_IMU = [
    ("quaternion", "<f4", 4),
    ("gyroscope", "<f4", 3),
    ("accelerometer", "<f4", 3),
    ("rpy", "<f4", 3),
]


def _structure(*fields: object) -> np.dtype[np.void]:
    return np.dtype([*fields], align=True)


_GO_COMMAND = [
    *_FRAME,
    ("motor_cmd", _structure(*_PD, ("reserve", "<u4", 3)), 20),
    ("bms_cmd", _structure(("off", "u1"), ("reserve", "u1", 3))),
    ("wireless_remote", "u1", 40),
    ("led", "u1", 12),
    ("fan", "u1", 2),
    ("gpio", "u1"),
    ("reserve", "<u4"),
    ("crc", "<u4"),
]
_GO_MOTOR = _structure(
    *_MOVING,
    *((name, "<f4") for name in ("q_raw", "dq_raw", "ddq_raw")),
    ("temperature", "u1"),
    ("lost", "<u4"),
    ("reserve", "<u4", 2),
)
_GO_BATTERY = _structure(
    *((name, "u1") for name in ("version_high", "version_low", "status", "soc")),
    ("current", "<i4"),
    ("cycle", "<u2"),
    ("bq_ntc", "u1", 2),
    ("mcu_ntc", "u1", 2),
    ("cell_vol", "<u2", 15),
)
_GO_STATE = [
    *_FRAME,
    ("imu_state", _structure(*_IMU, ("temperature", "u1"))),
    ("motor_state", _GO_MOTOR, 20),
    ("bms_state", _GO_BATTERY),
    ("foot_force", "<i2", 4),
    ("foot_force_est", "<i2", 4),
    ("tick", "<u4"),
    ("wireless_remote", "u1", 40),
    ("bit_flag", "u1"),
    ("adc_reel", "<f4"),
    ("temperature_ntc1", "u1"),
    ("temperature_ntc2", "u1"),
    ("power_v", "<f4"),
    ("power_a", "<f4"),
    ("fan_frequency", "<u2", 4),
    ("reserve", "<u4"),
    ("crc", "<u4"),
]
_HG_COMMAND = [
    ("mode_pr", "u1"),
    ("mode_machine", "u1"),
    ("motor_cmd", _structure(*_PD, ("reserve", "<u4")), 35),
    ("reserve", "<u4", 4),
    ("crc", "<u4"),
]
_HG_MOTOR = _structure(
    *_MOVING,
    ("temperature", "<i2", 2),
    ("vol", "<f4"),
    ("sensor", "<u4", 2),
    ("motorstate", "<u4"),
    ("reserve", "<u4", 4),
)
_HG_STATE = [
    ("version", "<u4", 2),
    ("mode_pr", "u1"),
    ("mode_machine", "u1"),
    ("tick", "<u4"),
    ("imu_state", _structure(*_IMU, ("temperature", "<i2"))),
    ("motor_state", _HG_MOTOR, 35),
    ("wireless_remote", "u1", 40),
    ("reserve", "<u4", 4),
    ("crc", "<u4"),
]

FAMILIES = {
    "unitree_go": Family(
        Layout("unitree_go.msg.dds_.LowCmd_", _GO_COMMAND),
        Layout("unitree_go.msg.dds_.LowState_", _GO_STATE),
    ),
    "unitree_hg": Family(
        Layout("unitree_hg.msg.dds_.LowCmd_", _HG_COMMAND),
        Layout("unitree_hg.msg.dds_.LowState_", _HG_STATE),
    ),
}
