"""`Rollout`: a simulation of the whole robot, one array a quantity, T control ticks; its file."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import IntEnum
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import pinocchio as pin
from pydantic import Field

from llsrbm.arrays import Array, IntArray
from llsrbm.errors import FileFormatError
from llsrbm.files.native import (
    Meta,
    StatedCertificate,
    check_phases,
    check_schema,
    check_times,
    native_arrays,
    part_of,
    read_meta,
)
from llsrbm.files.npz import LARGEST_NUMBER, Arrays, checked, write_archive
from llsrbm.files.quantity import (
    JOINT,
    LEG,
    POSITION,
    TIME,
    VELOCITY,
    Between,
    Quantity,
    attitude,
    coded,
    inertia_tensor,
    names,
    of_joints,
    quantities,
    vector,
)
from llsrbm.mechanics import rotation_matrices
from llsrbm.motion.of_robot import OfRobot
from llsrbm.motion.outcome import Outcome
from llsrbm.motion.plan import Plan
from llsrbm.motion.replan import Replan, replan_arrays, replans_from_arrays
from llsrbm.request.jump import Jump
from llsrbm.request.scenario import Push, Scenario
from llsrbm.request.schedule import Schedule
from llsrbm.robots.robot import Robot


class Mode(IntEnum):
    """The reference that the controller follows."""

    TRACKING = 0
    FORCE = 1


@dataclass(frozen=True)
class Disturbance:
    """Differences between the simulated world and the controller's belief.

    Attributes:
        trunk_mass_factor: of the simulated trunk, mass and inertia; the controller believes 1.
        friction: coefficient between feet and ground.
        contact_time: MuJoCo's time constant of a contact, s.
        torque_delay_ticks: control ticks by which torques arrive late, beside the drives' delay.
        armature_factor, joint_friction_factor: of the simulated drives' rotors and their friction
            and damping; the controller believes 1.
        base_velocity_noise, joint_velocity_noise: standard deviations of what is measured, m/s and
            rad/s.
        random_push: the push that was drawn, if any.
    """

    trunk_mass_factor: float = 1.0
    friction: float = 0.8
    contact_time: float = 0.006
    torque_delay_ticks: int = 0
    armature_factor: float = 1.0
    joint_friction_factor: float = 1.0
    base_velocity_noise: float = 0.0
    joint_velocity_noise: float = 0.0
    random_push: Push | None = None

    def mass(self, robot: Robot) -> float:
        """Total mass (kg) that is simulated of a robot that is believed to be `robot`."""
        trunk = float(robot.model.inertias[1].mass)
        return float(robot.mass) + (self.trunk_mass_factor - 1) * trunk

    def model(self, robot: Robot) -> pin.Model:
        """Likewise, Pinocchio's model: its trunk has more or less mass and inertia."""
        model, factor = robot.model.copy(), self.trunk_mass_factor
        trunk = model.inertias[1]
        model.inertias[1] = pin.Inertia(factor * trunk.mass, trunk.lever, factor * trunk.inertia)
        return model


