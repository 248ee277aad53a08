"""Table of a robot file for its drives: what a joint moves and loses beside the links."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from llsrbm.request.tables import Length, Positive, PositiveInterval, Table, fault

Source = Literal["measured", "published", "assumed"]
PerJoint = Length | Annotated[tuple[Length, ...], Field(min_length=1)]

# What is taken of drives of which nothing is stated, of each Nm (N) of their largest torque. Rotors
# behind their gears, of the robots here whose numbers are published: 1.2e-4 to 3.3e-4 s2; friction:
# 0.4 to 0.9 %; damping is left at what takes 1 % of the torque at the drive's largest speed.
ARMATURE_PER_TORQUE = 2e-4  # kg m2 per Nm, kg per N
FRICTION_PER_TORQUE = 0.01
DAMPING_PER_TORQUE = 0.01
DELAY = 1e-3  # s from a command to its torque: a bus at 1 kHz


class Losses(Table):
    """Numbers of joints: one for all of them, or one each, a limb's from the base outwards.

    Attributes:
        armature: inertia of the rotor as the joint feels it, rotor times gear squared, kg m2; of a
            sliding joint kg.
        friction: Coulomb friction, Nm or N.
        damping: viscous friction, Nm s/rad or N s/m.
    """

    armature: PerJoint | None = None
    friction: PerJoint | None = None
    damping: PerJoint | None = None


class OneJoint(Table):
    """Numbers of one joint, in place of its limb's."""

    armature: Length | None = None
    friction: Length | None = None
    damping: Length | None = None


class Sources(Table):
    """How the numbers are known: measured on such a robot, published by others, or assumed."""

    armature: Source = "assumed"
    friction: Source = "assumed"
    damping: Source = "assumed"
    delay: Source = "assumed"


OneOrEach = Positive | Annotated[tuple[Positive, ...], Field(min_length=1)]


class Motor(Table):
    """Windings of a limb's drives: one number for all joints, or one each from the base outwards.

    Attributes:
        torque_constant: Nm at the joint per ampere, of a sliding joint N per ampere.
        resistance: ohm of the winding; both as one phase carries the current that makes the torque.
        heat: J, largest heat in a winding over one motion; None: any.
    """

    torque_constant: OneOrEach
    resistance: OneOrEach
    heat: OneOrEach | None = None


class Electrical(Motor):
    """Windings of the legs' drives, and the battery with limits beyond which the robot cuts its
    power.

    Attributes:
        arms: the arms' windings; without, the legs' where those are single numbers.
        voltage: V of the battery.
        current: A, largest one that the battery gives; None: any.
        charge_current: A, largest one that it takes back; None: any.
    """

    arms: Motor | None = None
    voltage: Positive | None = None
    current: Positive | None = None
    charge_current: Positive | None = None

    @model_validator(mode="after")
    def _currents_at_a_voltage(self) -> Self:
        if self.voltage is None and not self.current is self.charge_current is None:
            raise fault("expected voltage beside current or charge_current")
        return self


class JointDrives(Losses):
    """The drives of a robot's joints.

    What is left out is assumed: see the constants above. Numbers of all legs, or with a list of one
    leg's joints.

    Attributes:
        delay: s from a command until its torque acts.
        arms: of the arms' joints; without, what is assumed.
        joints: joint name -> its own numbers, as `llsrbm identify` writes them.
        known: where the numbers are from.
        spread: share of the armature, either way, that differs from robot to robot.
        friction_range: lowest and highest friction on a real robot, shares of the file's.
        electrical: see there.
    """

    delay: Length | None = None
    arms: Losses = Losses()
    joints: dict[str, OneJoint] = Field(default_factory=dict)
    known: Sources = Sources()
    spread: Annotated[float, Field(ge=0, lt=1)] = 0.2
    friction_range: PositiveInterval = (0.5, 2.0)
    electrical: Electrical | None = None

    @model_validator(mode="after")
    def _known_as_stated(self) -> Self:
        for name in ("armature", "friction", "damping", "delay"):
            stated = getattr(self, name) is not None or any(
                getattr(joint, name, None) is not None for joint in self.joints.values()
            )
            if not stated and getattr(self.known, name) != "assumed":
                raise fault(f"known.{name}: expected {name} beside it, which is left out")
        return self
