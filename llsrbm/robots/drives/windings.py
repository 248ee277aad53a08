"""Windings of a robot's drives: the current that a torque takes, and the heat of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from llsrbm.arrays import Array
from llsrbm.robots.drives.table import Electrical
from llsrbm.robots.robot import Robot


@dataclass(frozen=True, eq=False)
class Windings:
    """Numbers of J joints, in the order of `Robot.joint_names`.

    Attributes:
        torque_constant: (J,) Nm or N per A; resistance: (J,) ohm.
        heat: (J,) J, largest of one motion; infinite where the file has none.
        battery: the file's table, with voltage and currents.
    """

    torque_constant: Array
    resistance: Array
    heat: Array
    battery: Electrical

    @staticmethod
    def of(robot: Robot) -> Windings | None:
        """Those of the robot's file; None: it has no numbers of them."""
        table = robot.file.drives.electrical
        if table is None:
            return None

        def each(name: str) -> Array:
            legs, arms = (getattr(motor, name) for motor in (table, table.arms or table))
            return robot.of_limbs(legs, arms, np.full(len(robot.joint_names), np.inf))

        return Windings(each("torque_constant"), each("resistance"), each("heat"), table)

    def reordered(self, order: Sequence[int]) -> Windings:
        """The joints at the indices `order` alone."""
        numbers = (self.torque_constant[order], self.resistance[order], self.heat[order])
        return Windings(*numbers, self.battery)

    def heating(self, torque: Array) -> Array:
        """R i^2 (..., J) W at torques (..., J) Nm or N."""
        return self.resistance * (torque / self.torque_constant) ** 2