@dataclass(frozen=True, eq=False, repr=False)
class Rollout(OfRobot):
    """A simulated jump at T control ticks: L legs, J joints.

    States are those at the beginning of a tick, torques and forces those of the tick that begins:
    momenta change by the recorded forces. The meaning of each array stands beside it; see
    `llsrbm.files.quantity`.

    Attributes:
        robot_parameters: the numbers of the robot that was simulated, as plain data.
        scenario, disturbance: the conditions, and what was drawn for them.
        plan: that was followed, the request in it as well.
        control_parameters: the controller's numbers that ran, as plain data: the robot file's
            [control] and [uncertainty] with their defaults.
        replans: in the order in which they were requested.
    """

    jump: Jump
    robot_parameters: dict[str, Any]
    scenario: Scenario
    disturbance: Disturbance
    outcome: Outcome
    time: Annotated[Array, Quantity((TIME,), "s", "evenly spaced", Between.LINEAR)]
    qpos: Annotated[
        Array,
        Quantity(
            *((TIME, POSITION), "m, rad", "MuJoCo's: position, w x y z, joints"),
            *(Between.POSE, "world"),
            listed=False,
        ),
    ]
    qvel: Annotated[
        Array,
        Quantity(
            *((TIME, VELOCITY), "m/s, rad/s", "MuJoCo's: linear (world), angular (base), joints"),
            *(Between.LINEAR, "world, base"),
            rate=True,
            listed=False,
        ),
    ]
    joint_names: Annotated[tuple[str, ...], names(JOINT, "order in qpos, qvel and torque")]
    torque: Annotated[
        Array,
        of_joints("Nm", "as applied, mean of the tick", Between.HELD, column="joint_torque"),
    ]
    torque_limit: Annotated[
        Array,
        of_joints(
            *("Nm", "of the drives at that speed, in the torque's direction", Between.HELD),
            column="joint_torque_limit",
        ),
    ]
    com: Annotated[Array, vector("m", "centre of mass")]
    base_quat: Annotated[Array, attitude("attitude of the URDF's root link")]
    base_position: Annotated[Array, vector("m", "origin of the URDF's root link")]
    linear_momentum: Annotated[Array, vector("kg m/s", "linear momentum", rate=True)]
    angular_momentum: Annotated[
        Array, vector("kg m2/s", "angular momentum about the CoM", rate=True)
    ]
    inertia: Annotated[Array, inertia_tensor("centroidal, of the whole body", Between.LINEAR)]
    foot_position: Annotated[
        Array, vector("m", "lowest point of a foot, of a sole its middle", of=LEG)
    ]
    contact: Annotated[
        IntArray,
        coded("of a foot with anything, the simulator's truth", "in the air", "touches", of=LEG),
    ]
    contact_force: Annotated[
        Array, vector("N", "sum over a foot, mean of the tick", Between.HELD, of=LEG)
    ]
    average_spatial_velocity_norm: Annotated[
        Array,
        Quantity(
            (TIME,),
            "m/s and rad/s",
            "norm of the average spatial velocity v_G as the controller measures it, in one norm "
            "as in the paper",
            Between.LINEAR,
        ),
    ]
    detection_signal: Annotated[
        Array, Quantity((TIME,), "the detector's", "the contact detector's signal", Between.HELD)
    ]
    detection_threshold: Annotated[
        float, Quantity((), "the detector's", "above it, contact is detected", listed=False)
    ]
    mode: Annotated[IntArray, coded("what the controller follows", "tracking", "force")]
    phase: Annotated[
        IntArray,
        coded("phase of the schedule, as the controller believes", coded_by="phase_names"),
    ]
    reference_com: Annotated[Array, vector("m", "tracked: centre of mass")]
    reference_base_quat: Annotated[Array, attitude("tracked: attitude of the base")]
    reference_foot_position: Annotated[Array, vector("m", "tracked: feet", of=LEG)]
    reference_angular_momentum: Annotated[
        Array, vector("kg m2/s", "tracked: angular momentum about the CoM", rate=True)
    ]
    plan: Plan
    control_parameters: dict[str, Any] = field(default_factory=dict)
    replans: tuple[Replan, ...] = ()
    certificate: StatedCertificate | None = None

    @property
    def pushes(self) -> tuple[Push, ...]:
        """Those that were stated, and the one that was drawn."""
        drawn = self.disturbance.random_push
        return (*self.scenario.pushes, *(() if drawn is None else (drawn,)))

    @property
    def base_velocity(self) -> Annotated[Array, vector("m/s", "velocity of the base's origin")]:
        """(T, 3) m/s, world frame."""
        return self.qvel[:, :3]

    @property
    def angular_velocity(self) -> Annotated[Array, vector("rad/s", "angular velocity of the base")]:
        """(T, 3) rad/s of the base, world frame; `qvel` has it in the base's axes."""
        return np.einsum("kij,kj->ki", rotation_matrices(self.base_quat), self.qvel[:, 3:6])

    @property
    def joint_position(self) -> Annotated[Array, of_joints("rad", "positions", Between.LINEAR)]:
        """(T, J) rad or m, in the order of `joint_names`."""
        return self.qpos[:, 7:]

    @property
    def joint_velocity(self) -> Annotated[Array, of_joints("rad/s", "velocities", Between.LINEAR)]:
        """(T, J) rad/s or m/s, in the order of `joint_names`."""
        return self.qvel[:, 6:]

    @property
    def schedule(self) -> Schedule:
        """The plan's."""
        return self.plan.schedule

    @property
    def duration(self) -> float:
        """From the first tick to the last, s."""
        return float(self.time[-1] - self.time[0])

    @property
    def landed(self) -> bool:
        """True if the robot stands at the end."""
        return self.outcome.status == "landed"

    def save(self, path: str | Path) -> None:
        """Write llsrbm.rollout/1: the rollout, its replans, and the plan under "plan/".

        Raises:
            InputError: the file cannot be written.
            Error: the rollout holds numbers that are not finite.
        """
        stated = {name: getattr(self, name) for name in _STATED}
        meta = _Meta(request=self.jump, model=self.jump.model, **stated)
        arrays = native_arrays(SCHEMA, meta, self, quantities(Rollout))
        arrays |= replan_arrays(self.replans)
        arrays |= {_PLAN + key: value for key, value in self.plan.arrays().items()}
        write_archive(path, arrays)

    @staticmethod
    def from_arrays(arrays: Arrays, path: str | Path) -> Rollout:
        """The rollout in an archive that has been read; `path` is for messages. Raises
        `FileFormatError`: of another schema, or a key is missing or holds something else.
        """
        check_schema(arrays, path, SCHEMA)
        meta = read_meta(_Meta, arrays, path)
        values: dict[str, Any] = checked(arrays, quantities(Rollout), path)
        check_times(values["time"], path)
        if not 0 < meta.outcome.control_rate_hz <= LARGEST_NUMBER:
            raise FileFormatError(f'{path}: key "meta": outcome.control_rate_hz: expected a rate')
        plan = Plan.from_arrays(part_of(arrays, _PLAN), f"{path}: {_PLAN}")
        legs = values["foot_position"].shape[1]
        of_plan = plan.jump, sorted(plan.joint_names), plan.foot_position.shape[1]
        if of_plan != (meta.request, sorted(values["joint_names"]), legs):
            raise FileFormatError(
                f"{path}: {_PLAN} is of another jump or robot than the rollout itself"
            )
        for key, root in (("qpos", 7), ("qvel", 6)):
            if values[key].shape[1] != root + len(values["joint_names"]):
                raise FileFormatError(
                    f'{path}: key "{key}": expected {root} + {len(values["joint_names"])} columns, '
                    f"one a joint, got {values[key].shape[1]}"
                )
        check_phases(values["phase"], plan.phase_names, path)
        values["detection_threshold"] = float(values["detection_threshold"])
        values["joint_names"] = tuple(str(name) for name in values["joint_names"])
        stated = {name: getattr(meta, name) for name in _STATED}
        replans = replans_from_arrays(arrays, legs, path)
        return Rollout(jump=meta.request, plan=plan, replans=replans, **stated, **values)


SCHEMA = "llsrbm.rollout/1"
# What stands at `meta` under its own name.
_STATED = (
    *("robot_parameters", "control_parameters", "scenario", "disturbance", "outcome"),
    "certificate",
)
_PLAN = "plan/"  # begins the keys of the plan that was followed


class _Meta(Meta):
    scenario: Scenario
    disturbance: Disturbance
    outcome: Outcome
    control_parameters: dict[str, Any] = Field(default_factory=dict)
