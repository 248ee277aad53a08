"""Table of a robot file for the robot's own wire: which motor moves which joint, and how."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from llsrbm.request.tables import Length, Positive, Table, fault

# Motors that a message holds, used or not; other families have as many as are named.
MESSAGE_MOTORS = {"unitree_go": 20, "unitree_hg": 35}

_OF_ALL_OR_EACH = ("kp", "kd", "sign", "zero", "gear")


class Wire(Table):
    """Motors as the robot's own messages number them, from 0, and the gains of plans played there.

    A motor turns by sign * gear * (joint's angle - zero). Arrays have one number a motor, in the
    motors' order.

    Attributes:
        family: of its messages: Unitree's for quadrupeds and H1 ("unitree_go"), for G1 and H1-2
            ("unitree_hg"), or those of the Open Dynamic Robot Initiative ("odri").
        motors: names of joints of the URDF, held ones among them; "" for a number without a motor.
        kp, kd: of the joint, Nm/rad and Nm s/rad (of one that slides N/m and N s/m), with which the
            motors alone follow a plan's table: one number for all, or one each.
        sign: 1 or -1 each; 1 if left out.
        zero: rad of the joint where its motor says 0; 0 if left out.
        gear: turns of the motor a turn of the joint: one number for all, or one each. 1 for
            messages that speak of joints.
        torque_constant: of the motors, Nm/A; max_current: A, largest one of a motor.
    """

    family: Literal["unitree_go", "unitree_hg", "odri"]
    motors: Annotated[tuple[str, ...], Field(min_length=1)]
    kp: Length | tuple[Length, ...]
    kd: Length | tuple[Length, ...]
    sign: tuple[Literal[-1, 1], ...] | None = None
    zero: tuple[float, ...] | None = None
    gear: Positive | tuple[Positive, ...] = 1.0
    torque_constant: Positive | None = None
    max_current: Positive | None = None

    @model_validator(mode="after")
    def _one_number_a_motor(self) -> Self:
        count = len(self.motors)
        most = MESSAGE_MOTORS.get(self.family, count)
        if count > most:
            raise fault(f"motors: {self.family} has {most}, got {count}")
        for joint in filter(None, self.motors):
            if self.motors.count(joint) > 1:
                raise fault(f"motors: {joint} is named twice; expected one motor a joint")
        for name in _OF_ALL_OR_EACH:
            value = getattr(self, name)
            if isinstance(value, tuple) and len(value) != count:
                raise fault(f"{name}: expected {count} numbers, one a motor, got {len(value)}")
        return self
