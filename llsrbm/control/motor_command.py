"""`MotorCommand`: the five numbers that nearly every robot's motors take, joint by joint."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from llsrbm.arrays import Array


@dataclass(frozen=True, eq=False)
class MotorCommand:
    """Targets and gains of J joints, in `Robot.joint_names`' order, held until the next command.

    Motors apply tau + kp (q - q measured) + kd (dq - dq measured), in a loop of their own.
    """

    q: Array  # (J,) rad
    dq: Array  # (J,) rad/s
    tau: Array  # (J,) Nm
    kp: Array  # (J,) Nm/rad
    kd: Array  # (J,) Nm s/rad

    def torque(self, q: Array, dq: Array) -> Array:
        """Torque (J,) Nm at measured positions q (J,) and speeds dq (J,), before any limit."""
        return self.tau + self.kp * (self.q - q) + self.kd * (self.dq - dq)

    @classmethod
    def of_torque(cls, tau: Array) -> MotorCommand:
        """Torques (J,) alone, whatever the joints do."""
        zero = np.zeros(len(tau))
        return cls(zero, zero, np.asarray(tau, dtype=np.float64), zero, zero)

    @classmethod
    def damping(cls, kd: Array) -> MotorCommand:
        """Brakes of gain (J,) Nm s/rad, nothing else: how a robot is stopped safely."""
        zero = np.zeros(len(kd))
        return cls(zero, zero, zero, zero, np.asarray(kd, dtype=np.float64))
