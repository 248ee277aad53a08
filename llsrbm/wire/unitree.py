"""Commands and readings as messages of Unitree's robots, and back."""

import numpy as np
from scipy.spatial.transform import Rotation

from llsrbm.control.motor_command import MotorCommand
from llsrbm.control.readings import Readings
from llsrbm.errors import InputError
from llsrbm.robots import Robot
from llsrbm.wire.layout import Layout, Record
from llsrbm.wire.link import Health
from llsrbm.wire.motor_map import MotorMap
from llsrbm.wire.unitree_layouts import FAMILIES

_HEAD, _LOW_LEVEL = (0xFE, 0xEF), 0xFF
_CONTROLLED = 1  # a motor's mode: by its five numbers
# Position and speed that switch the loops for both off, by the SDK, and are sent to motors that
# are not there.
IDLE_POSITION, IDLE_SPEED = 2.146e9, 16000.0
_TICKS = 1000.0  # of a robot's clock a second
_VOLTAGE = 28.8  # V that simulated batteries have without load: Go2's
_WARM = 30  # deg C of all that a simulated robot has


class UnitreeMessages:
    """The messages of one robot. Raises `InputError`: its file has no [wire] of Unitree's."""

    def __init__(self, robot: Robot) -> None:
        self._map = motors = MotorMap.of(robot)
        if motors.family not in FAMILIES:
            raise InputError(
                f"{robot.path}: wire.family: expected {' or '.join(FAMILIES)} for Unitree's "
                f"messages, got {motors.family}"
            )
        self.command_layout, self.state_layout = FAMILIES[motors.family]
        self._go = motors.family == "unitree_go"
        self._legs = len(robot.legs)
        # Feet are counted as their legs' motors are.
        first = [motors.joints.index(leg.joints[0]) for leg in robot.legs]
        self._feet = np.argsort(np.argsort(first))
        # A G1 says which variant of its body it is, and takes commands for that one only.
        self._mode_machine = 0

    # ---- the player's side

    def pack_command(self, command: MotorCommand) -> Record:
        """A command's message, with its checksum.

        Motors of joints that the robot's file holds are held where they are, except by commands
        that do nothing but brake.
        """
        record, motors = self.command_layout.blank(), self._map
        each, used = record["motor_cmd"], motors.used
        hold = bool(command.kp.any() or command.tau.any())
        each["q"] = motors.positions(command.q)
        each["dq"] = motors.speeds(command.dq)
        each["tau"] = motors.torques(command.tau)
        each["kp"] = motors.stiffness(command.kp, hold)
        each["kd"] = motors.damping(command.kd)
        if self._go:
            record["head"], record["level_flag"] = _HEAD, _LOW_LEVEL
            each["mode"] = _CONTROLLED
            each["q"][~used], each["dq"][~used] = IDLE_POSITION, IDLE_SPEED
        else:
            record["mode_machine"] = self._mode_machine
            each["mode"] = np.where(used, _CONTROLLED, 0)
        record["crc"] = Layout.checksum(record)
        return record

    def readings(self, record: Record) -> Readings:
        """The readings of a robot's message."""
        if not self._go:
            self._mode_machine = int(record["mode_machine"])
        motors, imu, map_ = record["motor_state"], record["imu_state"], self._map
        foot_force = record["foot_force"][self._feet].astype(np.float64) if self._go else None
        return Readings(
            time=float(record["tick"]) / _TICKS,
            quat=imu["quaternion"].astype(np.float64),
            gyro=imu["gyroscope"].astype(np.float64),
            acceleration=imu["accelerometer"].astype(np.float64),
            q=map_.joint_positions(motors["q"].astype(np.float64)),
            dq=map_.joint_speeds(motors["dq"].astype(np.float64)),
            torque=map_.joint_torques(motors["tau_est"].astype(np.float64)),
            foot_force=foot_force,
        )

    def health(self, record: Record) -> Health:
        """Battery and temperatures of a robot's message."""
        hottest = float(record["motor_state"]["temperature"][self._map.used].max())
        if not self._go:
            return Health(None, None, hottest)
        charge = float(record["bms_state"]["soc"]) / 100
        return Health(float(record["power_v"]), charge, hottest)

    # ---- the robot's side, of a simulated one

    def command(self, record: Record) -> MotorCommand | None:
        """The command of a message; None if its checksum is wrong."""
        if int(record["crc"]) != Layout.checksum(record):
            return None
        each, motors = record["motor_cmd"], self._map
        q, dq, tau, kp, kd = (
            np.where(each["mode"] == 0, 0.0, each[name].astype(np.float64))
            for name in ("q", "dq", "tau", "kp", "kd")
        )
        # A loop that is switched off has neither target nor gain.
        no_position, no_speed = q >= 0.99 * IDLE_POSITION, dq >= 0.99 * IDLE_SPEED
        q[no_position] = kp[no_position] = dq[no_speed] = kd[no_speed] = 0.0
        return MotorCommand(
            q=motors.joint_positions(q),
            dq=motors.joint_speeds(dq),
            tau=motors.joint_torques(tau),
            kp=motors.joint_gains(kp),
            kd=motors.joint_gains(kd),
        )

    def pack_state(self, readings: Readings, voltage: float = 1.0) -> Record:
        """A simulated robot's message; `voltage`: share of the battery's."""
        record, motors = self.state_layout.blank(), self._map
        each, imu = record["motor_state"], record["imu_state"]
        each["mode"] = np.where(motors.used, _CONTROLLED, 0)
        each["q"] = motors.positions(readings.q)
        each["dq"] = motors.speeds(readings.dq)
        each["tau_est"] = motors.torques(readings.torque)
        each["temperature"] = _WARM
        imu["quaternion"], imu["gyroscope"] = readings.quat, readings.gyro
        imu["accelerometer"], imu["temperature"] = readings.acceleration, _WARM
        imu["rpy"] = Rotation.from_quat(readings.quat, scalar_first=True).as_euler("xyz")
        record["tick"] = round(readings.time * _TICKS)
        if self._go:
            record["head"], record["level_flag"] = _HEAD, _LOW_LEVEL
            record["power_v"], record["bms_state"]["soc"] = _VOLTAGE * voltage, 100
            if readings.foot_force is not None:
                feet = np.zeros(4)
                feet[self._feet] = readings.foot_force
                record["foot_force"] = record["foot_force_est"] = np.clip(feet, 0, 32767)
        record["crc"] = Layout.checksum(record)
        return record
